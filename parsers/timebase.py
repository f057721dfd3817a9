"""One place where stamps are put in order: out-of-order, duplicate and jumping clocks, and gaps.

Importers deliver rows in the log's order; here they become strictly increasing, and what was done is counted.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.channels import IntArray
from parsers.drive import Gap

NS = 1_000_000_000

JUMP_BACK_NS = NS
"""A stamp this far behind the latest one may be a clock set back; less is a late message."""

JUMP_AHEAD_NS = 12 * 3600 * NS
"""A step ahead of more than this inside one recording is a clock that was set, not a pause."""

MAX_RUNS = 256

GAP_PERIODS = 5.0
MIN_GAP_S = 0.25
"""A gap is a step of more than GAP_PERIODS usual periods and of at least MIN_GAP_S."""


@dataclass(frozen=True)
class Ordered:
    """Rows in order. rows: (n,) indices into the given rows. time_ns: (n,) strictly increasing.

    out_of_order, duplicates: how many rows were late, or shared a stamp with another (the last one stays).
    jumps: how often the clock was set. lost: rows that a set clock made unusable.
    """

    rows: NDArray[np.intp]
    time_ns: IntArray
    out_of_order: int
    duplicates: int
    jumps: int
    lost: int


def _runs(time_ns: IntArray) -> list[tuple[int, int]]:
    """Rows between settings of the clock, as (start, stop)."""
    latest = np.maximum.accumulate(time_ns)
    back = np.flatnonzero(time_ns[1:] < latest[:-1] - JUMP_BACK_NS) + 1
    ahead = np.flatnonzero(np.diff(time_ns) > JUMP_AHEAD_NS) + 1
    # after a step back every later row is behind the old maximum: only the row where the step happens counts
    first = [int(i) for i in back if time_ns[i] < time_ns[i - 1] - JUMP_BACK_NS]
    edges = sorted({0, len(time_ns), *first, *(int(i) for i in ahead)})
    return list(itertools.pairwise(edges))


def _overlap(time_ns: IntArray, kept: list[tuple[int, int]], run: tuple[int, int]) -> bool:
    """Whether a run covers time that is covered already, by more than a late message would."""
    low, high = int(time_ns[run[0] : run[1]].min()), int(time_ns[run[0] : run[1]].max())
    for start, stop in kept:
        other = time_ns[start:stop]
        if min(high, int(other.max())) - max(low, int(other.min())) > JUMP_BACK_NS:
            return True
    return False


def _far(time_ns: IntArray, kept: list[tuple[int, int]], run: tuple[int, int]) -> bool:
    """Whether a run lies more than JUMP_AHEAD away from all that is kept: another clock."""
    low, high = int(time_ns[run[0] : run[1]].min()), int(time_ns[run[0] : run[1]].max())
    return all(
        low - int(time_ns[start:stop].max()) > JUMP_AHEAD_NS
        or int(time_ns[start:stop].min()) - high > JUMP_AHEAD_NS
        for start, stop in kept
    )


def order(time_ns: IntArray) -> Ordered:
    """Sort stamps. A clock set back or far ahead splits the rows; the longest part and all that fits beside it stay.

    time_ns: (n,) int64 in the log's order.
    """
    n = len(time_ns)
    if n == 0:
        return Ordered(np.zeros(0, dtype=np.intp), time_ns, 0, 0, 0, 0)
    step = np.diff(time_ns)
    if bool((step > 0).all()) and bool((step <= JUMP_AHEAD_NS).all()):
        return Ordered(np.arange(n), time_ns, 0, 0, 0, 0)
    runs = _runs(time_ns)
    if len(runs) > MAX_RUNS:
        # nobody sets a clock that often: these stamps are shuffled, and sorting is all that can be done
        runs = [(0, n)]
    kept: list[tuple[int, int]] = []
    jumps = 0
    for run in sorted(runs, key=lambda r: r[0] - r[1]):
        if kept and (_overlap(time_ns, kept, run) or _far(time_ns, kept, run)):
            jumps += 1
        else:
            kept.append(run)
    rows = np.concatenate([np.arange(start, stop) for start, stop in sorted(kept)])
    lost = n - len(rows)
    late = int((np.diff(time_ns[rows]) < 0).sum())
    rows = rows[np.argsort(time_ns[rows], kind="stable")]
    stamps = time_ns[rows]
    last = np.append(stamps[1:] != stamps[:-1], True)
    return Ordered(rows[last], stamps[last], late, int((~last).sum()), jumps, lost)


def usual_period_s(time_ns: IntArray) -> float:
    """The median step in seconds; 0 for fewer than two stamps."""
    return float(np.median(np.diff(time_ns))) / NS if len(time_ns) > 1 else 0.0


def find_gaps(time_ns: IntArray, start_ns: int, signal: str | None = None) -> tuple[Gap, ...]:
    """Steps much longer than usual, in seconds from `start_ns`. time_ns: (n,) increasing."""
    if len(time_ns) < 3:
        return ()
    limit = max(GAP_PERIODS * usual_period_s(time_ns), MIN_GAP_S)
    step = np.diff(time_ns) / NS
    return tuple(
        Gap(float(time_ns[i] - start_ns) / NS, float(time_ns[i + 1] - start_ns) / NS, signal)
        for i in np.flatnonzero(step > limit)
    )


def drive_gaps(times: Mapping[str, IntArray], start_ns: int) -> tuple[Gap, ...]:
    """Gaps of the whole drive (no signal has a sample) and of single signals, the drive's first."""
    own = {name: find_gaps(time_ns, start_ns, name) for name, time_ns in times.items()}
    if not own:
        return ()
    # a gap of the drive is a gap of every signal: intersect their spans
    spans = [[(gap.start_s, gap.end_s) for gap in gaps] for gaps in own.values()]
    common = spans[0]
    for other in spans[1:]:
        common = [(max(a, c), min(b, d)) for a, b in common for c, d in other if min(b, d) - max(a, c) > 0]
    common = [(a, b) for a, b in common if b - a >= MIN_GAP_S]
    whole = tuple(Gap(a, b) for a, b in common)
    single = tuple(
        gap
        for gaps in own.values()
        for gap in gaps
        if not any(a - 1.0 <= gap.start_s and gap.end_s <= b + 1.0 for a, b in common)
    )
    return whole + single
