"""Every method over noise seeds: bias, RMSE against the Cramér-Rao bound, coverage; noise on outputs, and on all channels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipelines.filters.gpc_update import SQUARE_ROOT
from pipelines.filters.products_batch import cramer_rao
from pipelines.models.roll_plane import SIMPLE
from pipelines.reproduce.base import Progress, StudyRow, study_row
from pipelines.reproduce.gpc_regression.methods import Answer, batch, chaos_filter, published, recursive
from pipelines.reproduce.gpc_regression.setup import (
    INPUT_NOISE,
    NAMES,
    NOISE,
    TRUTH,
    UNITS,
    Drive,
    noisy,
)

OUTPUTS, ALL = "noise on outputs", "noise on all channels"
RATIO_TARGET = 1.2
PUBLISHED, SQUARE, RLS, BATCH = "gPC-EKF, Table 3.10", "gPC-EKF, square root", "RLS 0.999", "batch"
PLAIN: dict[str, Callable[[Drive], Answer]] = {
    PUBLISHED: lambda drive: published(drive, quiet=False),
    SQUARE: lambda drive: chaos_filter(drive, form=SQUARE_ROOT),
    RLS: recursive,
    BATCH: batch,
}
TAKEN_OUT = "inputs' noise taken out"
CORRECTED: dict[str, Callable[[Drive], Answer]] = {
    f"{SQUARE}, {TAKEN_OUT}": lambda drive: chaos_filter(drive, inputs=True),
    f"{RLS}, {TAKEN_OUT}": lambda drive: recursive(drive, inputs=True),
    f"{BATCH}, {TAKEN_OUT}": lambda drive: batch(drive, inputs=True),
}
BOUND_METHODS = (SQUARE, BATCH)


def study(
    drive: Drive, runs: int, rng: np.random.Generator, progress: Progress
) -> tuple[tuple[StudyRow, ...], dict[str, float]]:
    """All rows, and the RMSE in % of the height that RLS gives through the pitch equation, by set-up."""
    rows: list[StudyRow] = []
    other: dict[str, float] = {}
    for number, (setup, inputs) in enumerate(((OUTPUTS, False), (ALL, True))):
        methods = {**PLAIN, **CORRECTED} if inputs else PLAIN
        found: dict[str, list[Answer]] = {name: [] for name in methods}
        for i in range(runs):
            progress(f"study: {setup}", 0.3 + 0.35 * (number + i / runs))
            measured = noisy(drive, rng, inputs=inputs)
            for name, method in methods.items():
                found[name].append(method(measured))
        bound = cramer_rao(
            SIMPLE, drive.regressors, TRUTH, np.full(3, NOISE), INPUT_NOISE if inputs else None
        )
        for name, answers in found.items():
            rows += _rows(setup, name, answers, bound, inputs)
        heights = np.array([answer.other_height for answer in found[RLS]])
        other[setup] = float(100 * np.sqrt(np.mean((heights / TRUTH[3] - 1) ** 2)))
    return tuple(rows), other


def _rows(
    setup: str,
    name: str,
    answers: list[Answer],
    bound: np.ndarray[tuple[int], np.dtype[np.float64]],
    inputs: bool,
) -> list[StudyRow]:
    values = np.array([answer.values for answer in answers])
    std = np.array([answer.std for answer in answers])
    good = (TAKEN_OUT in name and not name.startswith(RLS)) or (not inputs and name in BOUND_METHODS)
    return [
        study_row(
            setup, name, NAMES[i], UNITS[i], float(TRUTH[i]), values[:, i],
            np.column_stack((values[:, i] - 1.96 * std[:, i], values[:, i] + 1.96 * std[:, i])),
            float(bound[i]), RATIO_TARGET if good else None,
        )
        for i in range(len(TRUTH))
    ]  # fmt: skip
