"""Thin a long trace for a plot without losing a peak: the lowest and highest sample of every pixel's span stay."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]
LEAST_JUMP_S, JUMP = 1.0, 12.0
"""A step of a trace that is longer than both, in s and times its usual step, is drawn as a gap."""


def _first_in_each(bucket: IndexArray, chosen: NDArray[np.bool_]) -> IndexArray:
    """Index of the first chosen sample of each bucket that has one. bucket: non-decreasing, (n,)."""
    index = np.flatnonzero(chosen)
    if index.size == 0:
        return index
    own = bucket[index]
    first = np.empty(index.size, dtype=np.bool_)
    first[0] = True
    np.not_equal(own[1:], own[:-1], out=first[1:])
    return index[first]


def keep(time: FloatArray, values: FloatArray, buckets: int) -> IndexArray:
    """Indices of the samples to draw: (k,), increasing, k <= 3 * buckets + 2.

    time: (n,) increasing. values: (n,); NaN = gap. Of every bucket (a span of equal time) stay the first lowest,
    the first highest and the first missing sample; the ends stay too. A trace that is short enough stays whole, so
    that thinning twice is thinning once.
    """
    size = values.size
    if size <= 3 * buckets + 2:
        return np.arange(size, dtype=np.int64)
    start, stop = float(time[0]), float(time[-1])
    scale = buckets / (stop - start) if stop > start else 0.0
    bucket = np.clip((time - start) * scale, 0, buckets - 1).astype(np.int64)
    edges = np.flatnonzero(np.concatenate(([True], bucket[1:] != bucket[:-1])))
    lengths = np.diff(np.append(edges, size))
    missing = np.isnan(values)
    lowest = np.repeat(np.minimum.reduceat(np.where(missing, np.inf, values), edges), lengths)
    highest = np.repeat(np.maximum.reduceat(np.where(missing, -np.inf, values), edges), lengths)
    parts = [
        np.array([0, size - 1], dtype=np.int64),
        _first_in_each(bucket, values == lowest),
        _first_in_each(bucket, values == highest),
        _first_in_each(bucket, missing),
    ]
    return np.unique(np.concatenate(parts))


def keep_rows(time: FloatArray, columns: Mapping[str, FloatArray], budget: int) -> IndexArray:
    """Indices of the rows to keep so that no column loses a peak: at most about `budget` rows, idempotent."""
    if not columns:
        return np.arange(time.size, dtype=np.int64)
    buckets = max(100, budget // (3 * len(columns)))
    if time.size <= (3 * buckets + 2) * len(columns):
        return np.arange(time.size, dtype=np.int64)
    return np.unique(np.concatenate([keep(time, values, buckets) for values in columns.values()]))


def break_at(time: FloatArray, values: FloatArray, gaps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Put a missing sample inside every gap, so that no line crosses it. gaps: (g, 2) seconds, start and end."""
    if gaps.size == 0 or time.size < 2:
        return time, values
    middle = gaps.mean(axis=1)
    inside = (middle > time[0]) & (middle < time[-1])
    place = np.searchsorted(time, middle[inside])
    return np.insert(time, place, middle[inside]), np.insert(values, place, np.nan)


def jumps(time: FloatArray) -> FloatArray:
    """(g, 2) spans in which a trace has no samples at all, by its own times (n,): steps far longer than its others."""
    if time.size < 3:
        return np.empty((0, 2))
    steps = np.diff(time)
    at = np.flatnonzero(steps > max(LEAST_JUMP_S, JUMP * float(np.median(steps))))
    return np.column_stack([time[at], time[at + 1]])


def lonely(values: FloatArray) -> NDArray[np.bool_]:
    """Samples with a missing one (or the end) on both sides: a line would not show them. (n,)."""
    there = np.isfinite(values)
    before = np.concatenate(([False], there[:-1]))
    after = np.concatenate((there[1:], [False]))
    return there & ~before & ~after


def merge_spans(spans: FloatArray, apart: float) -> FloatArray:
    """Join spans that lie closer than `apart`: (g, 2) -> (k, 2), sorted. Seconds."""
    if spans.size == 0:
        return spans.reshape(0, 2)
    ordered = spans[np.argsort(spans[:, 0], kind="stable")]
    reach = np.maximum.accumulate(ordered[:, 1])
    new = np.concatenate(([True], ordered[1:, 0] > reach[:-1] + apart))
    first = np.flatnonzero(new)
    last = np.append(first[1:], ordered.shape[0]) - 1
    return np.column_stack((ordered[first, 0], reach[last]))


def spread_points(x: FloatArray, y: FloatArray, limit: int) -> IndexArray:
    """Indices of at most `limit` points of a cloud: evenly through the record, with the extremes of x and y."""
    if x.size <= limit:
        return np.arange(x.size, dtype=np.int64)
    even = np.linspace(0, x.size - 1, limit - 4).astype(np.int64)
    ends = [int(f(a)) for a in (x, y) for f in (np.nanargmin, np.nanargmax) if np.isfinite(a).any()]
    return np.unique(np.concatenate((even, np.array(ends, dtype=np.int64))))


def cells(x: FloatArray, y: FloatArray, across: int, up: int) -> tuple[IndexArray, IndexArray]:
    """One point of each occupied cell of a grid, and how many points the cell holds: (k,), (k,)."""
    good = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if good.size == 0:
        return good, good
    place = np.zeros(good.size, dtype=np.int64)
    for values, number in ((x[good], across), (y[good], up)):
        low, high = float(values.min()), float(values.max())
        scale = (number - 1) / (high - low) if high > low else 0.0
        place = place * number + ((values - low) * scale).astype(np.int64)
    _, first, counts = np.unique(place, return_index=True, return_counts=True)
    return good[first], counts
