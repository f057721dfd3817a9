"""The motion by instruments: where the innovations have no part along what the input's motion, without its noise, would teach.

Corrected least squares (`likelihood`) takes the mean of what the input's noise adds off the squares, but not its chance, which
in a slow slalom moved b by four of its bounds (the whole band's noise is a hundred times wider than its motion). The slopes
of the cleaned input hold next to none of that noise: as instruments they reach the bound. They need a start that is near.
"""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.roll_map.climb import TURNED, level
from pipelines.estimators.roll_map.likelihood import QUIET, Problem, named
from pipelines.estimators.roll_map.model import CLIP
from pipelines.estimators.roll_map.motion import simulated
from pipelines.results import FloatArray

MOST_STEPS = 8
MOST_TURNS = 3
SMALL = 0.01
"""Square of the last step in standard deviations at which the motion has settled."""


def _gradient(problem: Problem, x: FloatArray, taught: FloatArray) -> FloatArray:
    """(p,) what is left along the instruments, less what noise alone gives both them and the innovations, and the prior's pull."""
    here, quiet = named(problem.known, x), dict.fromkeys(QUIET, 0.0)
    error, variance = problem.innovations(x, here)
    psi = np.clip(np.nan_to_num(error / np.sqrt(variance)), -CLIP, CLIP)
    found = -(taught * psi).sum(axis=(1, 2)) - (problem.weight * (x - problem.mean))[problem.motion]
    for probe, clean, whiten, size in zip(
        problem.probes,
        problem.clean_probes,
        problem.whiteners(here)[1:],
        problem.a_sample(here),
        strict=True,
    ):
        noise, spread = whiten(simulated(probe, here | quiet), clip=1e9)
        both = problem.taught_by(clean, x, quiet) * np.nan_to_num(noise / np.sqrt(spread))
        found += problem.rows * problem.data.every * size * both.sum(axis=(1, 2))
    return np.asarray(found)


def polished(problem: Problem, x: FloatArray) -> tuple[FloatArray, int, bool]:
    """The motion's parameters from x, with the levels held: the point, the steps, and whether it settled."""
    block = problem.motion
    for count in range(1, MOST_STEPS + 1):
        taught = problem.taught(x)
        flat = taught.reshape(len(taught), -1)
        curvature = flat @ flat.T + np.diag(problem.weight[block])
        scale = np.sqrt(np.diag(curvature))
        gradient = _gradient(problem, x, taught)
        if not (np.isfinite(gradient).all() and np.isfinite(curvature).all()):
            return x, count, False
        step = np.linalg.solve(curvature / np.outer(scale, scale), gradient / scale) / scale
        moved = x.copy()
        moved[block] += step
        moved = np.clip(moved, problem.low, problem.high)
        if not math.isfinite(problem.cost(moved, named(problem.known, x))):
            return x, count, False
        taken = (moved - x)[block]
        x = moved
        if float(taken @ curvature @ taken) < SMALL:
            return x, count, True
    return x, MOST_STEPS, False


def refine(problem: Problem, x: FloatArray, most: int) -> tuple[FloatArray, int, bool]:
    """Levels and polished motion in turn from x: the point, the steps, and whether both settled."""
    steps = 0
    for _ in range(MOST_TURNS):
        x, gained, more = level(problem, x, most)
        moved, taken, settled = polished(problem, x)
        steps += more + taken
        if not settled:
            return x, steps, False
        # one step that changes nothing: the levels had not moved the motion's weights either
        if taken == 1 or gained < TURNED:
            return moved, steps, True
        x = moved
    return x, steps, True
