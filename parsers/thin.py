"""Thinning a trace for drawing without losing its peaks or its gaps."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.timebase import GAP_PERIODS, MIN_GAP_S


def thin_minmax(time_s: FloatArray, values: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    """About `points` points: the least and the greatest of each bucket of rows, in order; NaN at gaps.

    Each gap (the `points` longest of them) adds up to three points, so that there are at most 4 * points + 4.
    time_s (n,) increasing, values (n,) finite -> (m,), (m,) with one NaN row inside each gap.
    """
    n = len(values)
    if n > points:
        bucket = -(-2 * n // points)
        whole = n // bucket * bucket
        blocks = values[:whole].reshape(-1, bucket)
        start = np.arange(0, whole, bucket)
        ends = [0, n - 1]
        if whole < n:
            ends += [whole + int(values[whole:].argmin()), whole + int(values[whole:].argmax())]
        rows = np.unique(np.concatenate([start + blocks.argmin(axis=1), start + blocks.argmax(axis=1), ends]))
    else:
        rows = np.arange(n)
    if n > 2:
        step = np.diff(time_s)
        gaps = np.flatnonzero(step > max(GAP_PERIODS * float(np.median(step)), MIN_GAP_S))
        if len(gaps) > points:
            # the longest show; the rest are drawn over, so that the trace still reaches its end
            gaps = np.sort(gaps[np.argsort(-step[gaps], kind="stable")[:points]])
        # the samples beside a gap stay, so that it is drawn where it is
        rows = np.unique(np.concatenate([rows, gaps, gaps + 1]))
        at = np.searchsorted(rows, gaps + 1)
        middle = (time_s[gaps] + time_s[gaps + 1]) / 2
        return np.insert(time_s[rows], at, middle), np.insert(values[rows], at, np.nan)
    return time_s[rows], values[rows]
