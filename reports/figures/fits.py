"""What was measured and what the fitted model gives, over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import Estimate, FloatArray, Trace
from pipelines.tire_forces import is_force_trace
from reports.figures.drawing import Drawing, Missing
from reports.figures.grid import panels
from reports.figures.series import (
    Series,
    draw_series,
    gap_spans,
    make_series,
    shade_gaps,
    time_limits,
    unit_of,
)
from reports.figures.style import LINES, finish, styled
from reports.text import clean, sentence

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 12
BUCKETS = 700


def quantiles(values: FloatArray) -> FloatArray:
    """201 quantiles in equal steps from the least to the greatest finite value; empty where there is none."""
    finite = values[np.isfinite(values)]
    return np.quantile(finite, np.linspace(0.0, 1.0, 201)) if finite.size else np.empty(0)


@dataclass(frozen=True)
class TracePanel:
    """Lines of one unit that share a panel."""

    title: str
    unit: str
    lines: tuple[Series, ...]
    note: str = ""


def is_residual(trace: Trace, column: str) -> bool:
    """Whether a column holds residuals: it or its trace is named so."""
    words = f"{trace.name} {column}".lower()
    return "residual" in words or "innovation" in words


def _title(trace: Trace, estimate: Estimate) -> str:
    """Whose it is above what it is, so that a legend fits beside them."""
    return f"{clean(estimate.estimator, 40)}\n{clean(trace.name.removeprefix(f'{estimate.estimator}: '), 44)}"


def _label(column: str) -> str:
    """A column's name for the legend; that it is a residual, the figure's title says."""
    words = column.replace("_", " ")
    return words.removesuffix(" residual") or words


def trace_panels(results: DriveResults, *, residual: bool) -> list[TracePanel]:
    """Estimators' traces as panels, one a trace and unit: the residual columns, or all the others.

    Answers before witnesses; tyre forces have a chapter of their own.
    """
    found: list[TracePanel] = []
    for estimate in sorted(results.estimates, key=lambda e: e.witness):
        for trace in estimate.traces:
            if is_force_trace(trace):
                continue
            by_unit: dict[str, list[Series]] = {}
            for column, values in trace.columns.items():
                if is_residual(trace, column) != residual or values.size != trace.time_s.size:
                    continue
                if not np.isfinite(values).any():
                    continue
                unit = unit_of(column, trace.units.get(column))
                levels = (trace.spread.get(column, quantiles(values))) if residual else None
                line = make_series(_label(column), unit, trace.time_s, values, levels)
                by_unit.setdefault(line.unit, []).append(line)
            title = _title(trace, estimate)
            found += [
                TracePanel(title, unit, tuple(lines[:6]), clean(trace.note, 300))
                for unit, lines in by_unit.items()
            ]
    return found


def draw_lines(
    axes: Axes, panel: TracePanel, gaps: FloatArray, duration_s: float, *, legend_end: float = 1.0
) -> None:
    """Draw a panel's lines, thinned, with a legend where there is more than one.

    legend_end: where the legend ends, in widths of the panel: more than 1 where there is room beside it.
    """
    shade_gaps(axes, gaps, duration_s)
    for place, line in enumerate(panel.lines):
        draw_series(
            axes, line, gaps, BUCKETS, LINES[place % len(LINES)], linewidth=0.9 if place == 0 else 0.8
        )
    axes.set_title(panel.title, fontsize=7.5)
    axes.set_ylabel(panel.unit)
    finish(axes)
    time_limits(axes, duration_s, panel.lines)
    if len(panel.lines) > 1:
        from matplotlib.transforms import offset_copy

        # beside the title's first line, which is short: the second one may be as long as the panel
        above = offset_copy(axes.transAxes, cast("Figure", axes.get_figure()), y=9.5, units="points")
        legend = axes.legend(
            loc="lower right",
            bbox_to_anchor=(legend_end, 1.0),
            bbox_transform=above,
            ncols=len(panel.lines),
            borderaxespad=0.1,
            handlelength=1.4,
        )
        # what stands beside the panel anyway makes room for it
        legend.set_in_layout(legend_end <= 1)


def _notes(shown: Sequence[TracePanel]) -> str:
    """What is noted of panels, each note once, with the panel that it is of; of several, with whose they are."""
    of: dict[str, list[list[str]]] = {}
    for panel in shown:
        if panel.note:
            of.setdefault(panel.note, []).append(panel.title.split("\n"))
    whose = {note: titles[0][-1] if len(titles) == 1 else titles[0][0] for note, titles in of.items()}
    return " ".join(sentence(f"{title}: {note}") for note, title in whose.items())


def draw(results: DriveResults) -> Drawing | Missing:
    """One panel a trace and unit."""
    found = trace_panels(results, residual=False)
    if not found:
        return Missing("Not drawn: no estimator that ran gave a fit over time.")
    gaps = gap_spans(results.record.gaps)
    with styled():
        svgs = panels(
            "fits", "Measured and modelled signals over time", found[:MOST],
            lambda axes, panel: draw_lines(axes, panel, gaps, results.record.duration_s),
            across=2, row_height=1.32, rows_a_piece=2,
        )  # fmt: skip
    notes = _notes(found[:MOST])
    left = f" {len(found) - MOST} more panels are not drawn." if len(found) > MOST else ""
    shaded = " Shaded: gaps in the log." if gaps.size else ""
    return Drawing(svgs, f"{notes}{shaded}{left}".strip(), "Fits over time")
