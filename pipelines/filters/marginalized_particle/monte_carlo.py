"""Many runs of the filter: independent drives, each with its own random numbers, on threads (the kernels hold no lock)."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from pipelines.filters.marginalized_particle.filter import run_particles
from pipelines.filters.marginalized_particle.records import Cloud, Noise, ParticleRun, ParticleSettings
from pipelines.results import FloatArray

Drive = tuple[FloatArray, FloatArray]
"""Measurements (n, 2) and acceleration (n,) of one run."""


def run_many(
    drive: Callable[[int, np.random.Generator], Drive],
    prior: Callable[[int, np.random.Generator], Cloud],
    count: int,
    step_s: float,
    noise: Noise,
    settings: ParticleSettings,
    rng: np.random.Generator,
    *,
    workers: int = 2,
) -> list[ParticleRun]:
    """`count` runs: drive(i, rng_i), then prior(i, rng_i), then `run_particles`; rng_i is spawned from rng.

    The same whatever `workers` is. drive and prior are called on the threads: they change nothing that others see.
    """
    streams = rng.spawn(count)

    def one(i: int) -> ParticleRun:
        y, accel = drive(i, streams[i])
        return run_particles(y, accel, step_s, prior(i, streams[i]), noise, settings, streams[i])

    if workers <= 1 or count <= 1:
        return [one(i) for i in range(count)]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(one, range(count)))
