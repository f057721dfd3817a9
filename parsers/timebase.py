"""One place where stamps are put in order: out-of-order, duplicate and jumping clocks, and gaps.

Importers deliver rows in the log's order; here they become strictly increasing, and what was done is counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.channels import IntArray
from parsers.drive import Gap
from parsers.quantiles import median_step, quantile

NS = 1_000_000_000

JUMP_BACK_NS = NS
"""A stamp this far behind the latest one may be a clock set back; less is a late message."""

JUMP_AHEAD_NS = 12 * 3600 * NS
"""A step ahead of more than this inside one recording is a clock that was set, not a pause."""

PAUSE_NS = NS
"""Where a clock was set, a step ahead of more than this may be its return: the rows on both sides are judged apart."""

BESIDE_NS = 60 * NS
"""A stretch out of the log's order belongs to the same clock if it lies no farther than this from the rest."""

MAX_RUNS = 256
"""A clock that was set this often was not: these stamps are shuffled, and sorting is all that can be done."""

MAX_PAUSES = 256

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
    jumps: stretches that are not used since the clock was set or the stamps are wrong. lost: the rows in them. untouched: the rows were in order.
    """

    rows: NDArray[np.intp]
    time_ns: IntArray
    out_of_order: int
    duplicates: int
    jumps: int
    lost: int
    untouched: bool = False


@dataclass(frozen=True)
class Run:
    """Rows [start, stop) in which the clock was not set, and the stamps that they reach."""

    start: int
    stop: int
    low: int
    high: int


def clock_settings(step: IntArray) -> IntArray:
    """The steps at which the clock was set, as numbers of the rows before them. step: (n - 1,) from row to row."""
    if len(step) == 0 or (int(step.min()) >= -JUMP_BACK_NS and int(step.max()) <= JUMP_AHEAD_NS):
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero((step < -JUMP_BACK_NS) | (step > JUMP_AHEAD_NS))


def pauses(step: IntArray, limit_ns: int) -> IntArray:
    """Steps ahead of more than `limit_ns` that are no setting of the clock, as numbers of the rows before them."""
    if len(step) == 0 or int(step.max()) <= limit_ns:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero((step > limit_ns) & (step <= JUMP_AHEAD_NS))


def pause_limit(ahead: IntArray, limit_ns: int = PAUSE_NS) -> int:
    """`limit_ns`, doubled until no more than MAX_PAUSES steps exceed it: the usual steps of a slow channel are no pauses."""
    while int(np.count_nonzero(ahead > limit_ns)) > MAX_PAUSES:
        limit_ns *= 2
    return limit_ns


def _runs(time_ns: IntArray, step: IntArray) -> list[Run]:
    """Rows between settings of the clock and pauses; one run of all rows where the clock was never set, or too often."""
    settings = clock_settings(step)
    edges = np.zeros(1, dtype=np.int64)
    if 0 < len(settings) < MAX_RUNS:
        ahead = step[pauses(step, PAUSE_NS)]
        edges = np.sort(np.concatenate([edges, settings + 1, pauses(step, pause_limit(ahead)) + 1]))
    low, high = np.minimum.reduceat(time_ns, edges), np.maximum.reduceat(time_ns, edges)
    stops = [*edges[1:].tolist(), len(time_ns)]
    columns = zip(edges.tolist(), stops, low.tolist(), high.tolist(), strict=True)
    return [Run(*each) for each in columns]


def _fits(run: Run, kept: IntArray) -> bool:
    """Whether a run can stay beside those that do. kept: (4, k), a run's four numbers a column.

    It covers no time of theirs, late messages apart, and is by the same clock: within JUMP_AHEAD_NS of them, and where the
    log's order is not that of time (a file's chunks out of order) no farther from them than it is long. A single row that
    was stamped wrongly is not by the same clock, nor is a stretch that was recorded after the clock was set back an hour.
    """
    start, _, low, high = kept
    apart = int(np.maximum(run.low - high, low - run.high).min())
    in_order = np.where(start < run.start, run.low >= high - JUMP_BACK_NS, low >= run.high - JUMP_BACK_NS)
    length = run.high - run.low
    late, near = JUMP_BACK_NS, JUMP_AHEAD_NS
    if not in_order.all():
        late, near = min(length // 4, JUMP_BACK_NS), min(max(length, JUMP_BACK_NS), BESIDE_NS)
    return apart <= near and not ((run.low < high - late) & (run.high > low + late)).any()


def usable_runs(runs: Sequence[Run]) -> list[Run]:
    """The longest run and all that fit beside it, in the log's order."""
    waiting = sorted(runs, key=lambda r: r.start - r.stop)
    kept = np.empty((4, len(runs)), dtype=np.int64)
    count = 0
    found = True
    while found:
        rest: list[Run] = []
        for run in waiting:
            if count and not _fits(run, kept[:, :count]):
                rest.append(run)
            else:
                kept[:, count] = astuple(run)
                count += 1
        # what was too far from the rest may be near to one that came to it
        found = 0 < len(rest) < len(waiting)
        waiting = rest
    left_out = {run.start for run in waiting}
    return [run for run in runs if run.start not in left_out]


def stretches_left_out(runs: Sequence[Run], kept: Sequence[Run]) -> int:
    """How many stretches of the log are not used; runs in a row are one. runs, kept: in the log's order."""
    stay = {run.start for run in kept}
    used = np.array([True, *(run.start in stay for run in runs)])
    return int(np.count_nonzero(used[:-1] & ~used[1:]))


def order(time_ns: IntArray) -> Ordered:
    """Sort stamps. A clock set back or far ahead splits the rows; the longest part and all that fits beside it stay.

    A row or a few that are stamped wrongly among good ones cost these rows alone. time_ns: (n,) int64 in the log's order, each within LATEST_NS of zero.
    """
    n = len(time_ns)
    if n == 0:
        return Ordered(np.zeros(0, dtype=np.intp), time_ns, 0, 0, 0, 0)
    step = np.diff(time_ns)
    if n == 1 or (int(step.min()) > 0 and int(step.max()) <= JUMP_AHEAD_NS):
        return Ordered(np.arange(n), time_ns, 0, 0, 0, 0, untouched=True)
    runs = _runs(time_ns, step)
    kept = usable_runs(runs)
    jumps = stretches_left_out(runs, kept)
    rows = np.concatenate([np.arange(run.start, run.stop) for run in kept])
    lost = n - len(rows)
    late = int((np.diff(time_ns[rows]) < 0).sum())
    rows = rows[np.argsort(time_ns[rows], kind="stable")]
    stamps = time_ns[rows]
    last = np.append(stamps[1:] != stamps[:-1], True)
    return Ordered(rows[last], stamps[last], late, int((~last).sum()), jumps, lost)


def usual_period_s(time_ns: IntArray) -> float:
    """The median step in seconds; 0 for fewer than two stamps."""
    return median_step(time_ns) / NS if len(time_ns) > 1 else 0.0


def gap_limit_ns(usual_step_ns: float) -> float:
    """A longer step than this is a gap."""
    return max(GAP_PERIODS * usual_step_ns, MIN_GAP_S * NS)


def _spans(time_ns: IntArray) -> tuple[IntArray, IntArray]:
    """Starts and ends of steps much longer than usual, (m,) each. time_ns: (n,) increasing."""
    if len(time_ns) < 3:
        return time_ns[:0], time_ns[:0]
    step = np.diff(time_ns)
    # where no step is long enough for a gap at any rate there is no need to know the usual one
    if int(step.max()) <= MIN_GAP_S * NS:
        return time_ns[:0], time_ns[:0]
    at = np.flatnonzero(step > gap_limit_ns(quantile(step, 0.5)))
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
    # signals of one table share their stamps: looked at once
    stamps = {id(time_ns): time_ns for time_ns in times.values()}
    shared = {key: _spans(time_ns) for key, time_ns in stamps.items()}
    return gaps_of_spans({name: shared[id(time_ns)] for name, time_ns in times.items()}, start_ns, most)


def gaps_of_spans(
    spans_of: Mapping[str, tuple[IntArray, IntArray]], start_ns: int, most: int = MAX_GAPS
) -> GapList:
    """`list_gaps`, from starts and ends of each signal's own gaps, (m,) each, in order."""
    if not spans_of:
        return GapList((), 0)
    names, spans = list(spans_of), list(spans_of.values())
    whole = _common(list({id(each[0]): each for each in spans}.values()))
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
