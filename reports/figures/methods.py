"""Interval plot: for each parameter the verdict, and below it what every single method says, and what was known before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import ParameterEstimate
from reports.figures.drawing import Drawing, Missing
from reports.figures.style import (
    BLUE,
    FULL_WIDTH,
    GREY,
    ORANGE,
    PURPLE,
    STATUS_COLOURS,
    new_figure,
    styled,
    to_svg,
)
from reports.layout import middle
from reports.sections.values import NORMAL_95, SINGLE_WHEELS, has_result
from reports.sections.verdict import ordered
from reports.text import EN_DASH, clean, spec_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 16
MOST_METHODS = 12
ROW, HEAD = 0.14, 0.43
"""Inches of a method's line, and of a panel's title and axis."""
TALLEST = 3.4
NAME_WIDTH = 26
FARTHEST = 7.0
"""Half-widths from the verdict beyond which a method is drawn as an arrow at the edge."""


@dataclass(frozen=True)
class Line:
    """One line of a panel: a name, the interval and how it is drawn. low, high may be missing."""

    name: str
    value: float
    low: float
    high: float
    kind: str


@dataclass(frozen=True)
class Panel:
    """A parameter with its lines, the verdict's first."""

    name: str
    lines: tuple[Line, ...]
    status: str
    reference: float | None


def _line(name: str, estimate: ParameterEstimate, kind: str) -> Line | None:
    if estimate.value is None or not np.isfinite(estimate.value):
        return None
    low, high = (
        end if end is not None and np.isfinite(end) else estimate.value
        for end in (estimate.low, estimate.high)
    )
    return Line(name, estimate.value, low, high, kind)


def _lines(results: DriveResults, verdict: ParameterEstimate) -> list[Line]:
    """The verdict, the methods (published ones behind), and what was known before."""
    found = [_line("verdict", verdict, "verdict")] if has_result(verdict) else []
    methods = []
    for estimate in sorted(results.estimates, key=lambda e: e.witness):
        told = estimate.parameters.get(verdict.name)
        if told is not None and has_result(told):
            kind = "witness" if estimate.witness else "method"
            methods.append(_line(clean(estimate.estimator, 60), told, kind))
    lines = [line for line in (*found, *methods[:MOST_METHODS]) if line is not None]
    prior = verdict.prior
    if lines and prior is not None and np.isfinite([prior.value, prior.std]).all():
        half = NORMAL_95 * prior.std
        lines.append(Line("known before", prior.value, prior.value - half, prior.value + half, "prior"))
    return lines


def interval_panels(results: DriveResults) -> list[Panel]:
    """Parameters on which a method says something beside the verdict; single wheels stand in the tables."""
    found = []
    for verdict in ordered(results.verdict.values()):
        if verdict.name.startswith(SINGLE_WHEELS):
            continue
        lines = _lines(results, verdict)
        if sum(line.kind in ("method", "witness") for line in lines) >= 1:
            found.append(Panel(verdict.name, tuple(lines), verdict.status, verdict.reference))
    return found


def _limits(panel: Panel) -> tuple[float, float]:
    """An axis that holds the verdict, the truth, and methods that are not far away."""
    lead = panel.lines[0]
    halves = [0.5 * (line.high - line.low) for line in panel.lines if line.high > line.low]
    half = 0.5 * (lead.high - lead.low) or (min(halves) if halves else abs(lead.value) * 0.1) or 1.0
    bottom, top = lead.value - FARTHEST * half, lead.value + FARTHEST * half
    ends = [end for line in panel.lines for end in (line.low, line.value, line.high)]
    if panel.reference is not None and np.isfinite(panel.reference):
        ends.append(panel.reference)
    low = max(bottom, min(ends))
    high = min(top, max(ends))
    pad = 0.06 * (high - low) or half
    return low - pad, high + pad


_LOOK = {
    "method": (BLUE, "o", 1.3),
    "witness": (PURPLE, "D", 1.0),
    "prior": (GREY, "|", 1.0),
}


def _draw_line(axes: Axes, line: Line, place: float, limits: tuple[float, float], status: str) -> None:
    colour, marker, width = _LOOK.get(line.kind, (STATUS_COLOURS.get(status, GREY), "o", 2.4))
    dashes = (0, (3, 2)) if line.kind == "prior" else "-"
    axes.plot(
        np.clip([line.low, line.high], *limits), [place] * 2, color=colour, linewidth=width, linestyle=dashes
    )
    if limits[0] <= line.value <= limits[1]:
        face = "white" if line.kind == "witness" else colour
        size = 4.6 if line.kind == "verdict" else 3.4
        axes.plot(
            [line.value],
            [place],
            marker,
            color=colour,
            markersize=size,
            markerfacecolor=face,
            markeredgewidth=0.9,
        )
        return
    edge, arrow = (limits[0], "<") if line.value < limits[0] else (limits[1], ">")
    axes.plot([edge], [place], arrow, color=colour, markersize=4.2, clip_on=False)


def _draw_panel(axes: Axes, panel: Panel, rows: int) -> None:
    limits = _limits(panel)
    lead = panel.lines[0]
    if lead.kind == "verdict":
        axes.axvspan(lead.low, lead.high, color=STATUS_COLOURS[panel.status], alpha=0.1, linewidth=0)
    for place, line in enumerate(panel.lines):
        _draw_line(axes, line, -place, limits, panel.status)
    if panel.reference is not None and limits[0] <= panel.reference <= limits[1]:
        axes.axvline(panel.reference, color=ORANGE, linewidth=1.0, linestyle=(0, (4, 2)))
    axes.set_xlim(*limits)
    axes.set_ylim(-rows + 0.4, 0.6)
    axes.set_yticks([-float(place) for place in range(len(panel.lines))])
    axes.set_yticklabels([middle(line.name, NAME_WIDTH) for line in panel.lines], fontsize=6.8)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    axes.locator_params(axis="x", nbins=5)
    spec = spec_of(panel.name)
    axes.set_title(f"{spec.title}{f', {spec.unit}' if spec.unit not in ('', EN_DASH) else ''}")


def _pages(pairs: Sequence[tuple[Panel, ...]]) -> list[list[tuple[Panel, ...]]]:
    """Rows of panels, as many in a piece as a page holds."""
    pages: list[list[tuple[Panel, ...]]] = [[]]
    used = 0.0
    for pair in pairs:
        height = _height(pair)
        if pages[-1] and used + height > TALLEST:
            pages.append([])
            used = 0.0
        pages[-1].append(pair)
        used += height
    return pages


def _height(pair: tuple[Panel, ...]) -> float:
    return HEAD + ROW * max(len(panel.lines) for panel in pair)


def draw(results: DriveResults) -> Drawing | Missing:
    """A panel a parameter, two in a row."""
    found = interval_panels(results)
    if not found:
        return Missing("Not drawn: no method that ran gives a value that could stand beside the verdict.")
    shown = found[:MOST]
    pairs = [tuple(shown[i : i + 2]) for i in range(0, len(shown), 2)]
    svgs: list[str] = []
    with styled():
        for page in _pages(pairs):
            heights = [_height(pair) for pair in page]
            figure = new_figure(FULL_WIDTH, sum(heights))
            grid = figure.subplots(len(page), 2, squeeze=False, gridspec_kw={"height_ratios": heights})
            for row, pair in zip(grid, page, strict=True):
                for place, axes in enumerate(row):
                    if place < len(pair):
                        _draw_panel(axes, pair[place], max(len(panel.lines) for panel in pair))
                    else:
                        axes.set_axis_off()
            svgs.append(to_svg(figure, f"methods{len(svgs)}", "Verdict and methods with 95 % intervals"))
    words = (
        "Bars: 95 % intervals. Thick, shaded through: the verdict; blue: cogest's own methods; purple diamonds: published methods, "
        "witnesses only; grey dashed: known before. An arrow at the edge: far outside."
    )
    if any(panel.reference is not None for panel in shown):
        words += " Orange dashed: reference."
    if len(found) > MOST:
        words += f" {len(found) - MOST} more parameters stand in the table."
    return Drawing(tuple(svgs), words, "Verdict and methods")
