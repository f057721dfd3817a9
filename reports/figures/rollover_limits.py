"""The limits of the lateral acceleration to both sides with their intervals, and how far the drive went."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import ParameterEstimate
from pipelines.rollover_results import Rollover
from reports.figures.drawing import Drawing, Missing
from reports.figures.style import BLUE, FULL_WIDTH, GREY, INK, ORANGE, SOFT, new_figure, styled, to_svg
from reports.sections.values import has_result
from reports.text import clean, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def _ends(estimate: ParameterEstimate) -> tuple[float, float, float] | None:
    if estimate.value is None or estimate.low is None or estimate.high is None:
        return None
    ends = (estimate.low, estimate.value, estimate.high)
    return ends if np.isfinite(ends).all() else None


def _names(rollover: Rollover) -> list[str]:
    return [f"{clean(limit.title, 60)}\n{clean(limit.equation, 30)}" for limit in reversed(rollover.limits)]


def _whiskers(axes: Axes, rollover: Rollover) -> float:
    """One line a limit, the same to both sides; gives the farthest end."""
    farthest = 0.0
    for place, limit in enumerate(reversed(rollover.limits)):
        leads = place == 0
        for sign, estimate in ((1.0, limit.left), (-1.0, limit.right)):
            ends = _ends(estimate)
            if ends is None:
                continue
            low, value, high = (sign * end for end in ends)
            colour = GREY if not has_result(estimate) else ORANGE if leads else BLUE
            if leads:
                axes.axvspan(min(low, high), max(low, high), color=colour, alpha=0.16, linewidth=0)
            axes.plot([low, high], [place] * 2, color=colour, linewidth=2.4 if leads else 1.6)
            axes.plot([value], [place], "o", color=colour, markersize=4.5)
            axes.annotate(
                number(abs(value), 2), (value, place), (0, 5), textcoords="offset points", ha="center", fontsize=7.5,
                color=colour,
            )  # fmt: skip
            farthest = max(farthest, abs(low), abs(high))
    axes.set_yticks(range(len(rollover.limits)))
    axes.set_yticklabels(_names(rollover))
    return farthest


def _drive(axes: Axes, rollover: Rollover) -> float:
    """How the drive's lateral acceleration spread, as a line under the limits."""
    trace = next((t for t in rollover.traces if t.name == "rollover margin"), None)
    values = None if trace is None else trace.columns.get("lateral_acceleration")
    if values is None or not np.isfinite(values).any():
        return 0.0
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    axes.plot([low, high], [-1] * 2, color=INK, linewidth=5.0, solid_capstyle="butt", alpha=0.75)
    for end in (low, high):
        axes.annotate(
            number(abs(end), 2),
            (end, -1),
            (0, 6),
            textcoords="offset points",
            ha="center",
            fontsize=7.5,
            color=INK,
        )
    axes.set_yticks([-1, *range(len(rollover.limits))])
    labels = _names(rollover)
    axes.set_yticklabels(["This drive", *labels])
    return max(abs(low), abs(high))


def draw(results: DriveResults) -> Drawing | Missing:
    """Whiskers to the left for right turns, to the right for left turns."""
    rollover = results.rollover
    if not rollover.limits:
        return Missing("Not drawn: without a CG height and a track width there are no limits.")
    with styled():
        figure = new_figure(FULL_WIDTH, 0.42 * len(rollover.limits) + 1.05)
        axes = figure.subplots()
        farthest = max(_whiskers(axes, rollover), _drive(axes, rollover), 0.2)
        axes.axvline(0, color=SOFT, linewidth=0.8)
        axes.set_xlim(-1.08 * farthest, 1.08 * farthest)
        axes.set_ylim(-1.6, len(rollover.limits) - 0.3)
        axes.grid(visible=False, axis="y")
        axes.set_xlabel(
            "lateral acceleration along the road, g      (− right turn: right wheels lift,  + left turn: left wheels lift)"
        )
        axes.tick_params(axis="y", length=0)
        svg = to_svg(
            figure, "rollover_limits", "Limits of the lateral acceleration to both sides with 95 % intervals"
        )
    known = has_result(rollover.limits[-1].left)
    words = "Bars: 95 % intervals; the shaded one is the threshold, with the body's roll. Black: what this drive reached."
    if not known:
        words += " Grey: from what was known before the log, no result."
    return Drawing((svg,), words, "Limits of the lateral acceleration")
