"""Spans without gaps: where a signal is there, and where several are there together."""

from __future__ import annotations

import itertools

import numpy as np

from parsers.channels import IntArray

GAP_IN_PERIODS = 4.5
"""A distance of more than this many usual periods is a gap, unless the caller names a longer one in seconds."""

Spans = list[tuple[int, int]]


def usual_period_s(time_ns: IntArray) -> float:
    """The median distance between samples in seconds; 0 where there are fewer than two."""
    if len(time_ns) < 2:
        return 0.0
    return float(np.median(np.diff(time_ns))) / 1e9


def gap_free_rows(time_ns: IntArray, max_gap_s: float | None = None) -> Spans:
    """(first, past the last) rows of the stretches in which neighbours are near enough to interpolate between.

    max_gap_s None: 4.5 usual periods. A named gap never falls below 2.5 usual periods, so that a slow signal
    (satellite speed at 10 Hz) is not cut to pieces by a limit meant for a fast one.
    """
    if len(time_ns) < 2:
        return []
    period = usual_period_s(time_ns)
    longest = GAP_IN_PERIODS * period if max_gap_s is None else max(max_gap_s, 2.5 * period)
    breaks = np.flatnonzero(np.diff(time_ns) > longest * 1e9) + 1
    edges = [0, *(int(b) for b in breaks), len(time_ns)]
    return [(i, j) for i, j in itertools.pairwise(edges) if j - i >= 2]


def runs(mask: np.ndarray) -> Spans:
    """(first, past the last) of each run of True."""
    padded = np.concatenate(([False], np.asarray(mask, dtype=bool), [False]))
    change = np.flatnonzero(padded[1:] != padded[:-1])
    return [(int(i), int(j)) for i, j in zip(change[::2], change[1::2], strict=True)]
