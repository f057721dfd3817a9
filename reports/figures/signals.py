"""The signals that the results stand on, as small multiples over the drive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from parsers.signals import COLUMNS
from pipelines.results import DriveResults, FloatArray
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
from reports.figures.style import BLUE, finish, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 48
BUCKETS = 420


@dataclass(frozen=True)
class _Panel:
    line: Series
    gaps: FloatArray


def _panels(results: DriveResults) -> list[_Panel]:
    found: list[_Panel] = []
    for trace in results.signals:
        for column, values in trace.columns.items():
            if values.size != trace.time_s.size or not np.isfinite(values).any():
                continue
            spec = COLUMNS.get(column)
            name = spec.name if spec else column
            line = make_series(
                name.replace("_", " "), unit_of(column, trace.units.get(column)), trace.time_s, values
            )
            found.append(_Panel(line, gap_spans(results.record.gaps, name)))
    return found


def _draw_panel(axes: Axes, panel: _Panel, duration_s: float) -> None:
    shade_gaps(axes, panel.gaps, duration_s)
    draw_series(axes, panel.line, panel.gaps, BUCKETS, BLUE, linewidth=0.7)
    axes.set_title(f"{panel.line.label}, {panel.line.unit}" if panel.line.unit else panel.line.label)
    finish(axes)
    axes.locator_params(axis="y", nbins=4)
    time_limits(axes, duration_s, [panel.line])


def draw(results: DriveResults) -> Drawing | Missing:
    """One panel a signal; gaps are shaded and never bridged."""
    found = _panels(results)
    if not found:
        return Missing("Not drawn: no channel of the log became a signal.")
    with styled():
        svgs = panels(
            "signals", "Signals over the drive", found[:MOST],
            lambda axes, panel: _draw_panel(axes, panel, results.record.duration_s),
        )  # fmt: skip
    shaded = " Shaded: gaps, never bridged." if any(p.gaps.size for p in found[:MOST]) else ""
    left = f" {len(found) - MOST} more signals are not drawn." if len(found) > MOST else ""
    return Drawing(
        svgs,
        f"Thinned for the page; the highest and lowest sample of every span stay.{shaded}{left}",
        "Signals",
    )
