"""Output error on one corner: mass and both damper slopes from hub and body acceleration, whole drive at once.

The measured hub acceleration drives the model (pipelines/models/base_excitation.py), its body acceleration is compared
with the measured one. The hub's noise goes through the suspension and comes back in the residual e = n_s - G n_u, which
is therefore coloured: Gauss-Newton in a frequency band with the residual's own smooth spectrum as its weight. Gain and
delay of the body's accelerometer against the hub's, and friction, are parameters with priors.

The simulated slopes carry the hub's noise too, which is correlated with the residual: its share in the score,
sum conj(G_j) G sigma_u² / S, is taken out, or the mass is 0.06 % high on the paper's set-up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.base_excitation.blocks import (
    Blocks,
    ComplexArray,
    block_covariance,
    lay_blocks,
    noise_floor,
    normal_equations,
    smooth_spectrum,
)
from pipelines.models.base_excitation import between_samples, body_response, response_gain
from pipelines.results import FloatArray

NAMES = ("log_mass", "extension", "compression", "friction", "gain", "delay")
STEPS = 12
SETTLED = 0.02
SETTLE_S = 3.0
"""Most Gauss-Newton steps; a step below this share of all standard deviations ends them; s left out at a start."""

FREQUENCIES_HZ = (0.3, 5.0)
"""Natural frequencies that a body on its springs may have."""


@dataclass(frozen=True)
class Corner:
    """What is measured and known of one corner. sprung, unsprung: (n,) accelerations in m/s², gaps between stretches.

    lively: (n,) where the hub moves enough for a block to be used; None: everywhere.
    """

    sprung: FloatArray
    unsprung: FloatArray
    stretches: Sequence[tuple[int, int]]
    rate_hz: float
    spring_npm: float
    lively: np.ndarray | None = None


@dataclass(frozen=True)
class Nuisance:
    """Prior standard deviations; 0 pins the parameter. delay in s, friction in N."""

    gain_std: float = 0.005
    delay_std_s: float = 0.005
    friction_std_n: float = 100.0


@dataclass(frozen=True)
class CornerFit:
    """The fit in the order of NAMES: damping N·s/m, friction N, gain relative to 1, delay in s (+ body comes late).

    white: covariance for noise as modelled; covariance: widened to the blocks' scatter. explained: share of the body
    acceleration's power in the band. blocks, scores (b, p), information (p, p): for running estimates.
    """

    values: FloatArray
    covariance: FloatArray
    white: FloatArray
    free: tuple[int, ...]
    steps: int
    converged: bool
    explained: float
    noise_mps2: float
    blocks: Blocks
    scores: FloatArray
    informations: FloatArray
    response: FloatArray
    measured: FloatArray
    at_bound: bool

    @property
    def mass_kg(self) -> float:
        """The corner's sprung mass."""
        return math.exp(self.values[0])

    @property
    def relative_std(self) -> float:
        """Standard deviation of the mass, as a share of it (springs taken as exact)."""
        return math.sqrt(self.covariance[0, 0])


class _Problem:
    """Residuals and slopes at a parameter vector."""

    def __init__(self, corner: Corner, nuisance: Nuisance, length_s: float, band_hz: tuple[float, float]):
        self.corner = corner
        self.step_s = 1 / corner.rate_hz
        self.prior = np.array([
            np.inf, np.inf, np.inf, nuisance.friction_std_n, nuisance.gain_std, nuisance.delay_std_s,
        ])  # fmt: skip
        self.free = tuple(int(i) for i in np.flatnonzero(self.prior > 0))
        settle = round(SETTLE_S * corner.rate_hz)
        late = [(start + settle, stop) for start, stop in corner.stretches]
        blocks = lay_blocks(late, corner.rate_hz, length_s, band_hz)
        if corner.lively is not None:
            blocks = blocks.only(np.mean(blocks.cut(corner.lively.astype(float)), axis=1) >= 0.5)
        self.blocks = blocks
        self.middle = {
            start: between_samples(corner.unsprung[start:stop]) for start, stop in corner.stretches
        }
        self.measured = self.blocks.seen(corner.sprung)
        critical = math.sqrt(corner.spring_npm * self.mass_range()[0])
        self.scale = np.array([1.0, critical, critical, 100.0, 1.0, 0.001])

    def mass_range(self) -> tuple[float, float]:
        """Masses whose natural frequency a vehicle may have."""
        high, low = (self.corner.spring_npm / (2 * math.pi * f) ** 2 for f in FREQUENCIES_HZ)
        return low, high

    def response(self, values: FloatArray) -> FloatArray:
        """The body's acceleration, simulated stretch by stretch, (n,)."""
        c = self.corner
        out = np.zeros(len(c.sprung))
        mass, damping = math.exp(values[0]), (float(values[1]), float(values[2]))
        for start, stop in c.stretches:
            out[start:stop] = body_response(
                c.unsprung[start:stop], self.step_s, mass, c.spring_npm, damping, float(values[3]), self.middle[start]
            )  # fmt: skip
        return out

    def reading(self, values: FloatArray, response: FloatArray) -> ComplexArray:
        """What the body's accelerometer should read, with its gain and delay, (b, f)."""
        late = response if values[5] == 0 else self._late(response, float(values[5]))
        return np.asarray((1 + values[4]) * self.blocks.seen(late))

    def _late(self, column: FloatArray, delay_s: float) -> FloatArray:
        """The column `delay_s` later, whole stretches at once: a block alone would wrap round at its edges."""
        out = np.zeros(len(column))
        for start, stop in self.corner.stretches:
            spectrum = np.fft.rfft(column[start:stop])
            turn = np.exp(-2j * np.pi * np.fft.rfftfreq(stop - start, self.step_s) * delay_s)
            out[start:stop] = np.fft.irfft(spectrum * turn, stop - start)
        return out

    def slopes(self, values: FloatArray, here: _Round) -> ComplexArray:
        """Derivatives of the modelled reading by the free parameters (p, b, f), in units of `scale`."""
        found = []
        for i in self.free:
            moved = values.copy()
            moved[i] += 1e-4 * self.scale[i]
            response = here.response if i > 3 else self.response(moved)
            found.append((self.reading(moved, response) - here.reading) / 1e-4)
        return np.stack(found)

    def input_noise_score(self, values: FloatArray, noise: float, power: FloatArray) -> FloatArray:
        """What the hub's noise of variance `noise` puts into each block's score, by the linear model, (p,)."""
        f, k = self.blocks.frequency_hz, self.corner.spring_npm

        def gain(v: FloatArray) -> ComplexArray:
            return response_gain(f, math.exp(v[0]), k, float(v[1] + v[2]) / 2)

        here = gain(values)
        out = np.zeros(len(self.free))
        for place, i in enumerate(self.free):
            if i < 3:
                moved = values.copy()
                moved[i] += 1e-4 * self.scale[i]
                slope = (gain(moved) - here) / 1e-4
            elif i == 4:
                slope = here
            else:
                continue
            out[place] = -2 * noise * float(np.sum((slope.conj() * here).real / power))
        return out


def _bounded(values: FloatArray, problem: _Problem) -> FloatArray:
    """Values kept where a suspension can be."""
    low, high = problem.mass_range()
    out = values.copy()
    out[0] = min(max(out[0], math.log(low)), math.log(high))
    critical = 2 * math.sqrt(problem.corner.spring_npm * math.exp(out[0]))
    out[1:3] = np.clip(out[1:3], 0.005 * critical, 3 * critical)
    # friction may come out below zero by chance: a wall at zero would push the mass to one side
    out[3:] = np.clip(out[3:], -5 * problem.prior[3:], 5 * problem.prior[3:])
    return out


@dataclass(frozen=True)
class _Round:
    """One evaluation: residual (b, f), its power (f,), and the model's response (n,)."""

    residual: ComplexArray
    power: FloatArray
    response: FloatArray
    reading: ComplexArray


def _evaluate(problem: _Problem, values: FloatArray) -> _Round:
    response = problem.response(values)
    reading = problem.reading(values, response)
    residual = problem.measured - reading
    return _Round(residual, smooth_spectrum(residual, problem.blocks), response, reading)


def _log_power(one: _Round) -> float:
    """What is to be made small: the likelihood of noise whose spectrum is free."""
    return float(np.mean(np.log(one.power)))


def _start(problem: _Problem, guess: tuple[float, float] | None) -> FloatArray:
    """The best of some plain starts: natural frequencies from low to high at a usual damping, and the guess."""
    low, high = problem.mass_range()
    masses = list(np.geomspace(1.5 * low, high / 1.5, 7))
    pairs = [(m, 0.6 * math.sqrt(problem.corner.spring_npm * m)) for m in masses]
    if guess is not None and low < guess[0] < high and guess[1] > 0:
        pairs.append(guess)
    starts = [_bounded(np.array([math.log(m), b, b, 0.0, 0.0, 0.0]), problem) for m, b in pairs]
    # plain power, not its logarithm: far from the answer the spectrum's shape says little
    return min(starts, key=lambda v: float(np.sum(np.abs(_evaluate(problem, v).residual) ** 2)))


def fit_corner(
    corner: Corner,
    nuisance: Nuisance,
    *,
    block_s: float = 10.0,
    band_hz: tuple[float, float] = (0.3, 30.0),
    guess: tuple[float, float] | None = None,
) -> CornerFit | None:
    """Fit one corner. guess: mass and damping to start from. None where fewer than three blocks fit into the drive."""
    problem = _Problem(corner, nuisance, block_s, band_hz)
    if problem.blocks.count < 3 or len(problem.blocks.bins) < 8:
        return None
    free = list(problem.free)
    weight = np.diag((problem.scale[free] / problem.prior[free]) ** 2)
    values = _start(problem, guess)
    here = _evaluate(problem, values)
    steps, converged = 0, False
    while steps < STEPS and not converged:
        steps += 1
        information, score, per_block = _linearise(problem, values, here)
        pull = weight @ (values[free] / problem.scale[free])
        total = information + weight
        move = np.linalg.solve(total, score.sum(axis=0) - pull)
        small = float(np.max(np.abs(move) * np.sqrt(np.diag(total))))
        share = 1.0
        for _ in range(6):
            tried = values.copy()
            tried[free] += share * move * problem.scale[free]
            tried = _bounded(tried, problem)
            there = _evaluate(problem, tried)
            if _log_power(there) <= _log_power(here) + 1e-4:
                break
            share /= 2
        values, here = tried, there
        converged = small < SETTLED
    information, score, per_block = _linearise(problem, values, here)
    white, wide = block_covariance(information, weight, score)
    scale = np.outer(problem.scale[free], problem.scale[free])
    size = len(NAMES)
    full_white, full = np.zeros((size, size)), np.zeros((size, size))
    full_white[np.ix_(free, free)], full[np.ix_(free, free)] = white * scale, wide * scale
    measured = float(np.sum(np.abs(problem.measured) ** 2))
    explained = 1 - float(np.sum(np.abs(here.residual) ** 2)) / max(measured, 1e-30)
    noise = math.sqrt(noise_floor(here.power, problem.blocks))
    low, high = problem.mass_range()
    at_bound = not 1.02 * low < math.exp(values[0]) < high / 1.02
    return CornerFit(
        values, full, full_white, problem.free, steps, converged, explained, noise, problem.blocks,
        score / problem.scale[free], per_block / scale, here.response, corner.sprung, at_bound,
    )  # fmt: skip


def _linearise(
    problem: _Problem, values: FloatArray, here: _Round
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Information (p, p), scores (b, p) without the input noise's share, and each block's information (b, p, p)."""
    slopes = problem.slopes(values, here)
    information, score = normal_equations(slopes, here.residual, here.power)
    noise = noise_floor(here.power, problem.blocks)
    score = score - problem.input_noise_score(values, noise, here.power)
    per_block = np.einsum("pbf,qbf->bpq", slopes.conj() * (2 / here.power), slopes).real
    return information, score, np.asarray(per_block)
