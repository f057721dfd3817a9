"""The time of a table's rows: how the kernel is to read it, what only their order can tell, and what they lacked."""

from __future__ import annotations

import numpy as np

from parsers import table_lines as lines
from parsers.channels import IntArray
from parsers.importer import ImportLog
from parsers.table_calendar import WHOLE_MS
from parsers.table_rows import RowBlock, RowCounts
from parsers.table_stamps import unwrap_days
from parsers.table_time_plan import TimePlan
from parsers.table_wraps import Counter, StandingDate

LOST_NS = 250_000_000
"""Left out lines between stamps further apart than this have taken a span of time with them; damaged blocks always have."""
_MOST_SPANS = 1000
NO_TIME = "row without a valid time"
"""Why a row is left out whose time cannot be read."""


_NO_ROWS = ("row with too few columns", "row with too many columns", NO_TIME)
_MOST_SHARE, _MOST_ROWS = 0.05, 10
"""A log is malformed from this share of rows that cannot be read on, where they are more than a few."""


def clock_rule(plan: TimePlan) -> lines.Clock:
    """A plan in the kernel's order."""
    if plan.kind == "calendar":
        kind = lines.MOMENT if plan.absolute else lines.TIME_OF_DAY
        return kind, plan.order + (WHOLE_MS if plan.whole_ms else 0), len(plan.columns), 0, 0
    if plan.kind == "hhmmss":
        return lines.HHMMSS, 0, 1, plan.unit_ns, 0
    if plan.kind == "elapsed":
        return lines.ELAPSED, 0, 1, 0, 0
    if plan.kind == "decimal":
        kind = lines.OTHER_DECIMALS if plan.other_point else lines.DECIMALS
        return kind, plan.zero, 1, plan.unit_ns, 0
    return lines.DECIMALS, 0, 2, 1_000_000_000, 1


class TableClock:
    """Follows block after block: times of day run on over midnight, counters over their end, and spans that damage took
    are written down.

    midnight: added to each stamp, at last. turns: after how many nanoseconds a counter may start again. dated: a date stands in a
    column of its own.
    """

    def __init__(
        self,
        log: ImportLog,
        *,
        time_of_day: bool,
        midnight: int = 0,
        turns: tuple[int, ...] = (),
        dated: bool = False,
    ) -> None:
        self._runs_on: Counter | StandingDate | None = Counter(turns, log) if turns else None
        if dated:
            self._runs_on = StandingDate(log)
        self._log = log
        self._time_of_day = time_of_day
        self._midnight = midnight
        self._last: int | None = None
        self._left_out = 0

    def follow(self, block: RowBlock) -> IntArray:
        """The stamps of a block. shape (rows,); the block's own are changed."""
        time_ns = block.time_ns
        if self._time_of_day:
            before = None if self._last is None else self._last - self._midnight
            time_ns = unwrap_days(time_ns, before)
        if self._midnight:
            time_ns += self._midnight
        if self._runs_on is not None:
            time_ns = self._runs_on.follow(time_ns)
        self._write_gaps(time_ns, block.gaps, block.torn)
        self._last = int(time_ns[-1])
        self._left_out = 0
        return time_ns

    def leave_out(self, what: int) -> None:
        """Say that lines were left out behind the last block: BROKEN_ROWS or BLOCK_LOST of `table_lines`."""
        self._left_out = max(self._left_out, what)

    def _write_gaps(self, time_ns: IntArray, gaps: IntArray, torn: IntArray) -> None:
        if self._left_out and (len(gaps) == 0 or gaps[0] > 0):
            gaps = np.concatenate([np.zeros(1, dtype=np.int64), gaps])
        if self._left_out == lines.BLOCK_LOST:
            torn = np.concatenate([np.zeros(1, dtype=np.int64), torn])
        if self._last is None:
            gaps = gaps[gaps > 0]
        if len(gaps) == 0:
            return
        first = 0 if self._last is None else self._last
        before = np.where(gaps > 0, time_ns[gaps - 1], first)
        after = time_ns[gaps]
        least = np.where(np.isin(gaps, torn), 0, LOST_NS)
        wide = np.flatnonzero(after - before > least)
        spans = self._log.lost_spans_ns
        room = max(0, _MOST_SPANS - len(spans))
        spans.extend(zip(before[wide[:room]].tolist(), after[wide[:room]].tolist(), strict=True))
        if len(wide) > room:
            self._log.note(f"more than {_MOST_SPANS} spans of time are lost; only the first ones are listed")


def write_counts(counts: RowCounts, log: ImportLog) -> None:
    """Write down which rows were left out of a part of a file, and which cells hold no number."""
    log.reject(_NO_ROWS[0], counts.too_few)
    log.reject(_NO_ROWS[1], counts.too_many)
    log.reject("row with bytes that are no text", counts.binary)
    log.reject("cell with text where a number was expected", counts.text_cells)
    log.reject("cell with an infinite value", counts.infinite_cells)
    log.reject(NO_TIME, counts.no_time)
    if counts.binary:
        log.worsen(
            "malformed", "a part of the file is not text (a damaged block, or a disk that filled with zeros)"
        )


def judge_rows(log: ImportLog) -> None:
    """Say that a log is malformed of whose rows more than a few were left out, in the end."""
    found = {reason: log.rejected[reason] for reason in _NO_ROWS if log.rejected[reason]}
    lost = sum(found.values())
    if lost >= max(_MOST_ROWS, _MOST_SHARE * (lost + log.messages)):
        why = ", ".join(f"{count} x {reason}" for reason, count in found.items())
        log.worsen(
            "malformed", f"{lost} of {lost + log.messages} rows could not be read and were left out ({why})"
        )
