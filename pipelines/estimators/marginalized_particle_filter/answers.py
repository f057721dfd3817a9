"""Parameters, tracks and whole distributions from the coefficients, by the second stage of `roll_map`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.marginalized_particle_filter.coefficients import honest, inflation, pooled, wander
from pipelines.estimators.marginalized_particle_filter.inputs import Inputs
from pipelines.estimators.marginalized_particle_filter.run import Clouds
from pipelines.estimators.roll_map.answers import Coefficients, likelihood_of
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.posterior import quantiles, sample_posterior
from pipelines.estimators.roll_map.vehicle import VehiclePart, explain_vehicle, usable
from pipelines.results import Distribution, FloatArray, ParameterEstimate, Track
from pipelines.vehicles.vehicle import Vehicle

NAME = "marginalized_particle_filter"
MODEL = ("roll_stiffness_nmprad", "roll_damping_nmsprad", "cg_height_m")
"""The paper's K, D and h by cogest's names."""

GIVEN = (*MODEL, "roll_gradient_degpg")
LEVELS = (
    0.01,
    0.025,
    0.05,
    0.1,
    0.175,
    0.25,
    0.325,
    0.4,
    0.5,
    0.6,
    0.675,
    0.75,
    0.825,
    0.9,
    0.95,
    0.975,
    0.99,
)
TRACK_DRAWS = 4000
FEWEST_EFFECTIVE = 40.0
NOTE = (
    "Particle filter: of the vehicle that follows from its particles, with mass, inertia and tyres from the vehicle file or from "
    "measured vehicles, and the roll model's own error"
)


@dataclass(frozen=True)
class Over:
    """What the clouds say over the drive. rows: (s,) of the excited rows; coefficients: of each."""

    rows: FloatArray
    coefficients: tuple[Coefficients, ...]


def over_the_drive(
    clouds: Clouds, data: RollData, inputs: Inputs, scale_std: float
) -> tuple[Over, Coefficients]:
    """Coefficients at each kept row that all clouds have, and at the end."""
    rows, found = [], []
    for row in clouds.snapshots.tolist():
        there = [run.snapshots[row] for run in clouds.runs if row in run.snapshots]
        if len(there) == len(clouds.runs):
            rows.append(row)
            found.append(pooled(there))
    last = pooled([run.final for run in clouds.runs])
    factor = inflation(clouds, inputs.step_s)
    strayed = wander(np.array([mean for mean, _ in found]).reshape(-1, 3), last[0])

    def made(pair: tuple[FloatArray, FloatArray]) -> Coefficients:
        return honest(pair[0], factor * pair[1] + strayed, data, inputs, scale_std)

    return Over(np.array(rows), tuple(made(pair) for pair in found)), made(last)


def _reason(estimate: ParameterEstimate) -> ParameterEstimate:
    words = f"by particles: {estimate.reason}"
    sources = tuple(NAME if source == "roll_map" else source for source in estimate.sources)
    return replace(estimate, reason=words, sources=sources)


def answers(
    before: VehiclePart,
    coefficients: Coefficients,
    data: RollData,
    vehicle: Vehicle,
    rng: np.random.Generator,
) -> tuple[dict[str, ParameterEstimate], dict[str, float], tuple[str, ...]]:
    """The filter's parameters, figures and sentences."""
    found, figures, sentences = explain_vehicle(before, coefficients, data, vehicle, rng)
    missing = before.unknown(GIVEN, "the filter's particles do not tell it", vehicle.reference)
    chosen = {name: found.get(name, missing[name]) for name in GIVEN}
    for name, estimate in chosen.items():
        prior = estimate.prior
        if estimate.status == "not_identifiable" and prior is not None and (estimate.std or 0.0) > prior.std:
            chosen[name] = before.unknown([name], estimate.reason, vehicle.reference)[name]
    return {name: _reason(estimate) for name, estimate in chosen.items()}, figures, sentences


def distributions(
    over: Over, before: VehiclePart, data: RollData, time_s: FloatArray, rng: np.random.Generator
) -> tuple[Distribution, ...]:
    """K, D and h over the drive. time_s: (s,) of `over.rows`."""
    few = before.fewer(TRACK_DRAWS)
    table = np.full((len(MODEL), len(LEVELS), len(over.rows)), np.nan)
    for column, coefficients in enumerate(over.coefficients):
        usual, _ = usable(before, coefficients, data.against_axles)
        likelihood = likelihood_of(usual, against_axles=data.against_axles)
        posterior = sample_posterior(few, likelihood, *before.rates, rng)
        if posterior.effective < FEWEST_EFFECTIVE:
            continue
        for k, name in enumerate(MODEL):
            table[k, :, column] = quantiles(posterior.values[name], posterior.weight, LEVELS)
    return tuple(
        Distribution(name, time_s, LEVELS, tuple(table[k]), NOTE)
        for k, name in enumerate(MODEL)
        if np.isfinite(table[k]).any()
    )


def tracks(found: Sequence[Distribution]) -> tuple[Track, ...]:
    """Median and 95 % interval of each distribution."""
    low, middle, high = (LEVELS.index(level) for level in (0.025, 0.5, 0.975))
    return tuple(
        Track(d.parameter, d.time_s, d.quantiles[middle], d.quantiles[low], d.quantiles[high]) for d in found
    )


def not_told(
    before: VehiclePart, reason: str, reference: Mapping[str, float]
) -> dict[str, ParameterEstimate]:
    """What is left of the parameters where the drive cannot tell: the prior."""
    return before.unknown(GIVEN, reason, reference)
