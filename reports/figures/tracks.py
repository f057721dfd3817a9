"""Parameters over the drive, as data came in, with their 95 % intervals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.results import FloatArray, ParameterEstimate, Track
from reports.figures.drawing import Drawing, Missing
from reports.figures.grid import panels
from reports.figures.series import gap_spans, shade_gaps
from reports.figures.style import BLUE, ORANGE, finish, styled
from reports.figures.thin import keep_rows
from reports.text import DASH, EN_DASH, clean, spec_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 18


@dataclass(frozen=True)
class _Panel:
    track: Track
    estimator: str
    verdict: ParameterEstimate | None


def _limits(track: Track, reference: float | None) -> tuple[float, float] | None:
    """Limits of the axis from the settled half of the track: the wide beginning may leave the frame."""
    known = np.flatnonzero(np.isfinite(track.value))
    settled = known[known.size // 2 :]
    low, high = track.low[settled], track.high[settled]
    inside = np.concatenate((low[np.isfinite(low)], high[np.isfinite(high)]))
    if inside.size == 0:
        return None
    bottom, top = (float(q) for q in np.quantile(inside, (0.02, 0.98)))
    if reference is not None:
        bottom, top = min(bottom, reference), max(top, reference)
    pad = 0.12 * (top - bottom) or 0.05 * abs(top) or 1.0
    return bottom - pad, top + pad


def _draw_panel(axes: Axes, panel: _Panel, gaps: FloatArray, duration_s: float) -> None:
    track = panel.track
    spec = spec_of(track.parameter)
    rows = keep_rows(track.time_s, {"value": track.value, "low": track.low, "high": track.high}, 1500)
    time = track.time_s[rows]
    axes.fill_between(time, track.low[rows], track.high[rows], color=BLUE, alpha=0.18, linewidth=0)
    axes.plot(time, track.value[rows], color=BLUE, linewidth=1.1)
    reference = panel.verdict.reference if panel.verdict else None
    if reference is not None:
        axes.axhline(reference, color=ORANGE, linewidth=1.0, linestyle=(0, (4, 2)))
    limits = _limits(track, reference)
    if limits:
        axes.set_ylim(*limits)
    shade_gaps(axes, gaps, duration_s)
    unit = f", {spec.unit}" if spec.unit not in ("", EN_DASH, DASH) else ""
    axes.set_title(f"{spec.title}{unit}\n{clean(panel.estimator, 40)}", fontsize=7.5)
    finish(axes)
    if duration_s > 0:
        axes.set_xlim(0, max(duration_s, float(np.nanmax(track.time_s))))


def draw(results: DriveResults) -> Drawing | Missing:
    """One panel a track; the truth is dashed where a reference is given."""
    found = [
        _Panel(track, estimate.estimator, results.verdict.get(track.parameter))
        for estimate in sorted(results.estimates, key=lambda e: e.witness)
        for track in estimate.tracks
        if track.time_s.size > 1 and np.isfinite(track.value).any()
    ]
    if not found:
        return Missing("Not drawn: no estimator that ran follows its parameters over the drive.")
    gaps = gap_spans(results.record.gaps)
    duration = results.record.duration_s
    with styled():
        svgs = panels(
            "tracks", "Estimates over the drive with 95 % intervals", found[:MOST],
            lambda axes, panel: _draw_panel(axes, panel, gaps, duration), across=3, row_height=1.35, rows_a_piece=1,
        )  # fmt: skip
    left = f" {len(found) - MOST} more tracks are not drawn." if len(found) > MOST else ""
    return Drawing(
        svgs,
        "Line: estimate from the data up to that time; band: its 95 % interval; the wide beginning may leave the frame."
        + (" Dashed: reference." if any(p.verdict and p.verdict.reference is not None for p in found) else "")
        + left,
        "Parameter tracks",
    )
