"""What the model leaves unexplained: residuals over time, and how they are spread."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import FloatArray
from reports.figures.drawing import Drawing, Missing
from reports.figures.fits import TracePanel, draw_lines, trace_panels
from reports.figures.series import gap_spans
from reports.figures.style import FULL_WIDTH, INK, LINES, SOFT, finish, new_figure, styled, to_svg
from reports.text import clean, significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 6

OVER_BOTH = 1.29
"""Where the histogram ends, in widths of the panel over time beside it."""


def _spread(axes: Axes, panel: TracePanel) -> None:
    """Histogram beside the trace, against the normal density of the same spread."""
    for place, line in enumerate(panel.lines):
        levels = line.spread
        if levels.size < 8:
            continue
        shares = np.linspace(0.0, 1.0, levels.size)
        low, high = (float(q) for q in np.interp((0.002, 0.998), shares, levels))
        if high <= low:
            continue
        edges = np.linspace(low, high, 36)
        bars = np.diff(np.interp(edges, levels, shares)) / (edges[1] - edges[0])
        axes.stairs(
            bars, edges, fill=True, color=LINES[place % len(LINES)], alpha=0.45, orientation="horizontal"
        )
        middle = 0.5 * (levels[1:] + levels[:-1])
        mean, std = float(middle.mean()), float(middle.std())
        if std > 0:
            grid = np.linspace(low, high, 101)
            density: FloatArray = np.exp(-0.5 * ((grid - mean) / std) ** 2) / (std * np.sqrt(2 * np.pi))
            axes.plot(density, grid, color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
            if len(panel.lines) == 1:
                axes.set_title(f"std {significant(std)} {panel.unit}", color=SOFT, fontsize=7.5, loc="right")
    axes.set_xticks([])
    axes.tick_params(labelleft=False)
    axes.spines["bottom"].set_visible(False)


def _pair(pair: Sequence[TracePanel], gaps: FloatArray, duration_s: float, place: int) -> str:
    """Two residuals beside each other, each with its histogram."""
    figure = new_figure(FULL_WIDTH, 1.55)
    grid = figure.subplots(1, 4, width_ratios=(4, 1, 4, 1), sharey=False)
    for number, (left, right) in enumerate(((grid[0], grid[1]), (grid[2], grid[3]))):
        if number >= len(pair):
            left.set_axis_off()
            right.set_axis_off()
            continue
        panel = pair[number]
        # the histogram of one line alone has a title of its own
        draw_lines(left, panel, gaps, duration_s, legend_end=OVER_BOTH)
        left.axhline(0.0, color=SOFT, linewidth=0.6)
        left.set_xlabel("time, s")
        _spread(right, panel)
        finish(right)
        right.set_ylim(*left.get_ylim())
    return to_svg(
        figure, f"residuals{place}", "Residuals: " + "; ".join(clean(panel.title) for panel in pair)
    )


def draw(results: DriveResults) -> Drawing | Missing:
    """Every residual over time, with its histogram."""
    found = trace_panels(results, residual=True)
    if not found:
        return Missing("Not drawn: no estimator that ran gave residuals.")
    gaps = gap_spans(results.record.gaps)
    with styled():
        svgs = tuple(
            _pair(found[place : min(place + 2, MOST)], gaps, results.record.duration_s, place)
            for place in range(0, min(len(found), MOST), 2)
        )
    return Drawing(
        svgs,
        "Right: their spread, and (dashed) the normal density of the same standard deviation.",
        "Residuals",
    )
