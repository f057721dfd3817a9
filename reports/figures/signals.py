"""The signals that the results stand on, as small multiples over the drive."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from parsers.signals import COLUMNS, WHEELS
from pipelines.drive_results import DriveResults
from pipelines.results import FloatArray
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 48
BUCKETS = 420
PLACES = (*WHEELS, "front", "rear")
"""Endings of names of one quantity at several places."""


@dataclass(frozen=True)
class _Panel:
    """A signal, or the same one of several wheels or axles. lines: what stands in the legend, and the line."""

    title: str
    unit: str
    lines: tuple[tuple[str, Series], ...]
    gaps: FloatArray


def _place(name: str) -> tuple[str, str]:
    """Stem and wheel or axle of a signal's name; the whole name and nothing where it has none."""
    stem, _, last = name.rpartition("_")
    return (stem, last) if stem and last in PLACES else (name, "")


def _panels(results: DriveResults) -> list[_Panel]:
    """One panel a signal; signals of the same kind and unit at several wheels share one."""
    found: dict[tuple[str, str, str], list[tuple[str, str, Series]]] = {}
    for trace in results.signals:
        for column, values in trace.columns.items():
            if values.size != trace.time_s.size or not np.isfinite(values).any():
                continue
            spec = COLUMNS.get(column)
            name = spec.name if spec else column
            stem, place = _place(name)
            unit = unit_of(column, trace.units.get(column))
            line = make_series(stem.replace("_", " "), unit, trace.time_s, values)
            key = (stem, line.unit, "wheels" if place else name)
            found.setdefault(key, []).append((name, place, line))
    panels_of = []
    for group in found.values():
        title = group[0][2].label + (f" {group[0][1]}" if len(group) == 1 and group[0][1] else "")
        lines = tuple((place, line) for _, place, line in group)
        gaps = gap_spans(results.record.gaps, group[0][0])
        panels_of.append(_Panel(title, group[0][2].unit, lines, gaps))
    return panels_of


def _draw_panel(axes: Axes, panel: _Panel, duration_s: float) -> None:
    shade_gaps(axes, panel.gaps, duration_s)
    for number, (place, line) in enumerate(panel.lines):
        buckets = BUCKETS if len(panel.lines) == 1 else BUCKETS // 2
        colour = LINES[number % len(LINES)]
        draw_series(axes, replace(line, label=place), panel.gaps, buckets, colour, linewidth=0.7)
    axes.set_title(f"{panel.title}, {panel.unit}" if panel.unit else panel.title, fontsize=7.5)
    finish(axes)
    axes.locator_params(axis="y", nbins=4)
    time_limits(axes, duration_s, [line for _, line in panel.lines])
    if len(panel.lines) > 1:
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=4, borderaxespad=0.1, handlelength=0.8, columnspacing=0.8,
            handletextpad=0.4, fontsize=6.5,
        )  # fmt: skip


def draw(results: DriveResults) -> Drawing | Missing:
    """One panel a signal; gaps are shaded and never bridged."""
    found = _panels(results)
    if not found:
        return Missing("Not drawn: no channel of the log became a signal.")
    with styled():
        svgs = panels(
            "signals", "Signals over the drive", found[:MOST],
            lambda axes, panel: _draw_panel(axes, panel, results.record.duration_s), across=3, row_height=1.1, rows_a_piece=2,
        )  # fmt: skip
    shaded = " Shaded: gaps, never bridged." if any(p.gaps.size for p in found[:MOST]) else ""
    left = f" {len(found) - MOST} more signals are not drawn." if len(found) > MOST else ""
    return Drawing(
        svgs,
        f"Thinned for the page; the highest and lowest sample of every span stay.{shaded}{left}",
        "Signals",
    )
