"""Whole distributions of parameters over the drive: bands of their quantiles, and their densities at a few times."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import Distribution, FloatArray, ParameterEstimate
from reports.figures.drawing import Drawing, Missing
from reports.figures.grid import panels
from reports.figures.series import gap_spans, shade_gaps
from reports.figures.style import BLUE, GREY, ORANGE, PALE, TEAL, finish, styled
from reports.figures.thin import keep_rows
from reports.text import DASH, EN_DASH, clean, number, sentence, spec_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 12
BANDS = ((0.025, 0.975, 0.16), (0.25, 0.75, 0.30))
"""Lower and upper level, and how dark the band is."""

TIMES = 4
COLOURS = (PALE, GREY, TEAL, BLUE)
"""Densities from the first to the last time."""

SAMPLES, POINTS = 240, 160
LEAST_BANDWIDTH = 0.004


@dataclass(frozen=True)
class _Panel:
    """One panel of a parameter: its bands over time, or its densities."""

    distribution: Distribution
    estimator: str
    verdict: ParameterEstimate | None
    kind: Literal["bands", "densities"]


def usable(distribution: Distribution) -> bool:
    """Whether there is something to draw: two times or more, levels that rise, finite quantiles of fitting lengths."""
    levels, n = distribution.levels, distribution.time_s.size
    rises = len(levels) >= 3 and all(a < b for a, b in itertools.pairwise(levels))
    fits = len(levels) == len(distribution.quantiles) and all(q.shape == (n,) for q in distribution.quantiles)
    return bool(n > 1 and rises and fits and np.isfinite(distribution.quantiles[len(levels) // 2]).any())


def level(distribution: Distribution, share: float) -> FloatArray:
    """(n,) the quantile at a share, between the levels that are there."""
    table = np.array(distribution.quantiles)
    levels = np.array(distribution.levels)
    right = int(np.clip(np.searchsorted(levels, share), 1, len(levels) - 1))
    part = float(np.clip((share - levels[right - 1]) / (levels[right] - levels[right - 1]), 0.0, 1.0))
    return np.asarray((1 - part) * table[right - 1] + part * table[right])


def density(levels: tuple[float, ...], quantiles: FloatArray, grid: FloatArray) -> FloatArray:
    """(g,) a density with these quantiles: even draws through them, each spread by a Gaussian kernel (Silverman's width)."""
    draws = np.interp(np.linspace(levels[0], levels[-1], SAMPLES), levels, quantiles)
    middle = float(np.subtract(*np.interp((0.75, 0.25), levels, quantiles)))
    width = 0.9 * min(float(np.std(draws)), middle / 1.34 or np.inf) * SAMPLES**-0.2
    width = max(width, LEAST_BANDWIDTH * float(grid[-1] - grid[0]), 1e-12)
    return np.asarray(
        np.exp(-0.5 * ((grid[:, None] - draws) / width) ** 2).mean(axis=1) / width / np.sqrt(2 * np.pi)
    )


def _reference(panel: _Panel) -> float | None:
    return panel.verdict.reference if panel.verdict else None


def _title(panel: _Panel) -> str:
    spec = spec_of(panel.distribution.parameter)
    unit = f", {spec.unit}" if spec.unit not in ("", EN_DASH, DASH) else ""
    return f"{spec.title}{unit} ({clean(panel.estimator, 30)})"


def _draw_bands(axes: Axes, panel: _Panel, gaps: FloatArray, duration_s: float) -> None:
    found = panel.distribution
    middle = level(found, 0.5)
    edges = {f"{side}{i}": level(found, band[side]) for i, band in enumerate(BANDS) for side in (0, 1)}
    rows = keep_rows(found.time_s, {"middle": middle, **edges}, 1500)
    time = found.time_s[rows]
    for i, (_, _, dark) in enumerate(BANDS):
        axes.fill_between(
            time, edges[f"0{i}"][rows], edges[f"1{i}"][rows], color=BLUE, alpha=dark, linewidth=0
        )
    axes.plot(time, middle[rows], color=BLUE, linewidth=1.1)
    reference = _reference(panel)
    if reference is not None:
        axes.axhline(reference, color=ORANGE, linewidth=1.0, linestyle=(0, (4, 2)))
    shade_gaps(axes, gaps, duration_s)
    axes.set_title(_title(panel))
    axes.set_xlabel("time, s")
    finish(axes)
    if duration_s > 0:
        axes.set_xlim(0, max(duration_s, float(np.nanmax(time))))


def _draw_densities(axes: Axes, panel: _Panel) -> None:
    found = panel.distribution
    table = np.array(found.quantiles)
    whole = np.flatnonzero(np.isfinite(table).all(axis=0))
    rows = np.unique(whole[np.linspace(0, len(whole) - 1, TIMES).round().astype(np.int64)])
    low, high = float(table[:, rows].min()), float(table[:, rows].max())
    pad = 0.08 * (high - low) or 0.05 * abs(high) or 1.0
    grid = np.linspace(low - pad, high + pad, POINTS)
    for row, colour in zip(rows, COLOURS[-len(rows) :], strict=True):
        curve = density(found.levels, table[:, row], grid)
        last = row == rows[-1]
        axes.plot(grid, curve / curve.max(), color=colour, linewidth=1.4 if last else 0.9,
                  label=f"{number(float(found.time_s[row]), 0)} s")  # fmt: skip
        if last:
            axes.fill_between(grid, curve / curve.max(), color=colour, alpha=0.15, linewidth=0)
    reference = _reference(panel)
    if reference is not None and grid[0] < reference < grid[-1]:
        axes.axvline(reference, color=ORANGE, linewidth=1.0, linestyle=(0, (4, 2)))
    axes.set_yticks([])
    axes.set_ylim(0, 1.08)
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.locator_params(axis="x", nbins=5)
    axes.legend(loc="upper right", handlelength=1.2)
    axes.set_title("its density, each to its peak")
    axes.set_xlabel(spec_of(found.parameter).unit)


def draw(results: DriveResults) -> Drawing | Missing:
    """Two panels a distribution: bands over time, densities at four times; the truth is dashed where a reference is given."""
    found = [
        (distribution, estimate.estimator)
        for estimate in results.estimates
        for distribution in estimate.distributions
        if usable(distribution)
    ]
    if not found:
        return Missing("Not drawn: no estimator that ran gives whole distributions over the drive.")
    items = [
        _Panel(distribution, name, results.verdict.get(distribution.parameter), kind)
        for distribution, name in found[:MOST]
        for kind in ("bands", "densities")
    ]
    gaps = gap_spans(results.record.gaps)
    duration = results.record.duration_s

    def one(axes: Axes, panel: _Panel) -> None:
        if panel.kind == "bands":
            _draw_bands(axes, panel, gaps, duration)
        else:
            _draw_densities(axes, panel)

    with styled():
        svgs = panels(
            "distributions",
            "Distributions over the drive",
            items,
            one,
            rows_a_piece=1,
            row_height=2.0,
            shared_x=None,
        )
    notes = " ".join(dict.fromkeys(sentence(clean(d.note, 400)) for d, _ in found[:MOST] if d.note))
    caption = "Line: median; dark band: the middle half; pale band: 95 %. Right: the density at four times."
    if any(_reference(panel) is not None for panel in items):
        caption += " Dashed: reference."
    return Drawing(svgs, f"{caption} {notes}".strip(), "Distributions of parameters")
