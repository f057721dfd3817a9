"""The four tyre normal forces over the drive with their intervals, and beside them what measuring wheels said."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import Trace
from pipelines.tire_forces import is_force_trace
from reports.figures.drawing import Drawing, Missing
from reports.figures.grid import panels
from reports.figures.series import gap_spans, shade_gaps
from reports.figures.style import BLUE, GREY, ORANGE, finish, styled
from reports.text import clean

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NEEDED = ("force", "low", "high")
BAND = 0.3


def force_traces(results: DriveResults) -> list[Trace]:
    """The traces of tyre forces that can be drawn, a wheel each."""
    return [
        trace
        for estimate in results.estimates
        for trace in estimate.traces
        if is_force_trace(trace)
        and trace.time_s.size > 1
        and all(name in trace.columns and trace.columns[name].shape == trace.time_s.shape for name in NEEDED)
    ]


def draw(results: DriveResults) -> Drawing | Missing:
    """One panel a wheel: the force, its band, zero, and the measured force where the log has it."""
    found = force_traces(results)
    if not found:
        return Missing("Not drawn: tyre forces need a suspension map of the vehicle.")
    gaps, duration = gap_spans(results.record.gaps), results.record.duration_s

    def one(axes: Axes, trace: Trace) -> None:
        shade_gaps(axes, gaps, duration)
        time, get = trace.time_s, trace.columns
        axes.fill_between(time, get["low"] / 1e3, get["high"] / 1e3, color=BLUE, alpha=BAND, linewidth=0)
        measured = get.get("measured")
        if measured is not None and measured.shape == time.shape:
            axes.plot(time, measured / 1e3, color=ORANGE, linewidth=0.7, label="measured")
        axes.plot(time, get["force"] / 1e3, color=BLUE, linewidth=0.7, label="by the map")
        axes.axhline(0.0, color=GREY, linewidth=0.6)
        axes.set_title(clean(trace.name, 60))
        axes.set_ylabel("kN")
        axes.set_xlim(0, max(duration, float(np.nanmax(time))))
        finish(axes)
        if measured is not None:
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.99), ncols=2, borderaxespad=0.1)

    with styled():
        pieces = panels("tire_forces", "Tyre normal forces over the drive", found, one, row_height=1.7)
    return Drawing(
        pieces,
        "Bands: 95 % interval at each instant. A wheel whose band reaches zero may have left the road.",
        "Tyre normal forces of the four wheels over the drive",
    )
