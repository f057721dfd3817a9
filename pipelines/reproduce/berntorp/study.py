"""Every method over the noise seeds, on the plant as modelled and on the richer one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipelines.reproduce.base import StudyRow, study_row
from pipelines.reproduce.berntorp.batch import BatchFit, cramer_rao, fit_batch
from pipelines.reproduce.berntorp.filters import (
    ALGORITHM,
    CLOUDS,
    FEW,
    FEW_PARTICLES,
    KERNEL,
    NONADAP,
    NONBO,
    Collected,
    Filter,
    algorithm,
    collect,
    kernel,
    nonadap,
    nonbo,
)
from pipelines.reproduce.berntorp.setup import (
    NOISE,
    RANGES,
    STEP_S,
    TITLES,
    UNITS,
    Motion,
    RollBody,
    measured,
)
from pipelines.results import FloatArray
from pipelines.warm_start.density import Box
from pipelines.warm_start.roll_cost import RollError
from pipelines.warm_start.warm_start import PUBLISHED as WARM_PUBLISHED
from pipelines.warm_start.warm_start import WarmStart, warm_start

BATCH = "batch maximum likelihood"
RATIO_TARGET = 1.05
OWN, HONEST = "its own interval", f"{CLOUDS} clouds joined"
Report = Callable[[str, float], None]


@dataclass(frozen=True)
class Setup:
    """A plant with its manoeuvre, and what counts as the truth there. best: (3,) what the model fits without noise."""

    name: str
    motion: Motion
    truth: RollBody
    best: BatchFit
    started: WarmStart
    bound: FloatArray
    bound_offsets: FloatArray


@dataclass(frozen=True)
class Found:
    """All that was run on a set-up. batch: (runs, 3) estimates and (runs, 3, 2) intervals."""

    setup: Setup
    filters: dict[str, Collected]
    batch: FloatArray
    batch_intervals: FloatArray


def prepare(name: str, motion: Motion, truth: RollBody, rng: np.random.Generator) -> Setup:
    """Bounds, best fit without noise, and the warm start from one run with noise of its own (the archival data)."""
    clean = np.column_stack((motion.roll, motion.rate))
    y, accel = measured(motion, rng)
    scale = (NOISE.roll_rad, NOISE.roll_rate_radps)
    cost = RollError(
        y, accel, STEP_S, mass_kg=truth.mass, roll_inertia_kgm2=truth.inertia, scale=scale
    )  # fmt: skip
    box = Box(*(np.array([RANGES[k][end] for k in ("K", "D", "h")]) for end in (0, 1)))
    started = warm_start(cost, box, None, WARM_PUBLISHED, rng)
    return Setup(
        name, motion, truth, fit_batch(clean, motion.accel, truth.mass, truth.inertia), started,
        cramer_rao(motion, truth), cramer_rao(motion, truth, offsets=True),
    )  # fmt: skip


def run_all(setup: Setup, runs: int, drives: int, rng: np.random.Generator, report: Report) -> Found:
    """All filters and the batch, `runs` seeds each, and so many drives with several clouds.

    NONADAP has the mean of Algorithm 2's particles over all runs.
    """
    found: dict[str, Collected] = {}

    def add(chosen: Filter, number: int) -> None:
        label = f"{setup.name}: {chosen.name}"
        found[chosen.name] = collect(
            chosen, setup.motion, runs, drives, rng, lambda share: report(label, (number + share) / 6)
        )

    add(algorithm(setup.started, setup.truth), 0)
    add(nonbo(setup.truth), 1)
    add(nonadap(setup.started, setup.truth, round(float(found[ALGORITHM].particles.mean()))), 2)
    add(nonadap(setup.started, setup.truth, FEW_PARTICLES, FEW), 3)
    add(kernel(setup.truth), 4)
    fits = []
    for i in range(runs):
        report(f"{setup.name}: {BATCH}", (5 + i / runs) / 6)
        fits.append(
            fit_batch(*measured(setup.motion, rng), setup.truth.mass, setup.truth.inertia, offsets=True)
        )
    theta, std = np.array([fit.theta for fit in fits]), np.array([fit.std for fit in fits])
    intervals = np.stack((theta - 1.96 * std, theta + 1.96 * std), axis=-1)
    return Found(setup, found, theta, intervals)


def rows_of(found: Found, *, matched: bool) -> tuple[StudyRow, ...]:
    """Rows of a set-up: each filter with its own interval and with the honest one, then the batch."""
    setup, rows = found.setup, []
    for name, run in found.filters.items():
        bound = setup.bound_offsets if name == KERNEL else setup.bound
        for honest in (False, True):
            label = f"{name}, {HONEST if honest else OWN}"
            estimates, intervals = run.estimates(honest=honest), run.intervals(honest=honest)
            rows += _three(setup, label, estimates, intervals, bound, None, "" if honest else _few(run))
    target = RATIO_TARGET if matched else None
    rows += _three(
        setup,
        f"{BATCH}, offsets as unknowns",
        found.batch,
        found.batch_intervals,
        setup.bound_offsets,
        target,
        "",
    )
    return tuple(rows)


def _few(run: Collected) -> str:
    return f"All weights zero at some sample in {run.lost} runs." if run.lost else ""


def _three(
    setup: Setup,
    method: str,
    estimates: FloatArray,
    intervals: FloatArray,
    bound: FloatArray,
    target: float | None,
    remark: str,
) -> list[StudyRow]:
    return [
        study_row(
            setup.name, method, TITLES[i], UNITS[i], float(setup.truth.theta[i]), estimates[:, i], intervals[:, i],
            float(bound[i]), target, remark if i == 0 else "",
        )
        for i in range(3)
    ]  # fmt: skip


FILTERS = (ALGORITHM, NONBO, NONADAP)
