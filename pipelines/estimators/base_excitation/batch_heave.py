"""Heave of a rigid body on four suspensions, whole drive at once: sprung mass and its place from eight accelerometers.

The four corner equations of Pence, Fathy & Stein (1) add up to

    m_f a_front + m_r a_rear + (M y/t) t alpha + sum_i [k_i x_i + d_i(x_i') + c sign(x_i')] = 0

a_front, a_rear: mean body acceleration over an axle; alpha: roll acceleration (left minus right over the track); m_f = M (1 - x/L), m_r = M x/L. No
inertia appears, anti-roll bars cancel, pitch and roll moments (braking, cornering) cancel: what is left is the sprung mass,
how far it lies behind the front axle and left of the middle, and the dampers. A corner on its own would give an apparent mass
that holds parts of the inertias.

x' and x are integrals of measured acceleration differences, taken by frequency above HIGH_PASS_HZ (the same for all columns,
which keeps the sum exact for linear parts). All columns are noisy then, so that plain least squares would be low: the
noise's own share is taken out of the normal equations (compensated least squares), at the level that the residual shows,
and the weight is the residual's smooth spectrum, as for one corner. Gain and delay of the body's against the hubs'
accelerometers are parameters with priors; each accelerometer's own gain goes into the spread.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.base_excitation.batch_corner import Nuisance
from pipelines.estimators.base_excitation.blocks import (
    Blocks,
    ComplexArray,
    block_covariance,
    lay_blocks,
    noise_floor,
    smooth_spectrum,
)
from pipelines.estimators.base_excitation.data import AXLES, RideData
from pipelines.results import FloatArray

NAMES = (
    "mass_front", "mass_rear", "mass_lateral",
    "front_extension", "front_compression", "rear_extension", "rear_compression", "friction",
    "front_hardening", "rear_hardening", "gain", "delay",
)  # fmt: skip
HIGH_PASS_HZ = 0.35
SETTLE_S = 5.0
ENOUGH_BLOCKS = 5
"""Integrals: high-pass, whose memory of a stretch's ends is 4e-4 after the seconds that are left out there."""
STEPS = 6
STICK_MPS = 0.01
FRICTION, HARDENING, GAIN, DELAY = 7, 8, 10, 11
LINEAR = slice(0, GAIN)
HARDENING_STD = 1.0
DEEP = 1.2
"""How much stiffer deep compression may be, as a share of the spring rate (progressive springs, bump stops); where deep
begins, in standard deviations of the axle's deflection."""

SENSORS = 8
NOISE_LEVEL_STD = 0.03
"""How well the variance of the accelerometers' noise is told by the residual, as a share of it."""


@dataclass(frozen=True)
class HeaveFit:
    """values: (12,) in the order of NAMES (kg, N s/m, N, share, s; mass_lateral = M y / track). covariance: of chance and
    priors. spring_slopes: values' change per 1 of relative change of the front and rear springs (2, 12). scores (b, 12)
    and informations (b, 12, 12) by block, for running estimates. clarity: share of the axle masses' information that is
    not accelerometer noise (the lower one). residual, fitted: (n,) forces in N, NaN outside blocks.
    """

    values: FloatArray
    covariance: FloatArray
    spring_slopes: FloatArray
    blocks: Blocks
    scores: FloatArray
    informations: FloatArray
    residual: FloatArray
    fitted: FloatArray
    explained: float
    noise_mps2: float
    clarity: float

    @property
    def plausible(self) -> bool:
        """Whether masses and dampers are what a vehicle may have."""
        return bool(np.all(self.values[:2] > 0) and np.sum(self.values[3:7]) > 0)

    @property
    def sprung_kg(self) -> float:
        """The whole sprung mass."""
        return float(self.values[0] + self.values[1])


@dataclass(frozen=True)
class _Columns:
    """regressors: 12 columns, spring: (n, 2) spring force per axle, gains: each sensor's part of the sum."""

    regressors: list[FloatArray]
    spring: list[FloatArray]
    own_gain: list[FloatArray]
    extending: float
    deep: tuple[float, float]


def _integrals(
    column: FloatArray, data: RideData, delay_s: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The column, its first and its second integral, all above HIGH_PASS_HZ and `delay_s` earlier; (n,) each."""
    outs = (np.zeros_like(column), np.zeros_like(column), np.zeros_like(column))
    for start, stop in data.stretches:
        n = stop - start
        f = np.fft.rfftfreq(n, 1 / data.rate_hz)
        s = 2j * np.pi * np.where(f > 0, f, 1.0)
        keep = f**4 / (f**4 + HIGH_PASS_HZ**4) * np.exp(2j * np.pi * f * delay_s)
        spectrum = np.fft.rfft(column[start:stop]) * keep
        for out, part in zip(outs, (spectrum, spectrum / s, spectrum / s**2), strict=True):
            out[start:stop] = np.fft.irfft(part, n)
    return outs


class _Heave:
    """The linear problem at given gain, delay and dampers."""

    def __init__(self, data: RideData):
        self.data = data
        self.body = {w: _integrals(data.sprung[w], data, 0.0) for w in data.corners}

    def columns(self, values: FloatArray) -> _Columns:
        """Regressors at the values' gain and delay; those of gain and delay themselves at the values' dampers."""
        data, gain = self.data, 1 + float(values[GAIN])
        hub = {w: _integrals(gain * data.unsprung[w], data, float(values[DELAY])) for w in data.corners}
        masses, dampers, springs, own, hards = [], [], [], [], []
        deep = [0.0, 0.0]
        friction = np.zeros_like(self.body["fl"][0])
        by_gain, by_delay = friction.copy(), friction.copy()
        extending = 0.0
        roll = sum((self.body[p[0]][0] - self.body[p[1]][0]) / 2 for p in AXLES.values())
        for number, pair in enumerate(AXLES.values()):
            masses.append((self.body[pair[0]][0] + self.body[pair[1]][0]) / 2)
            out, back, spring = np.zeros_like(friction), np.zeros_like(friction), np.zeros_like(friction)
            apart = {w: self.body[w][2] - hub[w][2] for w in pair}
            begin = DEEP * math.sqrt(sum(float(np.var(x)) for x in apart.values()) / 2)
            hard = np.zeros_like(friction)
            for side, w in zip((1.0, -1.0), pair, strict=True):
                k = data.springs[w].value
                beyond = np.minimum(apart[w] + begin, 0.0)
                hard += k * beyond
                deep[number] += float(np.mean(beyond < 0)) / 2
                v = self.body[w][1] - hub[w][1]
                ext = v > 0
                extending += float(np.mean(ext)) / 4
                out += np.where(ext, v, 0.0)
                back += np.where(ext, 0.0, v)
                spring += k * apart[w]
                friction += np.tanh(v / STICK_MPS)
                slope = np.where(ext, values[3 + 2 * number], values[4 + 2 * number])
                of_hub = k * hub[w][2] + slope * hub[w][1]
                by_gain -= of_hub / gain
                by_delay -= k * hub[w][1] + slope * hub[w][0]
                of_body = k * self.body[w][2] + slope * self.body[w][1]
                of_mass = (values[number] + side * values[2]) / 2 * self.body[w][0]
                own += [of_body + of_mass, -of_hub]
            dampers += [out, back]
            springs.append(spring)
            hards.append(hard)
        regressors = [*masses, np.asarray(roll), *dampers, friction, *hards, by_gain, by_delay]
        return _Columns(regressors, springs, own, extending, (deep[0], deep[1]))

    def noise_gains(self, blocks: Blocks, columns: _Columns, values: FloatArray) -> ComplexArray:
        """What a unit of noise in each of the 8 accelerometers (body, hub; wheel by wheel) puts into the 12 regressors
        and, last, the springs' sum, the dampers by their share of time; (13, 8, f)."""
        f, extending = blocks.frequency_hz, columns.extending
        s = 2j * np.pi * f
        out = np.zeros((len(NAMES) + 1, SENSORS, len(f)), dtype=np.complex128)
        place = 0
        for number, pair in enumerate(AXLES.values()):
            for side, w in zip((1.0, -1.0), pair, strict=True):
                k = self.data.springs[w].value
                damper = extending * values[3 + 2 * number] + (1 - extending) * values[4 + 2 * number]
                out[GAIN, place + 1] = -(k / s**2 + damper / s)
                out[DELAY, place + 1] = -(k / s + damper)
                out[number, place] = 0.5
                out[2, place] = 0.5 * side
                for sensor, sign in ((place, 1.0), (place + 1, -1.0)):
                    out[3 + 2 * number, sensor] = sign * extending / s
                    out[4 + 2 * number, sensor] = sign * (1 - extending) / s
                    out[HARDENING + number, sensor] = sign * columns.deep[number] * k / s**2
                    out[-1, sensor] = sign * k / s**2
                place += 2
        return out * (f**4 / (f**4 + HIGH_PASS_HZ**4))


def _first_values(data: RideData) -> FloatArray:
    """A plain suspension to begin with: 1.4 Hz, a third of critical damping."""
    values = np.zeros(len(NAMES))
    for number, pair in enumerate(AXLES.values()):
        k = sum(data.springs[w].value for w in pair)
        values[number] = k / (2 * math.pi * 1.4) ** 2
        values[3 + 2 * number : 5 + 2 * number] = 0.33 * math.sqrt(k * values[number])
    return values


def _lively_blocks(data: RideData, block_s: float, band_hz: tuple[float, float]) -> Blocks:
    settle = round(SETTLE_S * data.rate_hz)
    stretches = [(start + settle, stop - settle) for start, stop in data.stretches]
    stretches = [p for p in stretches if p[1] > p[0]]
    blocks = _only_lively(lay_blocks(stretches, data.rate_hz, block_s, band_hz), data)
    if blocks.count >= ENOUGH_BLOCKS:
        return blocks
    # a log with many gaps or a short one: shorter blocks use more of it
    shorter = _only_lively(lay_blocks(stretches, data.rate_hz, block_s / 2, band_hz), data)
    return shorter if shorter.count > blocks.count else blocks


def _only_lively(blocks: Blocks, data: RideData) -> Blocks:
    """The blocks half of which the hubs move enough."""
    return blocks.only(np.mean(blocks.cut(data.lively.astype(float)), axis=1) >= 0.5)


def _noise_power(gains: ComplexArray, values: FloatArray) -> FloatArray:
    """Power by frequency of the sum's noise for accelerometers of unit variance, (f,)."""
    mixed = np.tensordot(values[LINEAR], gains[LINEAR], axes=(0, 0)) + gains[-1]
    return np.asarray(np.sum(np.abs(mixed) ** 2, axis=0))


def fit_heave(
    data: RideData,
    nuisance: Nuisance,
    *,
    block_s: float = 10.0,
    band_hz: tuple[float, float] = (0.4, 25.0),
) -> HeaveFit | None:
    """Fit. Needs all four corners in `data`. None where fewer than three lively blocks fit into the drive."""
    blocks = _lively_blocks(data, block_s, band_hz)
    if blocks.count < 3 or len(blocks.bins) < 8:
        return None
    problem = _Heave(data)
    prior = np.zeros(len(NAMES))
    stds: Mapping[int, float] = {
        FRICTION: nuisance.friction_std_n,
        HARDENING: HARDENING_STD,
        HARDENING + 1: HARDENING_STD,
        GAIN: nuisance.gain_std,
        DELAY: nuisance.delay_std_s,
    }
    free = [i for i in range(len(NAMES)) if stds.get(i, 1.0) > 0]
    for i, std in stds.items():
        prior[i] = 1 / max(std, 1e-12) ** 2
    values = _first_values(data)
    power: FloatArray | None = None
    for _ in range(STEPS):
        round_ = _Round(problem, blocks, values, power)
        values = round_.solved(values, prior, free)
        power = smooth_spectrum(round_.residual(values), blocks)
    last = _Round(problem, blocks, values, power)
    return _finished(last, data, values, prior, free, nuisance)


class _Round:
    """Normal equations of one step."""

    def __init__(self, problem: _Heave, blocks: Blocks, values: FloatArray, power: FloatArray | None):
        self.blocks = blocks
        self.columns = problem.columns(values)
        self.gains = problem.noise_gains(blocks, self.columns, values)
        self.seen = np.stack([blocks.seen(c) for c in self.columns.regressors])
        self.spring = np.stack([blocks.seen(c) for c in self.columns.spring])
        unit = _noise_power(self.gains, values)
        self.power = unit if power is None else power
        # the level of accelerometer noise that the residual shows: nothing below it can be noise
        self.noise = 0.0 if power is None else noise_floor(power / unit, blocks)
        self.values = values

    def residual(self, values: FloatArray) -> ComplexArray:
        """The sum of all forces in the band, (b, f); gain and delay as moved from where the columns stand."""
        moved = values.copy()
        moved[GAIN:] -= self.values[GAIN:]
        return np.asarray(np.tensordot(moved, self.seen, axes=(0, 0)) + self.spring.sum(axis=0))

    def equations(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Information (12, 12) and right-hand sides for the springs of both axles (12, 2), without the noise's share;
        and each block's information (b, 12, 12)."""
        weighted = self.seen.conj() * (2 / self.power)
        per_block = np.einsum("pbf,qbf->bpq", weighted, self.seen).real
        right = np.einsum("pbf,sbf->ps", weighted, self.spring).real
        information = per_block.sum(axis=0)
        count = self.blocks.count
        columns = self.gains[:-1]
        cross = np.einsum("psf,qsf,f->pq", columns.conj(), columns, 2 / self.power).real
        information -= count * self.noise * cross
        springs = [share_of_axle(self.gains, self.power, number) for number in range(2)]
        right -= count * self.noise * np.stack(springs, axis=1)
        return information, right, per_block

    def solved(self, values: FloatArray, prior: FloatArray, free: list[int]) -> FloatArray:
        """The values that make the sum of forces smallest."""
        information, right, _ = self.equations()
        target = -right.sum(axis=1)
        # gain and delay enter as steps from where the columns stand, their priors as values
        standing = np.zeros(len(values))
        standing[GAIN:] = values[GAIN:]
        target -= prior * standing
        matrix = (information + np.diag(prior))[np.ix_(free, free)]
        out = values.copy()
        step = np.linalg.solve(matrix, target[free])
        out[free] = step + standing[free]
        return out


def _positive(matrix: FloatArray) -> bool:
    """Whether a symmetric matrix, scaled to a diagonal of ones, is positive definite."""
    diagonal = np.diag(matrix)
    if not np.all(diagonal > 0):
        return False
    scale = np.sqrt(diagonal)
    return bool(np.linalg.eigvalsh(matrix / np.outer(scale, scale))[0] > 1e-9)


def share_of_axle(gains: ComplexArray, power: FloatArray, number: int) -> FloatArray:
    """The noise that the regressors have in common with the springs of one axle, summed over the band, (12,)."""
    own = slice(4 * number, 4 * number + 4)
    return np.asarray(np.einsum("psf,sf,f->p", gains[:-1, own].conj(), gains[-1, own], 2 / power).real)


def _finished(
    last: _Round, data: RideData, values: FloatArray, prior: FloatArray, free: list[int], nuisance: Nuisance
) -> HeaveFit:
    """Spread and figures of the last step."""
    residual = last.residual(values)
    information, right, per_block = last.equations()
    share = (per_block.sum(axis=0) - information) / last.blocks.count
    weighted = last.seen.conj() * (2 / last.power)
    noise_right = (np.einsum("pbf,sbf->ps", weighted, last.spring).real - right).sum(axis=1)
    score = -np.einsum("pbf,bf->bp", weighted, residual).real
    linear = np.where(np.arange(len(values)) < GAIN, values, 0.0)
    score += share @ linear + noise_right / last.blocks.count
    pick = np.ix_(free, free)
    clarity = float(np.min(np.diag(information)[:2] / np.diag(per_block.sum(axis=0))[:2]))
    if not _positive((information + np.diag(prior))[pick]):
        # more noise was taken out than there is information: nothing can be told
        information, clarity = per_block.sum(axis=0), 0.0
    _, wide = block_covariance(information[pick], np.diag(prior)[pick], score[:, free])
    inverse = np.linalg.inv((information + np.diag(prior))[pick])
    size = len(values)
    covariance, slopes = np.zeros((size, size)), np.zeros((2, size))
    covariance[pick] = wide
    slopes[:, free] = -(inverse @ right[free]).T
    # the noise's level is an estimate too
    level = inverse @ (last.blocks.count * share @ linear + noise_right)[free] * NOISE_LEVEL_STD
    covariance[pick] += np.outer(level, level)
    own = np.stack([last.blocks.seen(c) for c in last.columns.own_gain])
    moved = inverse @ np.einsum("pbf,sbf->ps", weighted, own).real[free]
    covariance[pick] += nuisance.gain_std**2 * moved @ moved.T
    rows = last.blocks.first[:, None] + np.arange(last.blocks.rows)
    spring = np.asarray(sum(last.columns.spring))
    total = spring + sum(v * c for v, c in zip(values[LINEAR], last.columns.regressors[LINEAR], strict=True))
    off, fitted = np.full(len(spring), np.nan), np.full(len(spring), np.nan)
    inertia = sum(v * c for v, c in zip(values[:3], last.columns.regressors[:3], strict=True))
    off[rows], fitted[rows] = np.asarray(total)[rows], np.asarray(inertia)[rows]
    forces = float(np.sum(np.abs(last.spring.sum(axis=0)) ** 2 / last.power))
    explained = 1 - float(np.sum(np.abs(residual) ** 2 / last.power)) / max(forces, 1e-30)
    return HeaveFit(
        values, covariance, slopes, last.blocks, score, per_block, off, fitted, explained, math.sqrt(last.noise),
        clarity,
    )  # fmt: skip
