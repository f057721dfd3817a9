"""What the report shows of the batch fits: the mass as blocks came in, fits and residuals over time."""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.base_excitation.batch_corner import CornerFit
from pipelines.estimators.base_excitation.batch_heave import FRICTION, HeaveFit
from pipelines.estimators.base_excitation.blocks import Blocks
from pipelines.results import FloatArray, Trace, Track

LEAST_BLOCKS = 2


def _running(
    scores: FloatArray, informations: FloatArray, free: list[int]
) -> list[tuple[int, FloatArray, FloatArray]]:
    """(blocks so far, step from the final values, covariance) from the first blocks on: one step from the final fit."""
    found = []
    score, total = np.cumsum(scores, axis=0), np.cumsum(informations, axis=0)
    whole = total[-1][np.ix_(free, free)]
    # the final fit's own pull (priors) is what its scores sum to
    rest = score[-1][free]
    for k in range(LEAST_BLOCKS - 1, len(scores)):
        here = total[k][np.ix_(free, free)] + 1e-9 * np.diag(np.diag(whole))
        covariance = np.linalg.pinv(here, hermitian=True)
        share = (k + 1) / len(scores)
        found.append((k + 1, covariance @ (score[k][free] - share * rest), covariance))
    return found


def _ends(blocks: Blocks, time_s: FloatArray, counts: list[int]) -> FloatArray:
    """When the last of so many blocks ended."""
    last = blocks.first[np.array(counts) - 1] + blocks.rows - 1
    return np.asarray(time_s[last])


def heave_track(fit: HeaveFit, time_s: FloatArray, sprung_kg: float, std: float) -> tuple[Track, ...]:
    """The sprung mass as blocks came in; the interval shrinks to the final one. sprung_kg, std: the final answer."""
    free = [i for i in range(FRICTION) if fit.informations[:, i, i].any()]
    steps = _running(fit.scores, fit.informations, free)
    if len(steps) < 2:
        return ()
    # the answer allows for stiffness beyond the springs; so does its history
    scale = sprung_kg / fit.sprung_kg
    value = np.array([scale * (fit.sprung_kg + step[0] + step[1]) for _, step, _ in steps])
    chance = np.array([c[0, 0] + c[1, 1] + 2 * c[0, 1] for _, _, c in steps])
    return (_track("sprung_mass_kg", fit.blocks, time_s, [k for k, _, _ in steps], value, chance, std),)


def corner_track(
    name: str, fit: CornerFit, time_s: FloatArray, hub_kg: float, share: float
) -> tuple[Track, ...]:
    """A corner's mass as blocks came in. share: the final standard deviation as a share of the sprung mass."""
    steps = _running(fit.scores, fit.informations, list(range(min(3, len(fit.free)))))
    if len(steps) < 2:
        return ()
    mass = fit.mass_kg
    value = np.array([mass * math.exp(min(max(step[0], -1.0), 1.0)) + hub_kg for _, step, _ in steps])
    chance = np.array([c[0, 0] for _, _, c in steps]) * mass**2
    return (_track(name, fit.blocks, time_s, [k for k, _, _ in steps], value, chance, share * mass),)


def _track(
    name: str,
    blocks: Blocks,
    time_s: FloatArray,
    counts: list[int],
    value: FloatArray,
    variance: FloatArray,
    std: float,
) -> Track:
    # what does not shrink with more data (springs, the model itself) is there from the beginning
    fixed = max(std**2 - float(variance[-1]), 0.0)
    half = 1.96 * np.sqrt(np.maximum(variance, 0.0) + fixed)
    return Track(name, _ends(blocks, time_s, counts), value, value - half, value + half)


def _outside(column: FloatArray, blocks: Blocks) -> FloatArray:
    """The column with NaN outside the blocks."""
    out = np.full(len(column), np.nan)
    rows = blocks.first[:, None] + np.arange(blocks.rows)
    out[rows] = column[rows]
    return out


def heave_trace(fit: HeaveFit, time_s: FloatArray) -> tuple[Trace, ...]:
    """Inertia force of the body, and what the sum of all forces leaves over."""
    columns = {
        "inertia force of the body": fit.fitted,
        "springs, dampers and friction": fit.fitted - fit.residual,
        "residual": fit.residual,
    }
    note = "heave of the body; forces on it, in N"
    return (Trace("heave fit", time_s, columns, dict.fromkeys(columns, "N"), note),)


def corner_trace(fit: CornerFit, time_s: FloatArray) -> tuple[Trace, ...]:
    """Measured against simulated body acceleration (the model runs on the hub's acceleration alone)."""
    response = _outside((1 + fit.values[4]) * fit.response, fit.blocks)
    measured = _outside(fit.measured, fit.blocks)
    columns = {"measured": measured, "model": response, "residual": measured - response}
    note = "the model runs on the hub's acceleration alone"
    return (Trace("body acceleration fit", time_s, columns, dict.fromkeys(columns, "m/s²"), note),)
