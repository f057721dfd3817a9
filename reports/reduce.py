"""Bring results of any length down to what a report and its archive need; twice is the same as once."""

from __future__ import annotations

from dataclasses import replace

from pipelines.drive_results import DriveResults
from pipelines.results import Estimate, Scatter, Trace, Track
from reports.figures.fits import is_residual, quantiles
from reports.figures.thin import keep_rows, spread_points

TRACE_ROWS = 6000
TRACK_ROWS = 3000
SCATTER_POINTS = 6000


def reduce_trace(trace: Trace) -> Trace:
    """Thin a trace's rows; no column loses the peak of any span."""
    if trace.time_s.ndim != 1 or any(v.shape != trace.time_s.shape for v in trace.columns.values()):
        return trace
    rows = keep_rows(trace.time_s, trace.columns, TRACE_ROWS)
    if rows.size == trace.time_s.size:
        return trace
    spread = {k: quantiles(v) for k, v in trace.columns.items() if is_residual(trace, k)}
    columns = {k: v[rows] for k, v in trace.columns.items()}
    return replace(trace, time_s=trace.time_s[rows], columns=columns, spread={**spread, **trace.spread})


def reduce_track(track: Track) -> Track:
    """Thin a track."""
    rows = keep_rows(track.time_s, {"v": track.value, "l": track.low, "h": track.high}, TRACK_ROWS)
    if rows.size == track.time_s.size:
        return track
    return replace(
        track, time_s=track.time_s[rows], value=track.value[rows], low=track.low[rows], high=track.high[rows]
    )


def reduce_scatter(scatter: Scatter) -> Scatter:
    """Thin a cloud of points."""
    index = spread_points(scatter.x, scatter.y, SCATTER_POINTS)
    return (
        scatter if index.size == scatter.x.size else replace(scatter, x=scatter.x[index], y=scatter.y[index])
    )


def _reduce_estimate(estimate: Estimate) -> Estimate:
    return replace(
        estimate,
        tracks=tuple(reduce_track(t) for t in estimate.tracks),
        traces=tuple(reduce_trace(t) for t in estimate.traces),
        scatters=tuple(reduce_scatter(s) for s in estimate.scatters),
        evidence=(),  # for the joint posterior only, which is made by now
    )


def reduce_results(results: DriveResults) -> DriveResults:
    """Thin every trace, track and cloud. Records stay as they are."""
    return replace(
        results,
        signals=tuple(reduce_trace(t) for t in results.signals),
        estimates=tuple(_reduce_estimate(e) for e in results.estimates),
        rollover=replace(results.rollover, traces=tuple(reduce_trace(t) for t in results.rollover.traces)),
    )
