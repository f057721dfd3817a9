"""The kernel that turns a block of whole text lines into columns, and its plain Python face `read_rows`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel
from parsers.table_numbers import HARD, INFINITE, OK, TEXT, odd_cell, parse_number

# places in the rule array of the kernels
_SEPARATOR, _SPACES, _QUOTE, _COMMENT, _DECIMAL, _THOUSANDS, _MIN_WIDTH, _WIDTH, _ROW_QUOTES = range(9)
# places in their counter array
_TOO_FEW, _TOO_MANY, _BINARY, _TEXT, _INFINITE, _HARD, _TEXT_AT, _TEXT_END, _LAST_FEW = range(9)
_HARD_ROOM = 65536
"""Cells of one block that are left to Python's float; real logs have next to none."""


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

    def as_array(self) -> IntArray:
        """The rules in the kernels' order."""
        return np.array(
            [
                self.separator,
                9 if self.spaces else -1,
                self.quote,
                self.comment,
                self.decimal,
                self.thousands,
                self.min_width,
                self.width,
                self.row_quotes,
            ],
            dtype=np.int64,
        )


@dataclass
class RowCounts:
    """What was met in a block: rows left out and cells without a number."""

    too_few: int = 0
    too_many: int = 0
    binary: int = 0
    text_cells: int = 0
    infinite_cells: int = 0
    unread_cells: int = 0
    last_row_short: bool = False
    first_text: tuple[int, bytes] | None = None


@dataclass(frozen=True)
class RowBlock:
    """The rows of a block. numbers: shape (n, rows). spans: shape (m, 2, rows), byte ranges in `data`."""

    data: ByteArray
    rows: int
    numbers: FloatArray
    spans: IntArray
    counts: RowCounts = field(default_factory=RowCounts)


@kernel
def _find_cells(
    data: ByteArray, line_ends: IntArray, rules: IntArray, slots: IntArray, cells: IntArray, counts: IntArray
) -> int:
    """Split whole lines into cells; the number of rows kept.

    cells: shape (slots, 2, lines), the byte range of each wanted cell, without blanks and quotes around it.
    """
    separator, blank, quote, width = rules[_SEPARATOR], rules[_SPACES], rules[_QUOTE], rules[_WIDTH]
    row = 0
    begin = 0
    for line in range(line_ends.shape[0]):
        i, stop = begin, line_ends[line]
        begin = stop + 1
        while stop > i and (data[stop - 1] == 13 or data[stop - 1] == 32):
            stop -= 1
        while i < stop and data[i] == 32:
            i += 1
        if rules[_ROW_QUOTES] != 0 and stop - i >= 2 and data[i] == 34 and data[stop - 1] == 34:
            i += 1
            stop -= 1
        if i >= stop or data[i] == rules[_COMMENT]:
            continue
        found = 0
        binary = False
        while i <= stop:
            while i < stop and (data[i] == 32 or data[i] == blank):
                i += 1
            if blank > 0 and i >= stop:
                break
            a = i
            if i < stop and data[i] == quote:
                i += 1
                while i < stop and data[i] != quote:
                    i += 1
            while i < stop and data[i] != separator and data[i] != blank:
                binary |= data[i] < 9
                i += 1
            if found < width and slots[found] >= 0:
                b = i
                while b > a and (data[b - 1] <= 32 or data[b - 1] == 34):
                    b -= 1
                while a < b and (data[a] <= 32 or data[a] == 34):
                    a += 1
                cells[slots[found], 0, row], cells[slots[found], 1, row] = a, b
            found += 1
            i += 1
        counts[_LAST_FEW] = 0
        for missing in range(found, width):
            if slots[missing] >= 0:
                cells[slots[missing], :, row] = 0
        if binary:
            counts[_BINARY] += 1
        elif found < rules[_MIN_WIDTH]:
            counts[_TOO_FEW] += 1
            counts[_LAST_FEW] = 1
        elif found > width:
            counts[_TOO_MANY] += 1
        else:
            row += 1
    return row


@kernel
def _parse_cells(
    data: ByteArray,
    starts: IntArray,
    stops: IntArray,
    rules: IntArray,
    values: FloatArray,
    hard: IntArray,
    counts: IntArray,
) -> None:
    """The numbers in one column's cells; NaN and a count where a cell holds none. hard: shape (k,), rows left over."""
    decimal, thousands = rules[_DECIMAL], rules[_THOUSANDS]
    for row in range(starts.shape[0]):
        start, stop = starts[row], stops[row]
        if stop <= start:
            values[row] = math.nan
            continue
        status, value = parse_number(data, start, stop, decimal, thousands)
        values[row] = value
        if status == OK:
            continue
        if status == HARD:
            if counts[_HARD] < hard.shape[0]:
                hard[counts[_HARD]] = row
            counts[_HARD] += 1
            continue
        status = odd_cell(data, start, stop)
        if status == INFINITE:
            counts[_INFINITE] += 1
        elif status == TEXT:
            if counts[_TEXT] == 0:
                counts[_TEXT_AT], counts[_TEXT_END] = start, stop
            counts[_TEXT] += 1


def read_rows(
    block: bytes, rules: RowRules, number_columns: tuple[int, ...], span_columns: tuple[int, ...]
) -> RowBlock:
    """Read a block of whole lines (the last may lack its newline).

    number_columns: columns parsed as numbers, in the order of `RowBlock.numbers`; span_columns: columns whose
    byte ranges are wanted. A column may not be in both.
    """
    data = np.frombuffer(block, dtype=np.uint8)
    ends = np.flatnonzero(data == 10)
    if len(data) and data[-1] != 10:
        ends = np.append(ends, len(data))
    wanted = (*number_columns, *span_columns)
    slots = np.full(rules.width, -1, dtype=np.int64)
    slots[list(wanted)] = np.arange(len(wanted))
    cells = np.empty((len(wanted), 2, len(ends)), dtype=np.int64)
    raw = np.zeros(9, dtype=np.int64)
    rule_array = rules.as_array()
    rows = _find_cells(data, ends, rule_array, slots, cells, raw)
    counts = RowCounts(
        int(raw[_TOO_FEW]), int(raw[_TOO_MANY]), int(raw[_BINARY]), last_row_short=bool(raw[_LAST_FEW])
    )
    numbers = np.empty((len(number_columns), rows))
    hard = np.empty(_HARD_ROOM, dtype=np.int64)
    for k, column in enumerate(number_columns):
        starts, stops = cells[k, 0, :rows], cells[k, 1, :rows]
        raw[:] = 0
        _parse_cells(data, starts, stops, rule_array, numbers[k], hard, raw)
        for row in hard[: raw[_HARD]].tolist():
            numbers[k, row] = plain_float(block[starts[row] : stops[row]], rules)
        counts.text_cells += int(raw[_TEXT])
        counts.infinite_cells += int(raw[_INFINITE])
        counts.unread_cells += max(0, int(raw[_HARD]) - _HARD_ROOM)
        if raw[_TEXT] and counts.first_text is None:
            counts.first_text = (column, block[raw[_TEXT_AT] : raw[_TEXT_END]][:40])
    return RowBlock(data, rows, numbers, cells[len(number_columns) :, :, :rows], counts)


def plain_float(text: bytes, rules: RowRules) -> float:
    """A number's text read by Python: for the few cells whose nearest double the kernel could not settle."""
    if rules.thousands > 0:
        text = text.replace(bytes([rules.thousands]), b"")
    return float(text.replace(bytes([rules.decimal]), b".").lower().replace(b"d", b"e"))
