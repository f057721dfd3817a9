"""Rows of a text table as columns: how rows are written, what is wanted of them, and the collector that a kernel fills."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from parsers import table_lines as lines
from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.table_swar import PADDING

_HARD_ROOM = 4096
"""Cells that a kernel leaves to Python's float before it comes back to have them read; real logs have next to none."""

_MINUS = "\N{MINUS SIGN}".encode()
_GROUPS = re.compile(rb"\xc2\xa0|\xe2\x80[\xaf\x89\x99]|[\xa0\x92]")
"""Between groups of digits, in UTF-8 and cp1252: as `table_numbers.group_sign`."""


@dataclass(frozen=True)
class RowRules:
    """How a table's rows are written. Characters are byte values, -1 where there is none.

    spaces: columns are separated by any run of spaces and tabs. row_quotes: whole rows stand in quotes.
    width: columns of a row; rows down to `min_width` are taken too, what lacks is empty.
    """

    separator: int
    width: int
    min_width: int
    spaces: bool = False
    quote: int = 34
    comment: int = 35
    decimal: int = 46
    thousands: int = -1
    row_quotes: bool = False

    def for_kernel(self, *, with_care: bool) -> lines.Rules:
        """The rules in the kernel's order. with_care: read every line the careful way."""
        return (
            self.separator,
            9 if self.spaces else -1,
            self.quote,
            self.comment,
            self.decimal,
            self.thousands,
            self.min_width,
            self.width,
            int(self.row_quotes),
            int(with_care or self.row_quotes),
        )


@dataclass(frozen=True)
class RowPlan:
    """What to read of a table's rows. numbers: columns to read as numbers, in this order; times: the columns that tell
    the time, two at most; clock: how they do, in the kernel's order. A column may not be in both. with_care: read every
    line the careful way, to check the quick one."""

    rules: RowRules
    numbers: tuple[int, ...]
    times: tuple[int, ...] = ()
    clock: lines.Clock = (lines.DECIMALS, 0, 0, 0, 0)
    with_care: bool = False

    def slots(self) -> IntArray:
        """For each column, where the kernel puts it."""
        slots = np.zeros(self.rules.width, dtype=np.int64)
        wanted = {*self.numbers, *self.times}
        more = 0
        for column in reversed(range(self.rules.width)):
            more = 0 if column in wanted else more + 1
            slots[column] = lines.SKIPPED + 1 - more
        slots[list(self.numbers)] = np.arange(len(self.numbers))
        slots[list(self.times)] = lines.TIMES - np.arange(len(self.times))
        return slots


@dataclass
class RowCounts:
    """What was met beside numbers: rows left out and cells without a number; and comments, which are
    passed over. first_text: column and text of the first
    word where a number was expected, in the first column that has one."""

    too_few: int = 0
    too_many: int = 0
    binary: int = 0
    no_time: int = 0
    text_cells: int = 0
    infinite_cells: int = 0
    comments: int = 0
    first_text: tuple[int, bytes] | None = None


@dataclass(frozen=True)
class RowBlock:
    """Rows. time_ns: shape (rows,). numbers: shape (n, rows). gaps: the rows before which lines were left out; torn: those of
    them where a damaged block was among these lines."""

    time_ns: IntArray
    numbers: FloatArray
    gaps: IntArray
    torn: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))


@dataclass
class RowCollector:
    """Reads pieces of text, one after the other, into blocks of rows.

    counts: of all pieces so far. left_out: 0, BROKEN_ROWS or BLOCK_LOST of `table_lines`, since the last row. last_short, last_kept: whether
    the last line had too few columns; whether it is the last row.
    """

    plan: RowPlan
    counts: RowCounts = field(default_factory=RowCounts)
    left_out: int = 0
    last_short: bool = False
    last_kept: bool = False

    def __post_init__(self) -> None:
        self._rules = self.plan.rules.for_kernel(with_care=self.plan.with_care)
        self._slots = self.plan.slots()
        self._hard = np.empty((_HARD_ROOM + len(self.plan.numbers), 4), dtype=np.int64)
        self._state = np.zeros(lines.STATE_SIZE, dtype=np.int64)
        self._blocks: list[RowBlock] = []
        self._new_columns(0)

    def _new_columns(self, rows: int) -> None:
        # columns that lie a multiple of 4096 bytes apart would push each other out of the processor's cache
        rows += 8 if rows and rows % 512 == 0 else 0
        self._numbers = np.empty((len(self.plan.numbers), rows))
        self._time_ns = np.empty(rows, dtype=np.int64)
        self._gaps: ByteArray = np.empty(rows, dtype=np.uint8)
        self._state[[lines.ROWS, lines.GAPS]] = 0

    def take(self, text: bytearray, start: int, stop: int, limit: int, to_come: int) -> None:
        """Read the lines of text[start:stop] that begin before `limit`.

        text: text[stop - 1] or text[stop] is a line feed, and `PADDING` bytes follow. to_come: about how many bytes will
        follow in later pieces; it only serves to make columns of the right size.
        """
        if len(text) < stop + PADDING or not 0 <= start < stop or text.find(b"\n", stop - 1, stop + 1) < 0:
            raise ValueError("a text must end with a line feed and padding")
        data = np.frombuffer(text, dtype=np.uint8)
        while start < min(stop, limit):
            if self._state[lines.ROWS] >= len(self._time_ns):
                self._close()
                self._new_columns(self._expected(text, start, stop, to_come))
            start = self._run(data, text, start, stop, limit)

    def _expected(self, text: bytearray, start: int, stop: int, to_come: int) -> int:
        """How many rows to make room for, by the lines of this piece; never more than the bytes can hold."""
        size = stop - start
        counted = text.count(b"\n", start, stop) + 1
        most = (size + to_come) // max(1, self.plan.rules.min_width)
        return min(int(counted * (1.03 * to_come / size + 1)), most) + 8

    def _run(self, data: ByteArray, text: bytearray, start: int, stop: int, limit: int) -> int:
        state = self._state
        state[[lines.HARDS, lines.TEXTS]] = 0
        start = lines.read_lines(
            data,
            start,
            stop,
            limit,
            self._rules,
            self.plan.clock,
            self._slots,
            self._numbers,
            self._time_ns,
            self._gaps,
            self._hard,
            state,
        )
        for slot, row, a, b in self._hard[: state[lines.HARDS]].tolist():
            self._numbers[slot, row] = plain_float(bytes(text[a:b]), self.plan.rules)
        counts = self.counts
        counts.text_cells += int(state[lines.TEXTS])
        if state[lines.TEXTS]:
            column = self.plan.numbers[state[lines.TEXT_SLOT]]
            if counts.first_text is None or column < counts.first_text[0]:
                shown = text[state[lines.TEXT_AT] : state[lines.TEXT_END]][:40]
                counts.first_text = (column, bytes(shown))
        return start

    def _close(self) -> None:
        rows = int(self._state[lines.ROWS])
        if rows:
            gaps = torn = np.empty(0, dtype=np.int64)
            if self._state[lines.GAPS]:
                gaps = np.flatnonzero(self._gaps[:rows])
                torn = np.flatnonzero(self._gaps[:rows] == lines.BLOCK_LOST)
            self._blocks.append(RowBlock(self._time_ns[:rows], self._numbers[:, :rows], gaps, torn))

    def lose_line(self) -> None:
        """Count a line that is left out unread."""
        self._state[lines.BINARY] += 1
        self._state[lines.LEFT_OUT] = lines.BLOCK_LOST
        self._state[[lines.LAST_SHORT, lines.LAST_KEPT]] = 0

    def finish(self) -> list[RowBlock]:
        """Close the last block; all blocks with rows."""
        self._close()
        self._new_columns(0)
        state, counts = self._state, self.counts
        counts.too_few, counts.too_many = int(state[lines.TOO_FEW]), int(state[lines.TOO_MANY])
        counts.binary, counts.no_time = int(state[lines.BINARY]), int(state[lines.NO_TIME])
        counts.infinite_cells, counts.comments = int(state[lines.INFINITES]), int(state[lines.COMMENTS])
        self.left_out, self.last_short = int(state[lines.LEFT_OUT]), bool(state[lines.LAST_SHORT])
        self.last_kept = bool(state[lines.LAST_KEPT])
        return self._blocks


def plain_float(text: bytes, rules: RowRules) -> float:
    """A number's text read by Python: for the few cells whose nearest double the kernel could not settle."""
    if rules.thousands > 0:
        text = text.replace(bytes([rules.thousands]), b"")
    text = _GROUPS.sub(b"", text.replace(_MINUS, b"-")).replace(bytes([rules.decimal]), b".")
    return float(text.lower().replace(b"d", b"e"))
