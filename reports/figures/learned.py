"""Before and after: the densities of the main parameters as they were known and as the joint posterior has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import FloatArray, Learned, ParameterEstimate
from reports.figures.drawing import Drawing, Missing
from reports.figures.grid import panels
from reports.figures.style import GREY, INK, ORANGE, PALE, STATUS_COLOURS, styled
from reports.sections.joint_words import learned_in_order
from reports.text import EN_DASH, spec_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 9
LEAST_HEIGHT = 0.004
"""Share of its peak below which a density is not worth room on the axis."""


@dataclass(frozen=True)
class _Panel:
    name: str
    learned: Learned
    verdict: ParameterEstimate | None


def _drawable(learned: Learned) -> bool:
    sizes = {learned.grid.size, learned.prior_density.size, learned.density.size}
    if len(sizes) != 1 or learned.grid.size < 3 or not np.isfinite(learned.grid).all():
        return False
    return bool(np.isfinite(learned.density).any() and np.nanmax(learned.density) > 0)


def _to_peak(density: FloatArray) -> FloatArray:
    """Scaled so that its peak is 1; what is not finite is nought."""
    whole = np.where(np.isfinite(density), density, 0.0)
    peak = float(whole.max())
    return whole / peak if peak > 0 else whole


def _as_told(grid: FloatArray, density: FloatArray, verdict: ParameterEstimate | None) -> FloatArray:
    """The grid on which the posterior's density stands at the answer: doubts that came after it moved and widened that.

    grid: (n,) rising. density: (n,), its peak 1.
    """
    if verdict is None or verdict.value is None or not verdict.std:
        return grid
    mass = density * np.gradient(grid)
    mean = float(np.average(grid, weights=mass))
    own = float(np.sqrt(np.average((grid - mean) ** 2, weights=mass)))
    return verdict.value + (grid - mean) * (verdict.std / own) if own > 0 else grid


def _limits(curves: Sequence[tuple[FloatArray, FloatArray]], reference: float | None) -> tuple[float, float]:
    """What holds the densities, and the truth where it is near. curves: each one's grid and density."""
    seen = np.concatenate([grid[density > LEAST_HEIGHT] for grid, density in curves])
    low, high = float(seen.min()), float(seen.max())
    if reference is not None and low - 0.5 * (high - low) < reference < high + 0.5 * (high - low):
        low, high = min(low, reference), max(high, reference)
    pad = 0.03 * (high - low) or abs(high) * 0.01 or 1.0
    return low - pad, high + pad


def _draw_panel(axes: Axes, panel: _Panel) -> None:
    learned, verdict = panel.learned, panel.verdict
    order = np.argsort(learned.grid, kind="stable")
    grid = learned.grid[order]
    before, after = _to_peak(learned.prior_density[order]), _to_peak(learned.density[order])
    colour = STATUS_COLOURS[verdict.status] if verdict else INK
    axes.fill_between(grid, before, color=PALE, alpha=0.7, linewidth=0)
    axes.plot(grid, before, color=GREY, linewidth=0.7)
    curves = [(grid, before)]
    if verdict is None or verdict.status != "not_identifiable":
        at = _as_told(grid, after, verdict)
        axes.fill_between(at, after, color=colour, alpha=0.3, linewidth=0)
        axes.plot(at, after, color=colour, linewidth=1.2)
        curves.append((at, after))
    reference = verdict.reference if verdict else None
    limits = _limits(curves, reference)
    if reference is not None and limits[0] <= reference <= limits[1]:
        axes.axvline(reference, color=ORANGE, linewidth=1.1, linestyle=(0, (4, 2)))
    axes.set_xlim(*limits)
    axes.set_ylim(0, 1.08)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.grid(visible=False, axis="y")
    axes.locator_params(axis="x", nbins=5)
    spec = spec_of(panel.name)
    unit = f", {spec.unit}" if spec.unit not in ("", EN_DASH) else ""
    axes.set_title(f"{spec.title}{unit}")


def draw(results: DriveResults) -> Drawing | Missing:
    """One panel a parameter: grey = known before, coloured = after the drive."""
    if results.joint is None:
        return Missing("Not drawn: no relation of this log entered a joint posterior.")
    found = [
        _Panel(name, learned, results.verdict.get(name))
        for name, learned in learned_in_order(results)
        if _drawable(learned)
    ]
    if not found:
        return Missing("Not drawn: the joint posterior holds no parameter whose density is known.")
    with styled():
        svgs = panels(
            "learned", "Densities before and after the drive", found[:MOST], _draw_panel,
            across=3, row_height=1.0, shared_x=None,
        )  # fmt: skip
    known = any(p.verdict is not None and p.verdict.reference is not None for p in found[:MOST])
    return Drawing(
        svgs,
        "Grey: known before the log; coloured: after it (green identified, amber weak), where the drive tells something. Each is drawn to the same height."
        + (" Dashed: reference." if known else "")
        + (f" {len(found) - MOST} more parameters stand in the table." if len(found) > MOST else ""),
        "Prior and posterior densities",
    )
