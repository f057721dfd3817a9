"""Rows that are too many to keep, on disk: sorted blocks in one nameless file, cut into windows of time when read.

Nothing of it is left behind, whatever happens: the file has no name from the start.
"""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.timebase import (
    MAX_RUNS,
    PAUSE_NS,
    Run,
    clock_settings,
    pause_limit,
    pauses,
    stretches_left_out,
    usable_runs,
)

BLOCK_ROWS = 1 << 16
_ITEM = 8


class Spool:
    """One file that numbers are put into and read from. Raises OSError where the disk is full or fails."""

    def __init__(self, folder: Path) -> None:
        """Make the file in `folder`, which must exist."""
        self._file = tempfile.TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115 - closed by `close`
        self._end = 0

    def put(self, values: FloatArray | IntArray) -> int:
        """Write (n,) numbers of 8 bytes; the place where they lie."""
        place = self._end
        self._file.seek(place)
        rest = np.ascontiguousarray(values).data.cast("B")
        while rest:
            written = self._file.write(rest)
            rest = rest[written:]
            self._end += written
        return place

    def get(self, into: FloatArray | IntArray, place: int) -> None:
        """Fill an array with what lies at a place."""
        self._file.seek(place)
        rest = into.data.cast("B")
        while rest:
            count = self._file.readinto(rest)
            if not count:
                raise OSError("the temporary file is shorter than what was written")
            rest = rest[count:]

    def close(self) -> None:
        """Give the disk's space back."""
        self._file.close()


@dataclass
class _RunState:
    """What is known of the rows between two settings of the clock or pauses. late: rows behind the one before them.

    pause_ns: the step ahead before it; 0 where the clock was set, and for the first one.
    """

    start: int
    first: int
    last: int
    low: int
    high: int
    late: int = 0
    pause_ns: int = 0


class GroupWriter:
    """Takes the rows of one group in the log's order. columns: their names; a chunk that lacks one has no values there."""

    def __init__(self, spool: Spool, columns: Sequence[str]) -> None:
        self._spool, self._columns = spool, tuple(columns)
        self._pending: list[tuple[IntArray, Mapping[str, FloatArray]]] = []
        self.pending_bytes = 0
        self._rows = 0
        self._runs: list[_RunState] = []
        self._settings = 0
        self._pause_ns = PAUSE_NS
        # a block: its first and last stamp, rows, place in the file and run
        self._index = tuple(array("q") for _ in range(5))

    def add(self, time_ns: IntArray, columns: Mapping[str, FloatArray]) -> None:
        """Take a chunk, (n,) each."""
        if len(time_ns) == 0:
            return
        stamps = time_ns
        if self._runs:
            stamps = np.concatenate([[self._runs[-1].last], time_ns])
        before = len(stamps) - len(time_ns)
        step = np.diff(stamps)
        settings = clock_settings(step) + 1 - before
        ahead = pauses(step, self._pause_ns)
        self._settings += len(settings)
        if self._settings >= MAX_RUNS:
            # these stamps are shuffled: all rows are one run in the end, and need not be kept apart any more
            settings = ahead = settings[:0]
        elif len(ahead):
            held = np.array([run.pause_ns for run in self._runs], dtype=np.int64)
            self._pause_ns = pause_limit(np.concatenate([held, step[ahead]]), self._pause_ns)
            ahead = pauses(step, self._pause_ns)
        after = {int(row) + 1 - before: int(step[row]) for row in ahead}
        begins = {int(row) for row in settings} | set(after) | (set() if self._runs else {0})
        edges = sorted(begins | {0, len(time_ns)})
        for start, stop in pairwise(edges):
            if start in begins:
                self._begin_run(int(time_ns[start]), after.get(start, 0))
            self._count(time_ns[start:stop])
            part = {name: values[start:stop] for name, values in columns.items()}
            self._pending.append((time_ns[start:stop], part))
        self.pending_bytes += time_ns.nbytes * (1 + len(self._columns))

    def _begin_run(self, stamp: int, pause_ns: int) -> None:
        self.flush()
        self._runs.append(_RunState(self._rows, stamp, stamp, stamp, stamp, pause_ns=pause_ns))

    def _count(self, time_ns: IntArray) -> None:
        run = self._runs[-1]
        run.late += int(time_ns[0] < run.last) + int(np.count_nonzero(time_ns[1:] < time_ns[:-1]))
        run.last = int(time_ns[-1])
        run.low, run.high = min(run.low, int(time_ns.min())), max(run.high, int(time_ns.max()))
        self._rows += len(time_ns)

    def flush(self) -> None:
        """Bring all that is pending to the disk, in sorted blocks."""
        if not self._pending:
            return
        time_ns = np.concatenate([stamps for stamps, _ in self._pending])
        rows = _in_order(time_ns)
        time_ns = time_ns[rows]
        columns = [self._column(name)[rows] for name in self._columns]
        self._pending, self.pending_bytes = [], 0
        for start in range(0, len(time_ns), BLOCK_ROWS):
            part = slice(start, start + BLOCK_ROWS)
            stamps = time_ns[part]
            place = self._spool.put(stamps)
            for values in columns:
                self._spool.put(values[part])
            entry = (int(stamps[0]), int(stamps[-1]), len(stamps), place, len(self._runs) - 1)
            for held, value in zip(self._index, entry, strict=True):
                held.append(value)

    def _column(self, name: str) -> FloatArray:
        parts = [part.get(name) for _, part in self._pending]
        sizes = [len(stamps) for stamps, _ in self._pending]
        each = zip(parts, sizes, strict=True)
        return np.concatenate([np.full(n, np.nan) if part is None else part for part, n in each])

    def finish(self) -> GroupRows:
        """What was taken, ready to be read. Nothing can be added after it."""
        self.flush()
        low, high, rows, place, of = (np.array(held, dtype=np.int64) for held in self._index)
        usable, late, jumps = self._judged()
        kept = np.flatnonzero(usable)
        starts = np.array([*(state.start for state in self._runs), self._rows])
        total = int((starts[kept + 1] - starts[kept]).sum())
        chosen = usable[of] if len(of) else np.zeros(0, dtype=np.bool_)
        index = BlockIndex(low[chosen], high[chosen], rows[chosen], place[chosen])
        return GroupRows(self._spool, self._columns, index, total, late, jumps, self._rows - total)

    def _judged(self) -> tuple[NDArray[np.bool_], int, int]:
        """Which of the runs stay, (runs,), how many of their rows are late, and how many stretches do not stay."""
        states = self._runs
        shuffled = self._settings >= MAX_RUNS
        # a step that is usual by now was no pause: its run goes on with the one before
        whole = np.array(
            [n > 0 and 0 < s.pause_ns <= self._pause_ns for n, s in enumerate(states)], dtype=bool
        )
        if shuffled or not self._settings:
            whole[1:] = True
        first = np.flatnonzero(~whole)
        parts = [states[a:b] for a, b in pairwise([*first.tolist(), len(states)])]
        stops = [*(states[n].start for n in first[1:]), self._rows]
        runs = [
            Run(part[0].start, stop, min(state.low for state in part), max(state.high for state in part))
            for part, stop in zip(parts, stops, strict=True)
        ]
        kept = usable_runs(runs)
        starts = {run.start for run in kept}
        usable = np.repeat([run.start in starts for run in runs], [len(part) for part in parts])
        stay = [state for state, used in zip(states, usable, strict=True) if used]
        late = sum(state.late for state in stay) + sum(b.first < a.last for a, b in pairwise(stay))
        return usable, late, stretches_left_out(runs, kept)


def _in_order(time_ns: IntArray) -> slice | IntArray:
    """The rows in order of time, of equal stamps only the last one."""
    if len(time_ns) < 2 or int(np.diff(time_ns).min()) > 0:
        return slice(None)
    rows: IntArray = np.argsort(time_ns, kind="stable")
    stamps = time_ns[rows]
    kept: IntArray = rows[np.append(stamps[1:] != stamps[:-1], True)]
    return kept


@dataclass(frozen=True)
class BlockIndex:
    """The blocks of a group in the log's order: first and last stamp, rows, place in the file; (blocks,) each."""

    low: IntArray
    high: IntArray
    rows: IntArray
    place: IntArray


@dataclass(frozen=True, eq=False)
class GroupRows:
    """The rows of one group on disk: any window of time can be loaded, in order and without duplicates.

    columns: their names. rows: how many were usable, those that share a stamp included. late, jumps, lost: as `Ordered`
    of parsers.timebase has them. shift_ns: what is added to the stamps that are stored; the index has it in it.
    """

    spool: Spool
    columns: tuple[str, ...]
    index: BlockIndex
    rows: int
    late: int
    jumps: int
    lost: int
    shift_ns: int = 0

    def shifted(self, by_ns: int) -> GroupRows:
        """The same rows with later stamps."""
        index = replace(self.index, low=self.index.low + by_ns, high=self.index.high + by_ns)
        return replace(self, index=index, shift_ns=self.shift_ns + by_ns)

    def load(self, start: int, stop: int, names: Sequence[str]) -> tuple[IntArray, dict[str, FloatArray]]:
        """The rows in [start, stop): strictly increasing stamps (n,), and the columns (n,) of these names."""
        whole, partly = self._touched(start, stop)
        cuts = [(int(block), 0, int(self.index.rows[block])) for block in np.flatnonzero(whole)]
        # in the log's order, so that of rows with one stamp the last one stays
        cuts = sorted([*cuts, *partly])
        total = sum(b - a for _, a, b in cuts)
        time_ns = np.empty(total, dtype=np.int64)
        self._fill(time_ns, cuts, 0)
        time_ns += self.shift_ns
        rows = _in_order(time_ns)
        columns: dict[str, FloatArray] = {}
        for name in names:
            values = np.empty(total)
            self._fill(values, cuts, 1 + self.columns.index(name))
            columns[name] = values[rows]
        return time_ns[rows], columns

    def _fill(self, into: FloatArray | IntArray, cuts: Sequence[tuple[int, int, int]], number: int) -> None:
        """number: which of a block's arrays, 0 for the stamps."""
        at = 0
        for block, a, b in cuts:
            place = int(self.index.place[block]) + _ITEM * (number * int(self.index.rows[block]) + a)
            self.spool.get(into[at : at + b - a], place)
            at += b - a

    def _touched(self, start: int, stop: int) -> tuple[NDArray[np.bool_], list[tuple[int, int, int]]]:
        """Which blocks lie in [start, stop) whole (a mask), and the parts (block, from row, to row) of the others."""
        low, high = self.index.low, self.index.high
        touched = (low < stop) & (high >= start)
        whole = touched & (low >= start) & (high < stop)
        cuts = [
            (int(block), self._cut(int(block), start), self._cut(int(block), stop))
            for block in np.flatnonzero(touched & ~whole)
        ]
        return whole, [cut for cut in cuts if cut[1] < cut[2]]

    def _cut(self, block: int, stamp: int) -> int:
        """How many rows of a block are before a stamp."""
        rows = int(self.index.rows[block])
        if stamp <= int(self.index.low[block]):
            return 0
        if stamp > int(self.index.high[block]):
            return rows
        place = int(self.index.place[block])
        first, last = 0, rows
        one = np.empty(1, dtype=np.int64)
        while first < last:
            middle = (first + last) // 2
            self.spool.get(one, place + _ITEM * middle)
            if int(one[0]) + self.shift_ns < stamp:
                first = middle + 1
            else:
                last = middle
        return first
