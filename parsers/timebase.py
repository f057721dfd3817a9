"""One place where stamps are put in order: out-of-order, duplicate and jumping clocks, and gaps.

Importers deliver rows in the log's order; here they become strictly increasing, and what was done is counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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

LATEST_NS = 2**62 - 1
"""No clock of a vehicle shows more (the year 2116); the difference of two such stamps always fits an int64."""

MAX_GAPS = 1000
"""A record lists no more gaps than this."""

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


@dataclass(frozen=True)
class _Run:
    """Rows [start, stop) between two settings of the clock, and the stamps that they reach."""

    start: int
    stop: int
    low: int
    high: int


def _runs(time_ns: IntArray) -> list[_Run]:
    """Rows between settings of the clock; one run of all rows where there are more than MAX_RUNS."""
    step = np.diff(time_ns)
    latest = np.maximum.accumulate(time_ns)[:-1]
    # after a step back every later row is behind the old maximum: only the row where the step happens counts
    back = (time_ns[1:] < latest - JUMP_BACK_NS) & (step < -JUMP_BACK_NS)
    edges = np.concatenate([[0], np.flatnonzero(back | (step > JUMP_AHEAD_NS)) + 1])
    if len(edges) > MAX_RUNS:
        # nobody sets a clock that often: these stamps are shuffled, and sorting is all that can be done
        edges = edges[:1]
    low, high = np.minimum.reduceat(time_ns, edges), np.maximum.reduceat(time_ns, edges)
    stops = [*edges[1:].tolist(), len(time_ns)]
    columns = zip(edges.tolist(), stops, low.tolist(), high.tolist(), strict=True)
    return [_Run(*each) for each in columns]


def _overlap(kept: list[_Run], run: _Run) -> bool:
    """Whether a run covers time that is covered already, by more than a late message would."""
    return any(min(run.high, other.high) - max(run.low, other.low) > JUMP_BACK_NS for other in kept)


def _far(kept: list[_Run], run: _Run) -> bool:
    """Whether a run lies more than JUMP_AHEAD away from all that is kept: another clock."""
    return all(run.low - other.high > JUMP_AHEAD_NS or other.low - run.high > JUMP_AHEAD_NS for other in kept)


def order(time_ns: IntArray) -> Ordered:
    """Sort stamps. A clock set back or far ahead splits the rows; the longest part and all that fits beside it stay.

    time_ns: (n,) int64 in the log's order, each within LATEST_NS of zero.
    """
    n = len(time_ns)
    if n == 0:
        return Ordered(np.zeros(0, dtype=np.intp), time_ns, 0, 0, 0, 0)
    step = np.diff(time_ns)
    if bool((step > 0).all()) and bool((step <= JUMP_AHEAD_NS).all()):
        return Ordered(np.arange(n), time_ns, 0, 0, 0, 0)
    kept: list[_Run] = []
    jumps = 0
    for run in sorted(_runs(time_ns), key=lambda r: r.start - r.stop):
        if kept and (_overlap(kept, run) or _far(kept, run)):
            jumps += 1
        else:
            kept.append(run)
    rows = np.concatenate([np.arange(run.start, run.stop) for run in sorted(kept, key=lambda r: r.start)])
    lost = n - len(rows)
    late = int((np.diff(time_ns[rows]) < 0).sum())
    rows = rows[np.argsort(time_ns[rows], kind="stable")]
    stamps = time_ns[rows]
    last = np.append(stamps[1:] != stamps[:-1], True)
    return Ordered(rows[last], stamps[last], late, int((~last).sum()), jumps, lost)


def usual_period_s(time_ns: IntArray) -> float:
    """The median step in seconds; 0 for fewer than two stamps."""
    return float(np.median(np.diff(time_ns))) / NS if len(time_ns) > 1 else 0.0


def _spans(time_ns: IntArray) -> tuple[IntArray, IntArray]:
    """Starts and ends of steps much longer than usual, (m,) each. time_ns: (n,) increasing."""
    if len(time_ns) < 3:
        return time_ns[:0], time_ns[:0]
    step = np.diff(time_ns)
    limit = max(GAP_PERIODS * float(np.median(step)), MIN_GAP_S * NS)
    at = np.flatnonzero(step > limit)
    return time_ns[at], time_ns[at + 1]


def find_gaps(time_ns: IntArray, start_ns: int, signal: str | None = None) -> tuple[Gap, ...]:
    """Steps much longer than usual, in seconds from `start_ns`. time_ns: (n,) increasing."""
    starts, ends = _spans(time_ns)
    return tuple(_gap(a, b, start_ns, signal) for a, b in zip(starts.tolist(), ends.tolist(), strict=True))


def _gap(start: int, end: int, origin_ns: int, signal: str | None) -> Gap:
    return Gap((start - origin_ns) / NS, (end - origin_ns) / NS, signal)


def _common(spans: Sequence[tuple[IntArray, IntArray]]) -> tuple[IntArray, IntArray]:
    """What lies in a span of every list, at least MIN_GAP_S long. Spans of one list do not overlap."""
    edges = np.concatenate([*(a for a, _ in spans), *(b for _, b in spans)])
    step = np.repeat([1, -1], len(edges) // 2)
    # where one span ends and the next begins at once there is a sample: the end comes first
    rows = np.lexsort((step, edges))
    edges = edges[rows]
    inside = np.flatnonzero(np.cumsum(step[rows])[:-1] == len(spans))
    starts, ends = edges[inside], edges[inside + 1]
    long = ends - starts >= MIN_GAP_S * NS
    return starts[long], ends[long]


@dataclass(frozen=True)
class GapList:
    """Gaps, the drive's first, each sort in order of time. total: how many there are; `gaps` holds the longest."""

    gaps: tuple[Gap, ...]
    total: int


def list_gaps(times: Mapping[str, IntArray], start_ns: int, most: int = MAX_GAPS) -> GapList:
    """Gaps of the whole drive (no signal has a sample) and of single signals: `most` at the most.

    times: signal -> (n,) increasing. Gaps of the whole drive stay before those of a signal, long ones before short ones.
    """
    if not times:
        return GapList((), 0)
    names = list(times)
    # signals of one table share their stamps: looked at once
    stamps = {id(time_ns): time_ns for time_ns in times.values()}
    shared = {key: _spans(time_ns) for key, time_ns in stamps.items()}
    spans = [shared[id(time_ns)] for time_ns in times.values()]
    whole = _common(list(shared.values()))
    starts, ends = [whole[0]], [whole[1]]
    owner = [np.full(len(whole[0]), -1)]
    for number, (a, b) in enumerate(spans):
        own = ~_covered(a, b, whole)
        starts.append(a[own])
        ends.append(b[own])
        owner.append(np.full(int(own.sum()), number))
    start, end, of = np.concatenate(starts), np.concatenate(ends), np.concatenate(owner)
    total = len(start)
    if total > most:
        kept = np.sort(np.lexsort((start - end, of >= 0))[:most])
        start, end, of = start[kept], end[kept], of[kept]
    rows = zip(start.tolist(), end.tolist(), of.tolist(), strict=True)
    return GapList(tuple(_gap(a, b, start_ns, names[n] if n >= 0 else None) for a, b, n in rows), total)


def _covered(starts: IntArray, ends: IntArray, whole: tuple[IntArray, IntArray]) -> NDArray[np.bool_]:
    """Which spans are a gap of the whole drive, give or take a second. whole: in order, not overlapping."""
    if len(whole[0]) == 0:
        return np.zeros(len(starts), dtype=np.bool_)
    # of the gaps that begin early enough the last one also ends last
    place = np.searchsorted(whole[0], starts + NS, side="right") - 1
    return np.asarray((place >= 0) & (whole[1][np.maximum(place, 0)] >= ends - NS))


def drive_gaps(times: Mapping[str, IntArray], start_ns: int) -> tuple[Gap, ...]:
    """The gaps of `list_gaps`."""
    return list_gaps(times, start_ns).gaps
