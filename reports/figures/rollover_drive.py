"""The drive against its rollover limits, and the rollover coefficient over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import FloatArray, Trace
from reports.figures.drawing import Drawing, Missing
from reports.figures.series import gap_spans, shade_gaps
from reports.figures.style import (
    BLUE,
    FULL_WIDTH,
    GREY,
    ORANGE,
    PURPLE,
    TEAL,
    finish,
    new_figure,
    styled,
    to_svg,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TALL = 2.1
LOW = 1.0


def _trace(results: DriveResults, name: str) -> Trace | None:
    found = next((t for t in results.rollover.traces if t.name == name), None)
    if (
        found is None
        or found.time_s.size < 2
        or any(v.shape != found.time_s.shape for v in found.columns.values())
    ):
        return None
    return found


def _empty(trace: Trace) -> FloatArray:
    return np.full(trace.time_s.shape, np.nan)


def _lifts(axes: Axes, results: DriveResults) -> None:
    """Turns' wheel lifts as bars along the time axis."""
    spans = [
        (e.start_s, max(e.duration_s, 0.002 * results.record.duration_s))
        for e in results.rollover.lifts
        if e.kind != "bounce"
    ]
    if spans:
        axes.broken_barh(
            spans, (0.0, 0.03), transform=axes.get_xaxis_transform(), facecolors=PURPLE, label="wheel lift"
        )


def _times(axes: Axes, results: DriveResults, trace: Trace) -> None:
    shade_gaps(axes, gap_spans(results.record.gaps), results.record.duration_s)
    finish(axes)
    axes.set_xlim(0, max(results.record.duration_s, float(np.nanmax(trace.time_s))))


def draw_margin(results: DriveResults) -> Drawing | Missing:
    """Lateral acceleration between the limits of both sides, whose bands are their 95 % intervals."""
    trace = _trace(results, "rollover margin")
    if trace is None:
        return Missing("Not drawn: the margin needs the CG height, the track width and lateral acceleration.")
    get = trace.columns.get
    with styled():
        figure = new_figure(FULL_WIDTH, TALL)
        axes = figure.subplots()
        for side, colour, words in (
            ("left", ORANGE, "left wheels lift"),
            ("right", TEAL, "right wheels lift"),
        ):
            low, high = get(f"limit_{side}_low", _empty(trace)), get(f"limit_{side}_high", _empty(trace))
            axes.fill_between(trace.time_s, low, high, color=colour, alpha=0.25, linewidth=0)
            axes.plot(
                trace.time_s,
                get(f"limit_{side}", _empty(trace)),
                color=colour,
                linewidth=0.9,
                label=f"limit: {words}",
            )
        axes.plot(
            trace.time_s,
            get("lateral_acceleration", _empty(trace)),
            color=BLUE,
            linewidth=0.9,
            label="this drive",
        )
        for turn in results.rollover.turns:
            axes.plot(
                [turn.time_s],
                [turn.lateral_acceleration_g],
                "v" if turn.turn == "left" else "^",
                color=BLUE,
                markersize=4,
            )
        _lifts(axes, results)
        axes.set_ylabel("lateral acceleration, g")
        axes.set_xlabel("time, s")
        _times(axes, results, trace)
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 0.99), ncols=4, borderaxespad=0.1, handlelength=1.4
        )
        svg = to_svg(
            figure,
            "rollover_margin",
            "Lateral acceleration over the drive between the rollover limits of both sides",
        )
    return Drawing(
        (svg,),
        "The limits come nearer as the body rolls, (163); bands: 95 %. Triangles: where each side's margin was least.",
        "Lateral acceleration between the rollover limits",
    )


def draw_coefficient(results: DriveResults) -> Drawing | Missing:
    """The coefficient from accelerations with its band, from tyre forces where known, and their difference."""
    trace = _trace(results, "rollover coefficient")
    if trace is None:
        return Missing(
            "Not drawn: the rollover coefficient needs the CG height, the track width and lateral acceleration."
        )
    get = trace.columns.get
    forces = get("from_forces")
    measured = forces is not None and bool(np.isfinite(forces).any())
    with styled():
        figure = new_figure(FULL_WIDTH, TALL + (LOW if measured else 0.0))
        grid = figure.subplots(
            2 if measured else 1, 1, squeeze=False, height_ratios=(TALL, LOW) if measured else (1,)
        )
        axes = grid[0][0]
        axes.fill_between(
            trace.time_s,
            get("low", _empty(trace)),
            get("high", _empty(trace)),
            color=BLUE,
            alpha=0.22,
            linewidth=0,
        )
        axes.plot(
            trace.time_s,
            get("coefficient", _empty(trace)),
            color=BLUE,
            linewidth=0.9,
            label="from accelerations and roll, (160)",
        )
        if measured and forces is not None:
            axes.plot(trace.time_s, forces, color=ORANGE, linewidth=0.7, label="from tyre forces, (158)")
        for bound in (-1.0, 1.0):
            axes.axhline(bound, color=GREY, linewidth=0.9, linestyle=(0, (4, 2)))
        _lifts(axes, results)
        axes.set_ylabel("(left − right) / sum")
        _times(axes, results, trace)
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 0.99), ncols=3, borderaxespad=0.1, handlelength=1.4
        )
        if measured:
            axes.tick_params(labelbottom=False)
            below = grid[1][0]
            below.plot(trace.time_s, get("residual", _empty(trace)), color=PURPLE, linewidth=0.7)
            below.set_ylabel("difference")
            _times(below, results, trace)
        grid[-1][0].set_xlabel("time, s")
        svg = to_svg(figure, "rollover_coefficient", "Rollover coefficient over the drive")
    return Drawing(
        (svg,),
        "-1: the left wheels carry nothing, +1: the right ones. Band: 95 %, from the intervals of height, track, offset and roll.",
        "Rollover coefficient over the drive",
    )
