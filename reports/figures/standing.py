"""Where this vehicle stands among the measured ones: their CG heights, this one's interval, and what was known before."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults, Standing
from pipelines.results import FloatArray, ParameterEstimate
from reports.figures.drawing import Drawing, Missing
from reports.figures.style import (
    GREY,
    INK,
    LEAD_HEIGHT,
    LEAD_WIDTH,
    PALE,
    SOFT,
    STATUS_COLOURS,
    TEAL,
    new_figure,
    styled,
    to_svg,
)
from reports.sections.values import has_result
from reports.text import NARROW, clean, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def _bins(population: FloatArray) -> list[float]:
    low, high = float(population.min()), float(population.max())
    step = 0.02 if high - low < 1.2 else (high - low) / 60
    edges: list[float] = np.arange(np.floor(low / step) * step, high + 1.5 * step, step).tolist()
    return edges


def _histograms(axes: Axes, standing: Standing) -> None:
    everyone = standing.population[np.isfinite(standing.population)]
    same = standing.same_body[np.isfinite(standing.same_body)]
    edges = _bins(everyone)
    _shares(axes, everyone, edges, PALE, f"all {number(float(everyone.size), 0)} vehicles", 1.0)
    if same.size:
        body = clean(standing.body or "the same body", 24)
        _shares(axes, same, edges, TEAL, f"{body} ({same.size})", 0.5)


def _shares(
    axes: Axes, heights: FloatArray, edges: list[float], colour: str, label: str, alpha: float
) -> None:
    """Bars in percent of the group's own number: a small group is seen beside a large one."""
    weights = np.full(heights.size, 100.0 / heights.size)
    axes.hist(heights, edges, weights=weights, color=colour, alpha=alpha, label=label)


def _markers(axes: Axes, cg: ParameterEstimate | None) -> None:
    """The result (solid, coloured by status) and the prior (dashed grey), each above the bars on its own line."""
    top = axes.get_ylim()[1]
    axes.set_ylim(0, top * 1.34)
    if cg is None:
        return
    if cg.prior is not None and np.isfinite([cg.prior.value, cg.prior.std]).all():
        _whisker(
            axes, cg.prior.value, 1.96 * cg.prior.std, top * 1.09, GREY, "prior, before the log", dashed=True
        )
    if cg.value is not None and has_result(cg) and cg.low is not None and cg.high is not None:
        colour = STATUS_COLOURS[cg.status]
        axes.axvspan(cg.low, cg.high, color=colour, alpha=0.13, linewidth=0)
        axes.axvline(cg.value, color=colour, linewidth=1.0, ymax=1.22 / 1.34)
        axes.plot([cg.low, cg.high], [top * 1.22] * 2, color=colour, linewidth=2.2)
        axes.plot([cg.value], [top * 1.22], "o", color=colour, markersize=4.5)
        axes.annotate(
            f"this drive: {number(cg.value, 3)}{NARROW}m",
            (cg.high, top * 1.22),
            (5, 0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
            color=colour,
        )


def _whisker(
    axes: Axes, centre: float, half: float, height: float, colour: str, text: str, *, dashed: bool
) -> None:
    axes.plot(
        [centre - half, centre + half],
        [height] * 2,
        color=colour,
        linewidth=1.2,
        linestyle=(0, (3, 2)) if dashed else "-",
    )
    axes.plot([centre], [height], "d", color=colour, markersize=3.5)
    axes.annotate(
        text,
        (centre + half, height),
        (5, 0),
        textcoords="offset points",
        va="center",
        fontsize=7.5,
        color=SOFT,
    )


def draw(results: DriveResults) -> Drawing | Missing:
    """Draw the histogram of measured CG heights with this vehicle's value, interval and prior."""
    standing = results.standing
    if standing is None or not np.isfinite(standing.population).any():
        return Missing(
            "Not drawn: without a body style or a CG height there is nothing to place among the measured vehicles."
        )
    cg = results.verdict.get("cg_height_m")
    with styled():
        figure = new_figure(LEAD_WIDTH, LEAD_HEIGHT)
        axes = figure.subplots()
        _histograms(axes, standing)
        _markers(axes, cg)
        axes.set_xlabel("CG height above ground, m")
        axes.set_ylabel("vehicles, % of their group", color=INK)
        axes.grid(visible=False, axis="x")
        axes.legend(loc="center right", handlelength=1.0)
        svg = to_svg(
            figure, "standing", "Histogram of measured CG heights with this vehicle's result and prior"
        )
    return Drawing((svg,), _caption(standing, cg), "Histogram of measured CG heights")


def _caption(standing: Standing, cg: ParameterEstimate | None) -> str:
    parts: list[str] = []
    body = clean(standing.body, 40) if standing.body else None
    if standing.percentile is not None and cg is not None and has_result(cg):
        among = f"measured vehicles of the body style {body}" if body else "measured vehicles"
        parts.append(f"{number(standing.percentile, 0)}{NARROW}% of the {among} have a lower CG.")
    elif cg is not None and not has_result(cg):
        parts.append("The prior is what was known before this drive, not a result.")
    if body is None:
        # a stated style that no measured vehicle has is none here either; "What limited the result" names it
        parts.append("No measured body style is known of this vehicle, so no group is highlighted.")
    if standing.nearest:
        parts.append("Nearest measured: " + "; ".join(clean(n, 80) for n in standing.nearest[:3]) + ".")
    return " ".join(parts)
