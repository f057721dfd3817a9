"""Relations between two quantities with their fits and bands, beside the leading one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import Scatter
from reports.figures.drawing import Drawing, Missing
from reports.figures.grid import panels
from reports.figures.style import BLUE, ORANGE, styled
from reports.figures.thin import cells
from reports.text import clean

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 8


def all_scatters(results: DriveResults) -> list[Scatter]:
    """Every scatter with a point or a fit to draw, in the estimators' order."""
    return [
        s
        for e in results.estimates
        for s in e.scatters
        if np.isfinite(s.x).any() and np.isfinite(s.y).any() and s.x.size == s.y.size
    ]


def leading_scatter(results: DriveResults) -> Scatter | None:
    """The scatter of roll against lateral acceleration, or the first one there is."""
    found = all_scatters(results)
    for scatter in found:
        words = f"{scatter.name} {scatter.title}".lower()
        if "roll" in words and ("lateral" in words or "accel_y" in words or "ay" in words.split("_")):
            return scatter
    return found[0] if found else None


def draw_scatter(axes: Axes, scatter: Scatter) -> None:
    """Draw points (darker where there are more), the fit and its band."""
    index, counts = cells(scatter.x, scatter.y, 84, 64)
    common = np.quantile(counts, (0.5, 0.85)) if counts.size else (0, 0)
    level = np.searchsorted(common, counts, side="left")
    for step, alpha in ((0, 0.28), (1, 0.5), (2, 0.8)):
        chosen = index[level == step]
        if chosen.size:
            axes.plot(
                scatter.x[chosen],
                scatter.y[chosen],
                "o",
                markersize=2.0,
                color=BLUE,
                alpha=alpha,
                markeredgewidth=0,
                zorder=2,
            )
    axes.plot([], [], "o", markersize=3, color=BLUE, alpha=0.7, markeredgewidth=0, label="samples")
    if scatter.fit_x.size > 1:
        order = np.argsort(scatter.fit_x, kind="stable")
        fit_x = scatter.fit_x[order]
        if scatter.band_low.size == order.size == scatter.band_high.size:
            axes.fill_between(
                fit_x,
                scatter.band_low[order],
                scatter.band_high[order],
                color=ORANGE,
                alpha=0.22,
                linewidth=0,
                label="95 % band of the fit",
                zorder=3,
            )
        axes.plot(fit_x, scatter.fit_y[order], color=ORANGE, linewidth=1.4, label="fit", zorder=4)
    axes.set_xlabel(clean(scatter.x_label, 70))
    axes.set_ylabel(clean(scatter.y_label, 50))
    axes.locator_params(nbins=7)
    axes.legend(loc="best", handlelength=1.4)


def draw_scatter_panel(axes: Axes, scatter: Scatter) -> None:
    """Draw a scatter under its title."""
    draw_scatter(axes, scatter)
    axes.set_title(clean(scatter.title or scatter.name, 60))


def draw(results: DriveResults) -> Drawing | Missing:
    """Draw every scatter but the leading one."""
    leading = leading_scatter(results)
    rest = [s for s in all_scatters(results) if s is not leading]
    if not rest:
        return Missing("No estimator that ran gave a relation beside the one on the first screen.")
    with styled():
        svgs = panels(
            "scatters",
            "Relations between two quantities with fit and band",
            rest[:MOST],
            draw_scatter_panel,
            rows_a_piece=1,
            row_height=2.2,
            shared_x=None,
        )
    left = f" {len(rest) - MOST} more are not drawn." if len(rest) > MOST else ""
    return Drawing(
        svgs, f"Points, the fitted line and the 95 % band of that line.{left}", "Scatter plots with fits"
    )
