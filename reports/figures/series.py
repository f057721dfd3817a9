"""Traces made ready for a panel: in the units that an engineer reads, thinned, broken at gaps, gaps shaded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from parsers.drive import Gap
from parsers.signals import COLUMNS, SIGNALS
from pipelines.results import FloatArray
from reports.figures.style import GAP
from reports.figures.thin import break_at, jumps, keep, lonely, merge_spans
from reports.text import clean

if TYPE_CHECKING:
    from matplotlib.axes import Axes

READABLE: dict[str, tuple[float, str]] = {
    "rad": (math.degrees(1.0), "deg"),
    "rad/s": (math.degrees(1.0), "deg/s"),
    "Pa": (1e-5, "bar"),
    "pa": (1e-5, "bar"),
}
"""SI units that nobody reads off a plot, and what is drawn instead."""

SI_OF_QUANTITY = {
    "acceleration": "m/s²",
    "angular_rate": "rad/s",
    "angle": "rad",
    "slope": "rad",
    "speed": "m/s",
    "geographic_angle": "deg",
    "length": "m",
    "pressure": "Pa",
    "force": "N",
    "torque": "N·m",
}


@dataclass(frozen=True)
class Series:
    """One line: label, unit, time_s and values (n,) with NaN at gaps; spread: quantiles in equal steps, or empty."""

    label: str
    unit: str
    time_s: FloatArray
    values: FloatArray
    spread: FloatArray


def unit_of(column: str, stated: str | None) -> str:
    """The unit stated with the trace, or the canonical one where the column is a signal."""
    if stated:
        return stated
    spec = SIGNALS.get(column) or COLUMNS.get(column)
    return SI_OF_QUANTITY.get(spec.quantity, "") if spec else ""


def make_series(
    label: str, unit: str, time_s: FloatArray, values: FloatArray, spread: FloatArray | None = None
) -> Series:
    """Convert to a readable unit; what is not finite becomes missing, rows without a time go."""
    factor, shown = READABLE.get(unit, (1.0, unit))
    time = np.asarray(time_s, dtype=np.float64)
    drawn = np.asarray(values, dtype=np.float64) * factor
    drawn = np.where(np.isfinite(drawn), drawn, np.nan)
    whole = np.isfinite(time)
    if not whole.all():
        time, drawn = time[whole], drawn[whole]
    if time.size > 1 and (np.diff(time) < 0).any():
        order = np.argsort(time, kind="stable")
        time, drawn = time[order], drawn[order]
    levels = np.empty(0) if spread is None else np.asarray(spread, dtype=np.float64) * factor
    return Series(clean(label, 44), clean(shown, 12), time, drawn, levels)


def gap_spans(gaps: Sequence[Gap], signal: str | None = None) -> FloatArray:
    """Gaps of the whole drive, and of one signal where it is named: (g, 2) seconds."""
    spans = [(g.start_s, g.end_s) for g in gaps if g.signal is None or g.signal == signal]
    return np.array(spans, dtype=np.float64).reshape(-1, 2)


def draw_series(
    axes: Axes, series: Series, gaps: FloatArray, buckets: int, colour: str, **style: Any
) -> None:
    """Draw one line, thinned to `buckets` spans, broken at gaps and where the trace has no samples; single samples between are dots."""
    gaps = np.vstack([gaps.reshape(-1, 2), jumps(series.time_s)])
    time, values = break_at(series.time_s, series.values, gaps)
    index = keep(time, values, buckets)
    time, values = time[index], values[index]
    axes.plot(time, values, color=colour, label=series.label, **style)
    alone = lonely(values)
    if alone.any():
        axes.plot(time[alone], values[alone], ".", color=colour, markersize=1.5, linestyle="none")


def shade_gaps(axes: Axes, gaps: FloatArray, duration_s: float) -> None:
    """Shade gaps; those nearer than the eye can tell are one."""
    if gaps.size == 0:
        return
    least = max(duration_s, 1e-9) / 600
    spans = merge_spans(gaps, least)
    bars = [(float(a), max(float(b - a), least)) for a, b in spans]
    axes.broken_barh(bars, (0.0, 1.0), transform=axes.get_xaxis_transform(), facecolors=GAP, zorder=0.5)


def time_limits(axes: Axes, duration_s: float, series: Sequence[Series]) -> None:
    """The same span of time on every panel: the drive's, or the data's where it is longer."""
    ends = [float(s.time_s[-1]) for s in series if s.time_s.size]
    starts = [float(s.time_s[0]) for s in series if s.time_s.size]
    low = min([0.0, *starts])
    high = max([duration_s if math.isfinite(duration_s) else 0.0, *ends])
    if high > low:
        axes.set_xlim(low - 0.005 * (high - low), high + 0.005 * (high - low))
