"""One vehicle's parameters over time, drawn for paper; the page on the screen draws the same from its data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.results import FloatArray
from reports.blocks import Plot
from reports.figures.style import BLUE, GREY, ORANGE, PALE, SOFT, STATUS_COLOURS, new_figure, styled, to_svg
from reports.fleet.records import LOAD, NEAR_G, Answers, FleetView, VehicleView
from reports.text import count

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW_HEIGHT = 8.6, 1.5
DAY = 86_400.0
WILD = 3.0
"""Intervals reach beyond the usual by so many usual widths before the axis cuts them."""

STATUS_BY_CODE = {1: STATUS_COLOURS["identified"], 2: STATUS_COLOURS["weak"]}
STRIP_FROM, STRIP_TO = 0.08, 0.22
"""Where the strip of drives without a date begins and ends behind the last one with a date, as shares of the time between the dated ones."""

Places = dict[int, float]


@dataclass(frozen=True)
class _Days:
    """An axis of days since 1970: first and last drive, and how many drives without a date stand in a strip behind them."""

    first: float
    last: float
    undated: int

    @property
    def strip(self) -> tuple[float, float]:
        """Where the strip begins and ends."""
        width = self.last - self.first
        return self.last + STRIP_FROM * width, self.last + STRIP_TO * width

    def behind(self, number: int) -> float:
        """The place of one of the drives without a date, counted from 0."""
        begin, end = self.strip
        return begin + (end - begin) * (number + 0.5) / self.undated


def _places(view: FleetView, drives: list[int]) -> tuple[Places, _Days | None]:
    """Drive -> place on the axis of days, those without a date behind the last; without days it is the drive's number."""
    starts = {d: view.drives[d].start for d in drives}
    known = {d: s / DAY for d, s in starts.items() if s is not None}
    if len(known) < 2 or len(known) < len(drives) / 2 or len(set(known.values())) < 2:
        return {d: float(k + 1) for k, d in enumerate(drives)}, None
    undated = [d for d in drives if d not in known]
    days = _Days(min(known.values()), max(known.values()), len(undated))
    return {**known, **{d: days.behind(k) for k, d in enumerate(undated)}}, days


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


def _dated(figure: Figure, days: _Days) -> None:
    """Days on the axes, in UTC, and the strip of drives without a date."""
    import matplotlib.dates

    dates: Any = matplotlib.dates

    for axes in figure.axes:
        if not axes.texts:
            locator = dates.AutoDateLocator(maxticks=5)
            axes.xaxis.set_major_locator(locator)
            words = dates.ConciseDateFormatter(locator, tz="UTC")
            axes.xaxis.set_major_formatter(words)
            if days.undated:
                _strip(axes, days, locator, words)


def _strip(axes: Axes, days: _Days, locator: Any, words: Any) -> None:
    """Set the strip of drives without a date apart; ticks of days end before it. words: how days are written."""
    begin, end = days.strip
    width = days.last - days.first
    # room for the strip's own word
    ticks = [t for t in locator() if days.first <= t <= days.last - STRIP_FROM * width]
    axes.set_xticks([*ticks, (begin + end) / 2], [*words.format_ticks(ticks), "no date"])
    axes.xaxis.get_major_formatter().set_offset_string(words.get_offset())  # type: ignore[attr-defined]
    axes.axvline(begin, color=GREY, linewidth=0.5, zorder=0.5)
    axes.set_xlim(days.first - 0.03 * width, end)


def vehicle_plot(view: FleetView, vehicle: VehicleView, name: str, title: str = "") -> Plot:
    """The load's parameters and the rollover margins of one vehicle; name makes the drawing's identifiers its own."""
    drives = [d for d in vehicle.drives if view.drives[d].status == "done"]
    if not drives:
        return Plot(
            name, title, (), missing="None of its drives could be analysed: nothing is known of this vehicle."
        )
    places, days = _places(view, drives)
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
            if days is None:
                axes.set_xlim(0.5, len(places) + 0.5)
                axes.locator_params(axis="x", integer=True)
        if days is not None:
            _dated(figure, days)
        drawn = to_svg(figure, name, f"Parameters over time of {vehicle.label}")
    caption = (
        "Lines: 95 % intervals. Green: identified, amber: weak, with all drives joined; grey: the drive alone. Orange dashes: the load changed. "
        + ("By date (UTC)." if days is not None else "By number of the drive, as few have a date.")
        + (
            f" In the strip at the right: {count(days.undated, 'drive')} without a date."
            if days and days.undated
            else ""
        )
    )
    return Plot(name, title, (drawn,), caption, alt=f"Parameters over time of {vehicle.label}")
