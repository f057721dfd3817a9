"""The fleet's CG heights and static stability factors against the measured vehicles."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.vehicles.measured import measured_vehicles
from reports.blocks import Plot
from reports.figures.style import BLUE, INK, PALE, new_figure, styled, to_svg
from reports.fleet.records import FleetView
from reports.text import NARROW, count, number, percent

WIDTH, HEIGHT = 4.3, 2.35
FEWEST = 2
"""Fewer figures than these make no distribution: they are marks alone."""


def best_of(view: FleetView, name: str) -> FloatArray:
    """A parameter of every drive: with all drives of its vehicle joined where that tells it, else the drive's own."""
    out = np.full(len(view.drives), np.nan)
    for source in (view.own, view.joined):
        answers = source.get(name)
        if answers is not None:
            known = np.isfinite(answers.value)
            out[known] = answers.value[known]
    return out


def medians(view: FleetView, values: FloatArray) -> FloatArray:
    """The median of each vehicle's drives; vehicles without a figure are left out."""
    groups = [values[list(v.drives)] for v in view.vehicles if v.drives]
    told = [group[np.isfinite(group)] for group in groups]
    return np.array([float(np.median(group)) for group in told if group.size])


def _edges(all_values: FloatArray, step: float) -> list[float]:
    low, high = float(all_values.min()), float(all_values.max())
    step = max(step, (high - low) / 80)
    edges: list[float] = np.arange(np.floor(low / step) * step, high + 1.5 * step, step).tolist()
    return edges


def _draw(
    name: str, measured: FloatArray, fleet: FloatArray, marks: FloatArray, step: float, label: str
) -> str:
    with styled():
        figure = new_figure(WIDTH, HEIGHT)
        axes = figure.subplots()
        inside = fleet[(fleet > 0.2 * measured.min()) & (fleet < 3 * measured.max())]
        edges = _edges(np.concatenate([measured, inside]), step)
        for values, colour, words, alpha in (
            (measured, PALE, f"{number(float(measured.size), 0)} measured vehicles", 1.0),
            (inside, BLUE, f"this fleet, {count(int(fleet.size), 'drive')}", 0.55),
        ):
            if values.size >= FEWEST:
                weights = np.full(values.size, 100.0 / values.size)
                axes.hist(values, edges, weights=weights, color=colour, alpha=alpha, label=words)
        top = axes.get_ylim()[1]
        axes.set_ylim(0, 1.62 * top)  # the legend stands above the bars
        words = f"this fleet, {count(int(marks.size), 'vehicle')}: median of its drives"
        axes.plot(
            marks, np.full(marks.size, 1.07 * top), "|", color=INK, markersize=6, alpha=0.8, label=words
        )
        axes.set_xlabel(label)
        axes.set_ylabel("% of their group")
        axes.grid(visible=False, axis="x")
        axes.legend(loc="upper right", handlelength=1.0)
        return to_svg(figure, name, f"Histogram of {label} of this fleet and of measured vehicles")


def _caption(measured: FloatArray, fleet: FloatArray, unit: str, what: str, digits: int) -> str:
    middle = float(np.median(fleet))
    lower = float(np.mean(measured < middle))
    unit = f"{NARROW}{unit}" if unit else ""
    return (
        f"Median of the fleet's drives {number(middle, digits)}{unit}, from {number(float(fleet.min()), digits)} to"
        f" {number(float(fleet.max()), digits)}{unit}. {percent(lower)} of the measured vehicles have a lower {what}."
    )


def plots(view: FleetView) -> tuple[Plot, ...]:
    """The two figures, or why there is none."""
    table = measured_vehicles()
    factor = table.track / (2 * table.height)
    factors = np.array([np.nan if d.factor is None else d.factor for d in view.drives], dtype=np.float64)
    wanted = (
        ("cg_heights", "CG heights against the measured vehicles", table.height, best_of(view, "cg_height_m"), 0.02, "CG height above ground, m", "CG", "m", 3),
        ("factors", "Static stability factors against them", factor, factors, 0.03, "static stability factor T/(2h)", "factor", "", 2),
    )  # fmt: skip
    out = []
    for name, title, population, values, step, label, what, unit, digits in wanted:
        measured = population[np.isfinite(population)]
        fleet = values[np.isfinite(values)]
        if not fleet.size:
            out.append(Plot(name, title, (), missing=f"Not drawn: no drive tells its {label.split(',')[0]}."))
            continue
        drawn = _draw(f"fleet-{name}", measured, fleet, medians(view, values), step, label)
        out.append(Plot(name, title, (drawn,), _caption(measured, fleet, unit, what, digits), alt=title))
    return tuple(out)
