"""The filters of the study: Algorithm 2, NONBO, NONADAP, one with far too few particles, and the better variant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.marginalized_particle_filter.clouds import pooled_spread
from pipelines.filters.marginalized_particle.clouds import cloud_of, uniform_cloud
from pipelines.filters.marginalized_particle.monte_carlo import run_many
from pipelines.filters.marginalized_particle.records import (
    BETTER,
    PUBLISHED,
    Cloud,
    ParticleRun,
    ParticleSettings,
    fixed_size,
)
from pipelines.reproduce.berntorp.setup import NOISE, RANGES, STEP_S, Motion, RollBody, measured
from pipelines.results import FloatArray
from pipelines.warm_start.warm_start import WarmStart, drawn_particles, grid_particles

ALGORITHM, NONBO, NONADAP = "Algorithm 2", "NONBO", "NONADAP"
FEW, KERNEL = "NONADAP, 200 particles", "kernel variant"
GRID = 20
"""Values a dimension: 20³ = 8 000 particles at first."""

PARTICLES = 8000
FEW_PARTICLES, KERNEL_PARTICLES = 200, 1000
CLOUDS = 4
"""Clouds on the same data, as `cogest analyze` has them unless it is told otherwise."""

Prior = Callable[[int, np.random.Generator], Cloud]


@dataclass(frozen=True)
class Filter:
    """A filter ready to run: its name, settings and prior."""

    name: str
    settings: ParticleSettings
    prior: Prior


@dataclass(frozen=True)
class Collected:
    """What many runs of a filter gave. mean, std: (runs, n, 3) of K, D, h. particles: (runs, n).

    pooled, pooled_std: (drives, 3) at the end of drives with several clouds each, joined as `cogest analyze` joins them.
    lost: runs in which all weights were zero at some sample. first: the first run, whole.
    """

    name: str
    mean: FloatArray
    std: FloatArray
    particles: FloatArray
    pooled: FloatArray
    pooled_std: FloatArray
    lost: int
    first: ParticleRun

    @property
    def final(self) -> FloatArray:
        """(runs, 3) estimates at the end."""
        return self.mean[:, -1]

    def estimates(self, *, honest: bool) -> FloatArray:
        """(runs or drives, 3) at the end: single clouds', or those of several on the same data."""
        return self.pooled if honest else self.final

    def intervals(self, *, honest: bool) -> FloatArray:
        """(runs or drives, 3, 2) 95 % intervals at the end: the filter's own, or that of several clouds on the same data."""
        half = 1.96 * (self.pooled_std if honest else self.std[:, -1])
        middle = self.estimates(honest=honest)
        return np.stack((middle - half, middle + half), axis=-1)


def _warm(started: WarmStart, body: RollBody, settings: ParticleSettings, count: int | None) -> Prior:
    """The warm start's draws: the paper's grid, or `count` of the joint density."""

    def prior(_: int, rng: np.random.Generator) -> Cloud:
        theta = (
            grid_particles(started, GRID, rng) if count is None else drawn_particles(started, count, rng)[0]
        )
        return cloud_of(
            theta,
            mass_kg=body.mass,
            roll_inertia_kgm2=body.inertia,
            above_mirror=settings.above_mirror,
            rng=rng,
        )

    return prior


def _uniform(body: RollBody, settings: ParticleSettings, count: int) -> Prior:
    """The whole box."""

    def prior(_: int, rng: np.random.Generator) -> Cloud:
        return uniform_cloud(
            count, RANGES, mass_kg=body.mass, roll_inertia_kgm2=body.inertia, above_mirror=settings.above_mirror,
            rng=rng,
        )  # fmt: skip

    return prior


def algorithm(started: WarmStart, body: RollBody) -> Filter:
    """Algorithm 2 as published."""
    return Filter(ALGORITHM, PUBLISHED, _warm(started, body, PUBLISHED, None))


def nonbo(body: RollBody) -> Filter:
    """Without Bayesian optimisation: from the whole box."""
    return Filter(NONBO, PUBLISHED, _uniform(body, PUBLISHED, PARTICLES))


def nonadap(started: WarmStart, body: RollBody, particles: int, name: str = NONADAP) -> Filter:
    """With so many particles throughout."""
    settings = fixed_size(PUBLISHED, particles)
    return Filter(name, settings, _warm(started, body, settings, particles))


def kernel(body: RollBody) -> Filter:
    """The better variant: resampling below N/2, Liu and West's move, no parameter noise, offsets as states; from the box."""
    settings = fixed_size(BETTER, KERNEL_PARTICLES)
    return Filter(KERNEL, settings, _uniform(body, settings, KERNEL_PARTICLES))


def _runs(
    chosen: Filter, drive: Callable[[int, np.random.Generator], tuple[FloatArray, FloatArray]], count: int,
    rng: np.random.Generator,
) -> list[ParticleRun]:  # fmt: skip
    settings = replace(chosen.settings, quantiles_every=1_000_000)
    return run_many(drive, chosen.prior, count, STEP_S, NOISE, settings, rng)


def pooled_runs(
    chosen: Filter, motion: Motion, drives: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Estimates and standard deviations (drives, 3) of several clouds on the same data, drive by drive."""
    means, stds = [], []
    for _ in range(drives):
        y, accel = measured(motion, rng)
        runs = _runs(chosen, lambda _i, _rng, y=y, accel=accel: (y, accel), CLOUDS, rng)  # type: ignore[misc]
        means.append([run.mean[-1] for run in runs])
        stds.append([run.std[-1] for run in runs])
    return pooled_spread(np.array(means), np.array(stds))


BATCH = 50
"""Runs held in memory at a time."""


def collect(
    chosen: Filter,
    motion: Motion,
    runs: int,
    drives: int,
    rng: np.random.Generator,
    progress: Callable[[float], None],
) -> Collected:
    """`runs` runs with fresh noise and fresh random numbers, and so many drives more with several clouds each."""
    pooled, pooled_std = pooled_runs(chosen, motion, drives, rng)
    mean, std, particles = [], [], []
    lost = 0
    first: ParticleRun | None = None
    for start in range(0, runs, BATCH):
        progress(start / runs)
        found = _runs(chosen, lambda _i, r: measured(motion, r), min(BATCH, runs - start), rng)
        first = first or found[0]
        mean += [run.mean for run in found]
        std += [run.std for run in found]
        particles += [run.particles for run in found]
        lost += sum(run.lost > 0 for run in found)
    assert first is not None
    return Collected(
        chosen.name, np.array(mean), np.array(std), np.array(particles, dtype=np.float64), pooled, pooled_std,
        lost, first,
    )  # fmt: skip
