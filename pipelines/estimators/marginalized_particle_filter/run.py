"""Warm start on the first exciting stretch, then several clouds over the drive, each with random numbers of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.marginalized_particle_filter.inputs import Inputs
from pipelines.estimators.roll_map.priors import VehicleDraws
from pipelines.filters.marginalized_particle.clouds import cloud_of, uniform_cloud
from pipelines.filters.marginalized_particle.filter import run_particles
from pipelines.filters.marginalized_particle.records import (
    BETTER,
    PUBLISHED,
    Cloud,
    Noise,
    ParticleRun,
    ParticleSettings,
    fixed_size,
)
from pipelines.results import FloatArray
from pipelines.warm_start.density import Box
from pipelines.warm_start.roll_cost import RollError
from pipelines.warm_start.warm_start import PUBLISHED as WARM_PUBLISHED
from pipelines.warm_start.warm_start import TEMPERED, WarmStart, drawn_particles, grid_particles, warm_start

WARM_S = 20.0
GRID = 20
FIRST_TIMES = 4
"""s of the drive for the warm start; values a dimension; of the kernel variant's particles, at first."""

NONBO, NONADAP, KERNEL = "nonbo", "nonadap", "kernel"
"""The paper's comparisons, Algorithm 2 without Bayesian optimisation and without adaptation; and the better variant."""

LEAST_SEEN = 5
"""Samples of a channel from which its variance is one."""

PUBLISHED_AT = (65_000.0, 5_500.0, 0.74)
PUBLISHED_STEP_S = 0.01
"""The vehicle and the sampling time for which the random walk's steps were found; they are taken relative to these."""

ANY_STIFFNESS = (35.0, 250.0)
DAMPING = (1.0, 20.0)
HEIGHT_RANGE = (0.5, 1.7)
AROUND = (0.6, 1.6)
"""The box: K / (m h) in m/s²/rad of any road vehicle where the angle is not seen, or AROUND the angle's own slope; D / (m h);
h over that before the log."""

SCALE = (0.003, 0.01)
LEAST_NOISE = (2e-4, 5e-4)
ACCEL_NOISE = 0.05
"""Roll in rad and rate in rad/s for the warm start's error; least noise; m/s² of the low-passed lateral acceleration."""


@dataclass(frozen=True)
class Given:
    """Mass, roll inertia and the accelerometer's height above ground, as mean and standard deviation; h before the log."""

    mass: tuple[float, float]
    inertia: tuple[float, float]
    sensor: tuple[float, float]
    height: float


@dataclass(frozen=True)
class Clouds:
    """The runs, all over the same rows. explained: share of the outputs' variance that the best start's motion holds."""

    runs: tuple[ParticleRun, ...]
    started: WarmStart
    noise: Noise
    explained: float
    snapshots: IntArray


def given_of(draws: VehicleDraws) -> Given:
    """What the filter is told, from the draws of the vehicle before the log: whole mass, about an axis on the ground."""
    ok = draws.possible

    def pair(values: FloatArray) -> tuple[float, float]:
        return float(values[ok].mean()), float(values[ok].std())

    # the draws hold the accelerometer above the roll axis
    return Given(
        pair(draws.mass), pair(draws.inertia), pair(draws.imu + draws.roll_axis), pair(draws.height)[0]
    )


def box_of(inputs: Inputs, given: Given) -> Box:
    """Where the warm start looks: K, D, h."""
    moment = given.mass[0] * given.height
    roll = inputs.y[:, 0]
    seen = np.isfinite(roll)
    low, high = ANY_STIFFNESS
    if seen.sum() > 20:
        f, angle = inputs.accel[seen] - inputs.accel[seen].mean(), roll[seen] - roll[seen].mean()
        slope = float(f @ angle / max(f @ f, 1e-9))
        if slope > 1e-3:
            steady = min(max(1 / slope + inputs.gravity, low), high)
            low, high = AROUND[0] * steady, AROUND[1] * steady
    return Box(
        np.array([low * moment, DAMPING[0] * moment, HEIGHT_RANGE[0] * given.height]),
        np.array([high * moment, DAMPING[1] * moment, HEIGHT_RANGE[1] * given.height]),
    )


def _error(inputs: Inputs, given: Given, *, offsets: bool) -> RollError:
    return RollError(
        inputs.y, inputs.accel, inputs.step_s, mass_kg=given.mass[0], roll_inertia_kgm2=given.inertia[0],
        input_height_m=given.sensor[0], gravity_mps2=inputs.gravity, scale=SCALE, offsets=offsets, segments=inputs.segments,
    )  # fmt: skip


def _misfit(inputs: Inputs, given: Given, theta: FloatArray) -> FloatArray:
    """(n, 2) measured less simulated, in rad and rad/s."""
    left = _error(inputs, given, offsets=False).residuals(theta)
    return np.full(inputs.y.shape, np.nan) if left is None else np.asarray(left * SCALE)


def _columns(function: np.ufunc | object, table: FloatArray, otherwise: float) -> FloatArray:
    """A figure of each column's finite rows."""
    found = []
    for column in table.T:
        good = column[np.isfinite(column)]
        found.append(float(function(good)) if len(good) else otherwise)  # type: ignore[operator]
    return np.array(found)


def chosen_settings(
    variant: str, wanted: int, most: int, inputs: Inputs, given: Given, theta: FloatArray
) -> ParticleSettings:
    """Variant, for this drive's rate and vehicle; never more than `most` particles."""
    wanted = min(wanted, most)
    if variant == KERNEL:
        return replace(
            BETTER, adaptive=False, fixed=wanted, wanted=wanted, most=most, above_mirror=False,
            gravity_mps2=inputs.gravity, quantiles_every=10**9,
        )  # fmt: skip
    share = np.array(PUBLISHED.walk) / PUBLISHED_AT * np.sqrt(inputs.step_s / PUBLISHED_STEP_S)
    stiffness, damping, height = (share * theta).tolist()
    chosen = replace(
        PUBLISHED, wanted=wanted, most=most, walk=(stiffness, damping, height), gravity_mps2=inputs.gravity, quantiles_every=10**9
    )  # fmt: skip
    return fixed_size(chosen, wanted) if variant == NONADAP else chosen


def run_clouds(
    inputs: Inputs,
    given: Given,
    variant: str,
    wanted: int,
    most: int,
    count: int,
    snapshots: IntArray,
    rng: np.random.Generator,
) -> Clouds:
    """Warm start, offsets and noise from its best point, then `count` clouds. snapshots: rows whose particles are kept."""
    first = inputs.first(WARM_S)
    error = _error(first, given, offsets=True)
    published = variant != KERNEL
    box = box_of(inputs, given)
    started = warm_start(
        error,
        box,
        None,
        WARM_PUBLISHED if published else TEMPERED,
        rng,
        power=None if published else error.independent,
    )
    best = started.history.best
    whole = _misfit(inputs, given, best)
    offsets = np.nan_to_num(_columns(np.median, whole, 0.0))
    part = whole[: len(first.y)] - offsets
    spread = np.maximum(_columns(np.std, part, 1.0), LEAST_NOISE)
    noise = Noise(float(spread[0]), float(spread[1]), ACCEL_NOISE)
    explained = explained_share(inputs.y, whole)
    settings = chosen_settings(variant, wanted, most, inputs, given, best)
    runs = []
    for stream in rng.spawn(count):
        prior = (
            _whole_box(box, given, settings, stream)
            if variant == NONBO
            else _prior(started, given, settings, published, stream)
        )
        runs.append(
            run_particles(
                inputs.less(offsets).y, inputs.accel, inputs.step_s, prior, noise, settings, stream,
                segments=inputs.segments, snapshots=snapshots.tolist(),
            )
        )  # fmt: skip
    return Clouds(tuple(runs), started, noise, explained, snapshots)


def _prior(
    started: WarmStart, given: Given, settings: ParticleSettings, published: bool, rng: np.random.Generator
) -> Cloud:
    """The paper's grid, or draws of the tempered density, weighted so that the stretch is not counted twice."""
    if published:
        theta = grid_particles(started, GRID, rng)
        theta = theta[rng.permutation(len(theta))[: settings.fixed or settings.most]]
        weights = None
    else:
        theta, weights = drawn_particles(started, min(FIRST_TIMES * settings.wanted, settings.most), rng)
    return cloud_of(
        theta, mass_kg=given.mass, roll_inertia_kgm2=given.inertia, input_height_m=given.sensor, weights=weights,
        above_mirror=settings.above_mirror, rng=rng,
    )  # fmt: skip


def _whole_box(box: Box, given: Given, settings: ParticleSettings, rng: np.random.Generator) -> Cloud:
    """NONBO's prior; where noise and offsets come from is the warm start's best point all the same."""
    ranges = dict(zip("KDh", zip(box.low.tolist(), box.high.tolist(), strict=True), strict=True))
    return uniform_cloud(
        settings.most, ranges, mass_kg=given.mass, roll_inertia_kgm2=given.inertia, input_height_m=given.sensor,
        above_mirror=settings.above_mirror, rng=rng,
    )  # fmt: skip


def explained_share(y: FloatArray, misfit: FloatArray) -> float:
    """Share of the first output's variance that the simulated motion holds; 0 for a dead channel."""
    for column in range(2):
        seen = np.isfinite(y[:, column])
        if seen.sum() >= LEAST_SEEN:
            variance = float(np.var(y[seen, column]))
            left = misfit[seen, column]
            whole = variance > 1e-14 and bool(np.isfinite(left).all())
            return 1 - float(np.var(left)) / variance if whole else 0.0
    return 0.0
