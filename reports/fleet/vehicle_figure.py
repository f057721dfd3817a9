"""One vehicle's parameters over time, drawn for paper; the page on the screen draws the same from its data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.results import FloatArray
from reports.blocks import Plot
from reports.figures.style import BLUE, GREY, ORANGE, PALE, SOFT, STATUS_COLOURS, new_figure, styled, to_svg
from reports.fleet.records import LOAD, NEAR_G, Answers, FleetView, VehicleView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW_HEIGHT = 8.6, 1.5
DAY = 86_400.0
WILD = 3.0
"""Intervals reach beyond the usual by so many usual widths before the axis cuts them."""

STATUS_BY_CODE = {1: STATUS_COLOURS["identified"], 2: STATUS_COLOURS["weak"]}
Places = dict[int, float]


def _places(view: FleetView, drives: list[int]) -> tuple[Places, bool]:
    """Drive -> place on the axis, and whether that is a day (since 1970); else it is the drive's number."""
    starts = {d: view.drives[d].start for d in drives}
    known = {d: s / DAY for d, s in starts.items() if s is not None}
    if len(known) < 2 or len(known) < len(drives) / 2 or len(set(known.values())) < 2:
        return {d: float(k + 1) for k, d in enumerate(drives)}, False
    return known, True


def _picked(values: FloatArray, drives: list[int]) -> FloatArray:
    return values[np.array(drives, dtype=np.int64)]


def _whiskers(axes: Axes, answers: Answers, places: Places, colour: str | None, wide: float) -> None:
    """Intervals and values of drives; colour None: that of each answer's status."""
    drives = [d for d in places if np.isfinite(answers.value[d])]
    if not drives:
        return
    x = np.array([places[d] for d in drives])
    low, high, value = (_picked(a, drives) for a in (answers.low, answers.high, answers.value))
    colours = [colour or STATUS_BY_CODE.get(answers.status[d], GREY) for d in drives]
    axes.vlines(x, low, high, colors=colours, linewidth=wide)
    axes.scatter(x, value, s=2.2 * wide**2, c=colours, linewidths=0, zorder=3)


def _limit(axes: Axes, answers: list[Answers], drives: list[int]) -> None:
    """Keep the axis to what is usual: single wild intervals are cut."""
    low = np.concatenate([_picked(a.low, drives) for a in answers])
    high = np.concatenate([_picked(a.high, drives) for a in answers])
    good = np.isfinite(low) & np.isfinite(high)
    if not good.any():
        return
    usual = float(np.median(high[good] - low[good]))
    bottom = max(
        float(low[good].min()), float(np.median(low[good])) - WILD * usual, float(np.percentile(low[good], 1))
    )
    top = min(float(high[good].max()), float(np.percentile(high[good], 99)))
    if top > bottom:
        axes.set_ylim(bottom - 0.06 * (top - bottom), top + 0.06 * (top - bottom))


def _parameter(axes: Axes, view: FleetView, vehicle: VehicleView, name: str, places: Places) -> bool:
    joined, own = view.joined.get(name), view.own.get(name)
    drives = list(places)
    shown = [a for a in (joined, own) if a is not None and np.isfinite(_picked(a.value, drives)).any()]
    title, unit = view.titles[name]
    axes.set_title(f"{title}, {unit}" if unit and unit != "–" else title)
    if not shown:
        axes.text(0.5, 0.5, "no drive tells it", transform=axes.transAxes, ha="center", color=SOFT)
        return False
    if own is not None and joined is not None and joined in shown:
        _whiskers(axes, own, places, PALE, 0.8)
    _whiskers(axes, shown[0], places, None, 1.4)
    _limit(axes, shown[:1], drives)
    ids = {view.drives[d].drive_id: d for d in drives}
    for row in vehicle.changes:
        place = places.get(ids.get(str(row["drive_id"]), -1))
        if row["detected"] and place is not None:
            axes.axvline(place, color=ORANGE, linewidth=0.7, linestyle=(0, (3, 2)), zorder=0.8)
    return True


def _margin(axes: Axes, view: FleetView, places: Places) -> bool:
    axes.set_title("Least margin, threshold (–), g")
    told = [(x, view.drives[d]) for d, x in places.items() if view.drives[d].margin_g is not None]
    if not told:
        axes.text(0.5, 0.5, "no drive tells it", transform=axes.transAxes, ha="center", color=SOFT)
        return False
    x = np.array([place for place, _ in told])
    margin = np.array([d.margin_g for _, d in told], dtype=np.float64)
    threshold = np.array([np.nan if d.threshold_g is None else d.threshold_g for _, d in told])
    axes.axhspan(min(-0.02, float(margin.min())), NEAR_G, color="#fbe6e6", linewidth=0)
    axes.plot(x, threshold, "_", color=GREY, markersize=4)
    colours = ["#a4262c" if d.near else BLUE for _, d in told]
    axes.scatter(x, margin, s=5, c=colours, linewidths=0, zorder=3)
    return True


def _dated(figure: Figure) -> None:
    """Days on the axes, in UTC."""
    import matplotlib.dates

    dates: Any = matplotlib.dates

    for axes in figure.axes:
        if not axes.texts:
            locator = dates.AutoDateLocator(maxticks=5)
            axes.xaxis.set_major_locator(locator)
            axes.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator, tz="UTC"))


def vehicle_plot(view: FleetView, vehicle: VehicleView, name: str, title: str = "") -> Plot:
    """The load's parameters and the rollover margins of one vehicle; name makes the drawing's identifiers its own."""
    drives = [d for d in vehicle.drives if view.drives[d].status == "done"]
    if not drives:
        return Plot(
            name, title, (), missing="None of its drives could be analysed: nothing is known of this vehicle."
        )
    places, dated = _places(view, drives)
    with styled():
        figure = new_figure(WIDTH, 2 * ROW_HEIGHT)
        grid = figure.subplots(2, 3).flatten()
        told = [
            _parameter(axes, view, vehicle, parameter, places)
            for axes, parameter in zip(grid, LOAD, strict=False)
        ]
        told.append(_margin(grid[4], view, places))
        grid[5].remove()
        if not any(told):
            return Plot(
                name,
                title,
                (),
                missing="Its drives were analysed, but nothing could be told of this vehicle.",
            )
        for axes in figure.axes:
            if axes.texts:
                axes.set_xticks([])
                axes.set_yticks([])
                continue
            axes.locator_params(axis="y", nbins=4)
            if not dated:
                axes.set_xlim(0.5, len(places) + 0.5)
                axes.locator_params(axis="x", integer=True)
        if dated:
            _dated(figure)
        drawn = to_svg(figure, name, f"Parameters over time of {vehicle.label}")
    left = len(drives) - len(places)
    caption = (
        "Lines: 95 % intervals. Green: identified, amber: weak, with all drives joined; grey: the drive alone. Orange dashes: the load changed. "
        + ("By date (UTC)." if dated else "By number of the drive, as few have a date.")
        + (f" Without a date and not drawn: {left}." if left else "")
    )
    return Plot(name, title, (drawn,), caption, alt=f"Parameters over time of {vehicle.label}")
