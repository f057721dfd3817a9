"""Tables 3.8-3.10 with the printed settings and with those that work, and Figures 3.32-3.39 as traces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.filters.gpc_update import PUBLISHED
from pipelines.reproduce.base import Cell, Column, Progress, ReproducedTable, StudyRow
from pipelines.reproduce.gpc_regression.methods import (
    FORGETTING,
    QUIET,
    QUIET_R,
    Answer,
    chaos_filter,
    points,
    published,
    recursive,
    too_few_points,
)
from pipelines.reproduce.gpc_regression.setup import NAMES, TRUTH, UNITS, Drive, noisy
from pipelines.results import Trace

PRINTED_POINTS, DRAWS = 4, 4
FACTORS = ((1.0, "15 = 1 x S"), (2.0, "30 = 2 x S"), (4.0, "60 = 4 x S"))
FORGETTINGS = (0.99, FORGETTING, 1.0)
FIGURES = ("3.32", "3.33", "3.34", "3.35", "3.36", "3.37", "3.38", "3.39")
FIGURE_PARAMETERS = (3, 0, 1, 2)
"""Figures 3.32-3.35 and 3.36-3.39 show height, mass, pitch inertia, roll inertia."""


@dataclass(frozen=True)
class Shown:
    """Tables, traces, and the answers that the claims speak of: without noise and with it, by method."""

    tables: tuple[ReproducedTable, ...]
    traces: tuple[Trace, ...]
    quiet: dict[str, Answer]
    loud: dict[str, Answer]
    by_points: dict[str, Answer]


def errors(answer: Answer) -> list[float]:
    """Of m, J_p, J_r, h at the end, in %."""
    return [float(e) for e in 100 * (answer.values / TRUTH - 1)]


def _error_columns(first: str, digits: int) -> tuple[Column, ...]:
    return (Column(first), *(Column(f"{name}, error", "%", digits) for name in NAMES))


def _traces(answers: dict[str, Answer], first: int, words: str) -> list[Trace]:
    found = []
    for number, parameter in enumerate(FIGURE_PARAMETERS):
        columns = {name: answer.track[:, parameter] for name, answer in answers.items()}
        time_s = np.arange(1, len(next(iter(columns.values()))) + 1, dtype=np.float64)
        columns["true"] = np.full(len(time_s), TRUTH[parameter])
        unit = UNITS[parameter]
        title = f"Fig {FIGURES[first + number]}: {NAMES[parameter]}, {words}"
        found.append(Trace(title, time_s, columns, dict.fromkeys(columns, unit)))
    return found


def tables(drive: Drive, rng: np.random.Generator, progress: Progress) -> Shown:
    """Run what the tables and figures show, once each."""
    progress("Table 3.8", 0.02)
    sets = {f"4 (as printed), draw {i + 1}": too_few_points(PRINTED_POINTS, rng) for i in range(DRAWS)}
    sets |= {label: points(factor) for factor, label in FACTORS}
    by_points = {
        label: chaos_filter(drive, form=PUBLISHED, additions=QUIET, noise=QUIET_R, at=at)
        for label, at in sets.items()
    }
    cells: tuple[tuple[Cell, ...], ...] = tuple(
        (label, *errors(answer)) for label, answer in by_points.items()
    )
    eighth = ReproducedTable(
        "Table 3.8", "gPC-EKF without noise, by the number of collocation points Q", _error_columns("Q", 4), cells,
        "Four points cannot determine S = 15 coefficients: all parameters go off together, as far as the draw will have it. Q in "
        "the tables is a multiple of S, as (5) has it.",
    )  # fmt: skip
    progress("Table 3.9", 0.1)
    quiet = {"gPC-EKF": published(drive, quiet=True), "RLS": recursive(drive)}
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (f"{keep:g}", *errors(recursive(drive, forgetting=keep))) for keep in FORGETTINGS
    )
    ninth = ReproducedTable(
        "Table 3.9", "RLS without noise, by the forgetting factor", _error_columns("λ", 4), rows
    )
    progress("Figures", 0.2)
    measured, everywhere = noisy(drive, rng, inputs=False), noisy(drive, rng, inputs=True)
    loud = {
        "gPC-EKF": published(measured, quiet=False), "RLS": recursive(measured),
        "gPC-EKF, square root": chaos_filter(measured),
        "noise on all channels, taken out": chaos_filter(everywhere, inputs=True),
    }  # fmt: skip
    traces = (*_traces(quiet, 0, "no noise"), *_traces(loud, 4, "noise"))
    return Shown((eighth, ninth), traces, quiet, loud, by_points)


def table_of_noise(rows: tuple[StudyRow, ...]) -> ReproducedTable:
    """Table 3.10's settings beside the others: RMS errors in % of all runs."""
    found: dict[tuple[str, str], list[Cell]] = {}
    for row in rows:
        found.setdefault((row.setup, row.method), []).append(100 * row.rmse / row.truth)
    cells: tuple[tuple[Cell, ...], ...] = tuple(
        (setup, method, *errs) for (setup, method), errs in found.items()
    )
    columns = (Column("set-up"), Column("method"), *(Column(f"{name}, RMS", "%", 2) for name in NAMES))
    return ReproducedTable(
        "Table 3.10", "RMS error at the end over all noise seeds", columns, cells,
        "The paper prints the settings and shows one run in Figures 3.36-3.39. R is 0.1 there, half the noise's variance.",
    )  # fmt: skip
