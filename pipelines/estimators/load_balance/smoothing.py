"""Columns low-passed alike, thinned, differentiated, and the state of dry friction: segment by segment."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from parsers.jit import kernel
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import FloatArray

STICK_HZ = 8.0
"""Low-pass of a deflection (or an angle) for friction: above it there is more noise than motion."""

SIDE_MEMORY_M, LONG_MEMORY_M = 0.5, 0.3
"""How far tyres roll until they have forgotten how they were bent sideways, and along: their relaxation lengths."""


@kernel
def _stop(travel: FloatArray, limit: float, out: FloatArray) -> None:
    """The stop operator (elastic up to `limit`, then sliding), between -1 and 1: dry friction with a memory.

    Small noise moves it to and fro and does not make it forget. travel, out: (n,).
    """
    state = 0.0
    for i in range(1, travel.size):
        state = min(max(state + travel[i] - travel[i - 1], -limit), limit)
        out[i] = state / limit


@kernel
def _hold(travel: FloatArray, rolled: FloatArray, out: FloatArray) -> None:
    """What of the travel so far tyres still hold that forget it as they roll. rolled: (n,) way of each row over what they forget on."""
    state = 0.0
    for i in range(1, travel.size):
        state = (state + travel[i] - travel[i - 1]) * np.exp(-rolled[i])
        out[i] = state


def moving_mean(values: FloatArray, half: int) -> FloatArray:
    """(n,) mean over `half` rows to either side of each, and itself; over those that are there at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    rows = np.arange(len(values))
    first, last = np.maximum(rows - half, 0), np.minimum(rows + half + 1, len(values))
    return np.asarray((total[last] - total[first]) / (last - first))


class Smoother:
    """Low-passes, differentiates and thins columns segment by segment; missing stretches stay missing.

    mean_s: every column is first averaged over so long, as a sensor does with which it is compared: sums of columns then are
    what that sensor shows of them.
    """

    def __init__(self, prepared: Prepared, band_hz: float, mean_s: float = 0.0) -> None:
        self.prepared = prepared
        self.band_hz = band_hz
        self.half = round(0.5 * mean_s * prepared.rate_hz)
        self.step = max(1, int(prepared.rate_hz / (4 * band_hz)))
        rows = [np.arange(s.start, s.stop, self.step) for s in prepared.segments]
        self.rows = np.concatenate(rows) if rows else np.zeros(0, dtype=np.int64)

    def whole(self, values: FloatArray, rate: int = 0) -> FloatArray:
        """(n,) low-passed, and differentiated `rate` times, at the full number of rows."""
        out = np.full(len(values), np.nan)
        for s in self.prepared.segments:
            part = values[s.start : s.stop]
            there = np.isfinite(part)
            if there.sum() < 4:
                continue
            if not there.all():
                at = np.arange(len(part))
                part = np.interp(at, at[there], part[there])
            if self.half > 0:
                part = moving_mean(part, self.half)
            part = lowpass(part, self.prepared.rate_hz, self.band_hz)
            for _ in range(rate):
                part = np.gradient(part) * self.prepared.rate_hz
            out[s.start : s.stop] = np.where(there, part, np.nan)
        return out

    def __call__(self, values: FloatArray, rate: int = 0) -> FloatArray:
        """As `whole`, thinned."""
        return np.asarray(self.whole(values, rate)[self.rows])


def _by_segment(
    column: FloatArray, prepared: Prepared, fill: Callable[[FloatArray, Segment, FloatArray], None]
) -> FloatArray:
    """(n,) a state with a memory, which starts at 0 in every segment; missing where the column is. fill: column's part, its segment -> state."""
    out = np.full(len(column), np.nan)
    for segment in prepared.segments:
        part = np.ascontiguousarray(column[segment.start : segment.stop])
        if np.isfinite(part).all():
            state = np.zeros(len(part))
            fill(part, segment, state)
            out[segment.start : segment.stop] = state
    return out


def friction_state(calm: FloatArray, prepared: Prepared, limit: float) -> FloatArray:
    """(n,) state of dry friction between -1 and 1, segment by segment; it starts in the middle. limit: travel to turn it."""
    return _by_segment(calm, prepared, lambda part, _, state: _stop(part, limit, state))


def held_by_tyres(travel: FloatArray, prepared: Prepared, speed: FloatArray, memory_m: float) -> FloatArray:
    """(n,) how far `travel` has come since tyres last rolled, segment by segment: they are bent by it, and forget it within memory_m.

    speed: (n,) m/s; where it is missing nothing is held, unless the vehicle is known to stand.
    """
    still = prepared.standstill
    gone = np.abs(np.where(np.isfinite(speed), speed, np.inf)) / (prepared.rate_hz * memory_m)
    rolled = np.ascontiguousarray(np.where(still, 0.0, gone) if len(still) else gone)
    return _by_segment(travel, prepared, lambda part, s, state: _hold(part, rolled[s.start : s.stop], state))
