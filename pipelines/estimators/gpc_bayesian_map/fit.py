"""The fit: likelihood in a frequency band, weights from the residual's own spectrum, honest spread.

Offsets and drift lie below the band, what the model does not hold above it. The residual is neither white nor known before, so
that two passes over all of the drive learn its spectrum and a third runs through the intervals with it, (43)-(48). Corners share
their errors and a spectrum is an estimate too: the scatter of the blocks' scores says by how much the posterior is too narrow.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from pipelines.bayes.exact import densest, exact
from pipelines.bayes.priors import Normal, Priors
from pipelines.bayes.sequence import Choice, Found, domain_about, estimate
from pipelines.bayes.surrogate import Domain
from pipelines.estimators.base_excitation.blocks import (
    ComplexArray,
    block_covariance,
    normal_equations,
    smooth_spectrum,
)
from pipelines.estimators.gpc_bayesian_map.data import ModelData
from pipelines.estimators.gpc_bayesian_map.inputs_noise import noise_of_inputs, shift_by_inputs
from pipelines.models.record import Model
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity

FIRST_SHARE = 0.1
"""Share of an output's power that the first pass takes for noise."""

HOPELESS = 0.6
"""Share of what a model must explain below which the fit ends early."""

FAR_OFF = 0.25
"""Error of a surrogate's log likelihood over its posterior from which the model itself is run for the posterior."""

STEP_SHARE = 0.02
"""Steps of the derivatives at the MAP, in prior spreads, as far as these are narrow."""


@dataclass(frozen=True)
class Fit:
    """found: the last pass. explained: share of the outputs in the band that follows from the model. growth (d,): how much wider the
    blocks' scatter is than the posterior. shifts: what a standard deviation of each given figure moves (d,), by its key.
    residual (b, f, o): in the band. predicted (n, o): at the MAP, NaN outside of the blocks. power (f, o). All in coordinates.
    """

    found: Found
    explained: float
    growth: FloatArray
    shifts: Mapping[str, FloatArray]
    residual: ComplexArray
    predicted: FloatArray
    power: FloatArray
    runs: int


class Likelihood:
    """Normalised residuals of a model over blocks, for the engine."""

    def __init__(self, model: Model, data: ModelData, given: Mapping[str, float], priors: Priors):
        self.model, self.data, self.given, self.priors = model, data, dict(given), priors
        # the first pass knows the noise of no output better than by a share of what it shows
        self.power = (
            FIRST_SHARE
            * np.mean(np.abs(data.seen) ** 2, axis=(0, 1))[None, :]
            * np.ones((len(data.blocks.bins), 1))
        )
        self.power = np.maximum(self.power, 1e-300)

    def blocks_of(self, coordinates: FloatArray, groups: tuple[int, ...]) -> ComplexArray:
        """What the model leaves over in the blocks of these intervals, in the band: (Q, b, f, o)."""
        parts = []
        for group in groups:
            for first, past in self.data.groups[group]:
                parts.append(self._run(coordinates, first, past, self.given))
        return np.asarray(np.concatenate(parts, axis=1))

    def simulate(
        self, coordinates: FloatArray, first: int, past: int, given: Mapping[str, float]
    ) -> tuple[FloatArray, int]:
        """Outputs (Q, rows, o) over the blocks first .. past - 1, and the row that they begin with."""
        data, blocks = self.data, self.data.blocks
        begin = int(blocks.first[first])
        stop = int(blocks.first[past - 1]) + blocks.rows
        early = max(begin - data.settle, 0)
        values = self.priors.values(coordinates)
        out = self.model.predict(values, data.inputs[early:stop], data.step_s, given)
        return out[:, begin - early :], begin

    def _run(
        self, coordinates: FloatArray, first: int, past: int, given: Mapping[str, float]
    ) -> ComplexArray:
        blocks = self.data.blocks
        predicted, _ = self.simulate(coordinates, first, past, given)
        shape = (len(coordinates), past - first, blocks.rows, predicted.shape[2])
        cut = predicted.reshape(shape)
        spectrum = np.fft.rfft(cut, axis=2)[:, :, blocks.bins] / np.sqrt(blocks.rows)
        return np.asarray(self.data.seen[None, first:past] - spectrum)

    def normalised(self, coordinates: FloatArray, groups: tuple[int, ...]) -> FloatArray:
        """(Q, N) for the engine: real and imaginary parts, each of unit variance."""
        left = self.blocks_of(coordinates, groups) * np.sqrt(2 / self.power)
        flat = left.reshape(len(coordinates), -1)
        return np.concatenate((flat.real, flat.imag), axis=1)

    def everything(self) -> tuple[int, ...]:
        """All intervals."""
        return tuple(range(len(self.data.groups)))

    def slopes(self, place: FloatArray, step: FloatArray) -> ComplexArray:
        """Derivatives of the predictions at a point (d,), (d, b, f, o). step (d,): of the differences."""
        around = np.vstack((place + np.diag(step), place - np.diag(step)))
        left = self.blocks_of(around, self.everything())
        # residuals fall where predictions rise
        d = len(place)
        return np.asarray((left[d:] - left[:d]) / (2 * step[:, None, None, None]))

    def on(self, data: ModelData) -> Likelihood:
        """The same with other inputs."""
        other = copy(self)
        other.data = data
        return other

    def learn(self, coordinates: FloatArray) -> ComplexArray:
        """Take the residual's spectrum at a point (d,) for the noise's; returns the residual (b, f, o)."""
        left = self.blocks_of(coordinates[None], self.everything())[0]
        self.power = np.stack(
            [smooth_spectrum(left[:, :, o], self.data.blocks) for o in range(left.shape[2])], axis=-1
        )
        return np.asarray(left)

    def moved(self, coordinates: FloatArray, key: str, by: float) -> ComplexArray:
        """By how much the predictions change with a given figure, (b, f, o)."""
        other = {**self.given, key: self.given[key] + by}
        parts = [
            self._run(coordinates[None], a, b, self.given)[0] - self._run(coordinates[None], a, b, other)[0]
            for group in self.data.groups
            for a, b in group
        ]
        return np.concatenate(parts, axis=0)


def fit(
    model: Model,
    data: ModelData,
    priors: Priors,
    given: Mapping[str, Quantity],
    choice: Choice,
    rng: np.random.Generator,
) -> Fit:
    """Fit. Raises FloatingPointError where the model overflows within its priors, ExpansionError for too large an expansion."""
    likelihood = Likelihood(model, data, {key: q.value for key, q in given.items()}, priors)
    everything = likelihood.everything()

    def whole(coordinates: FloatArray, _: int) -> FloatArray:
        return likelihood.normalised(coordinates, everything)

    def part(coordinates: FloatArray, interval: int) -> FloatArray:
        return likelihood.normalised(coordinates, (interval,))

    start: Domain | None = None
    runs = 0
    for _ in range(2):
        first = estimate(priors, whole, 1, choice, rng, start=start)
        runs += first.runs * len(everything)
        place = priors.coordinates(first.posterior.map_value)
        if first.error > FAR_OFF:
            place = densest(priors, lambda c: likelihood.normalised(c, everything), place)
        likelihood.learn(place)
        start = domain_about(first.posterior, priors, blur=2.0)
    # a model that does not hold has a posterior of many hills: no use to follow it through the intervals
    hopeless = _explained(likelihood, place) < HOPELESS * model.least_explained
    found = first if hopeless else estimate(priors, part, len(everything), choice, rng)
    if found.error > FAR_OFF and not hopeless:
        told, close, more = exact(priors, lambda c: likelihood.normalised(c, everything), found.posterior)
        found = replace(found, posterior=told, error=0.0 if close else found.error)
        runs += more * len(everything)
    place = priors.coordinates(found.posterior.map_value)
    residual = likelihood.blocks_of(place[None], everything)[0]
    growth, shifts = _spread(likelihood, place, residual, given)
    explained = _explained(likelihood, place)
    predicted = np.full(data.outputs.shape, np.nan)
    for group in data.groups:
        for a, b in group:
            out, begin = likelihood.simulate(place[None], a, b, likelihood.given)
            predicted[begin : begin + out.shape[1]] = out[0]
    return Fit(found, explained, growth, shifts, residual, predicted, likelihood.power, runs + found.runs)


def _explained(likelihood: Likelihood, place: FloatArray) -> float:
    """Share of the outputs in the band, weighted, that follows from the model at a point (d,)."""
    left = likelihood.blocks_of(place[None], likelihood.everything())[0]
    seen = float(np.sum(np.abs(likelihood.data.seen) ** 2 / likelihood.power))
    return 1 - float(np.sum(np.abs(left) ** 2 / likelihood.power)) / max(seen, 1e-300)


def _spread(
    likelihood: Likelihood, place: FloatArray, residual: ComplexArray, given: Mapping[str, Quantity]
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Growth of the spread by the blocks' scatter, and what the given figures move."""
    d = len(place)
    prior = np.array([_precision(likelihood.priors, j, place) for j in range(d)])
    step = STEP_SHARE * np.minimum(1 / np.sqrt(np.maximum(prior, 1e-12)), 1.0)
    slopes = likelihood.slopes(place, step)
    information, score = np.zeros((d, d)), np.zeros((len(residual), d))
    for o in range(residual.shape[2]):
        power = likelihood.power[:, o]
        more, scores = normal_equations(slopes[..., o], residual[..., o], power)
        information += more
        score += scores
    prior_information = np.diag(prior)
    white, wide = block_covariance(information, prior_information, score)
    growth = np.sqrt(np.diag(wide) / np.diag(white))
    shifts = {}
    for key, quantity in given.items():
        if quantity.std > 0:
            changed = likelihood.moved(place, key, quantity.std)
            right = np.einsum("pbfo,bfo,fo->p", slopes.conj(), changed, 2 / likelihood.power).real
            shifts[key] = -np.linalg.solve(information + prior_information, right)
    if likelihood.model.noisy_inputs:
        std = noise_of_inputs(likelihood.data, likelihood.model.cutoff_hz)

        def on(data: ModelData, at: FloatArray) -> tuple[ComplexArray, ComplexArray]:
            again = likelihood.on(data)
            return again.slopes(at, step), again.blocks_of(at[None], again.everything())[0]

        shifts["noise of the inputs"] = shift_by_inputs(
            likelihood.data, std, on, likelihood.power, place, prior_information
        )
    return np.asarray(growth), shifts


def _precision(priors: Priors, j: int, place: FloatArray) -> float:
    """1 / variance of a prior in its coordinate: what keeps a direction from being unknown altogether."""
    item = priors.items[j]
    value = float(np.exp(place[j])) if item.log else 1.0
    std = item.distribution.std / value
    # an even prior bounds and does not pull: a tenth of what a normal one of its spread would
    return (1.0 if isinstance(item.distribution, Normal) else 0.1) / std**2
