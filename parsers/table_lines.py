"""The kernel that turns the lines of a table into columns, in one pass.

A line that holds nothing but cells is read as it comes, eight bytes at a time. Any other line (a comment, damage, a row
of another width, a word where a number belongs) is read again with care; both ways give the same numbers, and only the
second counts what was amiss.

Helpers are given addresses (see `table_bytes`): of the text; of `slots`, int64, where each column goes; of `numbers`,
float64, the row's place in the first column, `stride` bytes before its place in the next; of `spans`, int64, where the
time's cells begin and end.
"""

from __future__ import annotations

import math

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel, lean_kernel
from parsers.table_bytes import address_of, byte_at, int_at, put_float, put_int
from parsers.table_calendar import calendar_stamp
from parsers.table_numbers import EMPTY, HARD, INFINITE, OK, TEXT, odd_cell, parse_number
from parsers.table_stamps import clock_stamp, decimal_stamp, elapsed_stamp
from parsers.table_swar import cell_end, quick_number, skip_cells

# places in the rules
SEPARATOR, SPACES, QUOTE, COMMENT, DECIMAL, THOUSANDS, MIN_WIDTH, WIDTH, ROW_QUOTES, WITH_CARE = range(10)
Rules = tuple[int, int, int, int, int, int, int, int, int, int]
# places in what says how time is told: what kind, a date's order, how many columns, the unit of each
CLOCK_KIND, DATE_ORDER, TIME_COLUMNS, UNITS = range(4)
ZERO = DATE_ORDER
"""Decimal numbers have no date; the number that stands for 1970 where it is not 0 has its place."""
Clock = tuple[int, int, int, int, int]
DECIMALS, TIME_OF_DAY, MOMENT, HHMMSS, ELAPSED, OTHER_DECIMALS = range(6)
"""Kinds: sums of decimal numbers; times of day; dates with times of day; decimal numbers that spell HHMMSS; minutes and
seconds, or days and a time; decimal numbers whose decimal sign is a point in a table of commas, or a comma in one of points."""
# places in the state: how far the kernel came, then what it counted
ROWS, LEFT_OUT, GAPS, TOO_FEW, TOO_MANY, BINARY, NO_TIME, TEXTS, INFINITES, HARDS, LAST_SHORT, LAST_KEPT = (
    range(12)
)
TEXT_SLOT, TEXT_AT, TEXT_END, COMMENTS, STATE_SIZE = range(12, 17)

BROKEN_ROWS, BLOCK_LOST = 1, 2
"""In LEFT_OUT and in `gaps`: lines that are no rows, and lines with bytes that no text has among them. These are what a
damaged block left, and nobody knows for how many rows they stand."""

TIMES, SKIPPED = -1, -3
"""In `slots`: numbers are at 0 and up; the two columns of the time at -1 and -2; a column that nobody wants at -3, and
where n more of them follow at -3 - n."""


@kernel
def _slow_cell(start: int, stop: int, rules: Rules) -> tuple[int, float]:
    """What a cell is, and its number; NaN where it is empty."""
    if stop <= start:
        return EMPTY, math.nan
    status, value = parse_number(start, stop, rules[DECIMAL], rules[THOUSANDS])
    if status == TEXT:
        status = odd_cell(start, stop)
    return status, value


@lean_kernel
def _trim(start: int, stop: int) -> tuple[int, int]:
    """A cell without blanks and quotes around it."""
    while stop > start and (byte_at(stop - 1) <= 32 or byte_at(stop - 1) == 34):
        stop -= 1
    while start < stop and (byte_at(start) <= 32 or byte_at(start) == 34):
        start += 1
    return start, stop


@lean_kernel
def _quick_cell(at: int, separator: int, blank: int, quote: int, point: int) -> tuple[bool, float, int]:
    """The number in a cell, and where the cell ends; False where it is not a number and no more."""
    quoted = byte_at(at) == quote
    # only quotes tell a decimal comma from a comma between columns
    sure, value, i = quick_number(at + quoted, point if quoted or point != separator else -1)
    if quoted:
        sure = sure and byte_at(i) == quote
        i += 1
    c = byte_at(i)
    ends = (c == separator) | (c == blank) | (c == 10) | ((c == 13) & (byte_at(i + 1) == 10))
    return sure and ends, value, i


@kernel
def _other_cell(start: int, stop: int, rules: Rules, slot: int, number: int, spans: int) -> bool:
    """Put a cell that is not just a number where it belongs; False where its line needs care."""
    start, stop = _trim(start, stop)
    if slot < 0:
        put_int(spans + (TIMES - slot) * 16, start)
        put_int(spans + (TIMES - slot) * 16 + 8, stop)
        return True
    status, value = _slow_cell(start, stop, rules)
    put_float(number, value)
    return status in (OK, EMPTY)


@kernel
def _plain_line(start: int, rules: Rules, slots: int, numbers: int, stride: int, spans: int) -> int:
    """Read a line that holds nothing but cells; where the next line begins, 0 where it needs care."""
    separator, blank, quote, point = rules[SEPARATOR], rules[SPACES], rules[QUOTE], rules[DECIMAL]
    i = start
    while byte_at(i) == 32:
        i += 1
    if byte_at(i) == rules[COMMENT] or byte_at(i) == 10 or byte_at(i) == 13:
        return 0
    found = 0
    while True:
        while byte_at(i) == 32 or byte_at(i) == blank:
            i += 1
        if blank > 0 and (byte_at(i) == 10 or byte_at(i) == 13):
            break
        if found == rules[WIDTH]:
            return 0
        slot = int_at(slots + found * 8)
        found += 1
        sure, end = False, i
        if slot >= 0:
            sure, value, end = _quick_cell(i, separator, blank, quote, point)
            put_float(numbers + slot * stride, value)
        elif slot < SKIPPED and blank < 0:
            more = SKIPPED - slot
            end, lacking = skip_cells(i, more + 1, separator, quote)
            sure = lacking == 0 or byte_at(end) == 10
            if sure:
                found += more - max(0, lacking - 1)
        if not sure:
            end = cell_end(i, separator, blank, quote)
            if end == 0 or (
                slot > SKIPPED and not _other_cell(i, end, rules, slot, numbers + slot * stride, spans)
            ):
                return 0
        i = end
        c = byte_at(i)
        if c != separator and c != blank:
            break
        i += 1
    if byte_at(i) == 13:
        i += 1
    if byte_at(i) != 10 or found < rules[MIN_WIDTH]:
        return 0
    if found < rules[WIDTH]:
        _fill_up(found, rules[WIDTH], slots, numbers, stride, spans)
    return i + 1


@kernel
def _fill_up(found: int, width: int, slots: int, numbers: int, stride: int, spans: int) -> None:
    """Columns that a row lacks are empty."""
    for column in range(found, width):
        slot = int_at(slots + column * 8)
        if slot >= 0:
            put_float(numbers + slot * stride, math.nan)
        elif slot > SKIPPED:
            put_int(spans + (TIMES - slot) * 16, 0)
            put_int(spans + (TIMES - slot) * 16 + 8, 0)


@kernel
def _bounds(start: int, stop: int, rules: Rules) -> tuple[int, int]:
    """A line without the blanks around it, and the quotes where rows stand in quotes."""
    while stop > start and (byte_at(stop - 1) == 13 or byte_at(stop - 1) == 32):
        stop -= 1
    while start < stop and byte_at(start) == 32:
        start += 1
    if rules[ROW_QUOTES] != 0 and stop - start >= 2 and byte_at(start) == 34 and byte_at(stop - 1) == 34:
        return start + 1, stop - 1
    return start, stop


@kernel
def _split(start: int, stop: int, rules: Rules, cells: IntArray) -> tuple[int, bool]:
    """Find the cells of one line: how many, and whether there are bytes that no text has.

    cells: shape (width, 2), where they begin and end without blanks and quotes; empty where the row has no such column.
    """
    separator, blank, quote, width = rules[SEPARATOR], rules[SPACES], rules[QUOTE], rules[WIDTH]
    cells[:, :] = 0
    found = 0
    binary = False
    i = start
    while i <= stop:
        while i < stop and (byte_at(i) == 32 or byte_at(i) == blank):
            i += 1
        if blank > 0 and i >= stop:
            break
        begin = i
        if i < stop and byte_at(i) == quote:
            i += 1
            while i < stop and byte_at(i) != quote:
                i += 1
        while i < stop and byte_at(i) != separator and byte_at(i) != blank:
            binary |= byte_at(i) < 9
            i += 1
        if found < width:
            cells[found, 0], cells[found, 1] = _trim(begin, i)
        found += 1
        i += 1
    return found, binary


@kernel
def _is_row(start: int, stop: int, rules: Rules, cells: IntArray, state: IntArray) -> bool:
    """Split a line with care; False, and counted, where it is no row. Lines without anything are not."""
    start, stop = _bounds(start, stop, rules)
    if start >= stop:
        return False
    if byte_at(start) == rules[COMMENT]:
        state[COMMENTS] += 1
        return False
    found, binary = _split(start, stop, rules, cells)
    if not binary and rules[MIN_WIDTH] <= found <= rules[WIDTH]:
        return True
    short = not binary and found < rules[MIN_WIDTH]
    state[BINARY if binary else TOO_FEW if short else TOO_MANY] += 1
    state[LAST_SHORT], state[LAST_KEPT] = short, 0
    state[LEFT_OUT] = max(state[LEFT_OUT], BLOCK_LOST if binary else BROKEN_ROWS)
    return False


@kernel
def _fill_row(
    base: int,
    cells: IntArray,
    rules: Rules,
    slots: IntArray,
    numbers: FloatArray,
    row: int,
    spans: IntArray,
    hard: IntArray,
    state: IntArray,
) -> None:
    """Read the cells of a row. hard: shape (n, 4), slot, row and range of numbers that are left to Python's float."""
    for column in range(slots.shape[0]):
        slot, a, b = slots[column], cells[column, 0], cells[column, 1]
        if TIMES >= slot > SKIPPED:
            spans[TIMES - slot, 0], spans[TIMES - slot, 1] = a, b
        if slot < 0:
            continue
        status, numbers[slot, row] = _slow_cell(a, b, rules)
        if status == HARD:
            hard[state[HARDS], 0], hard[state[HARDS], 1] = slot, row
            hard[state[HARDS], 2], hard[state[HARDS], 3] = a - base, b - base
            state[HARDS] += 1
        elif status == INFINITE:
            state[INFINITES] += 1
        elif status == TEXT:
            if state[TEXTS] == 0 or slot < state[TEXT_SLOT]:
                state[TEXT_SLOT], state[TEXT_AT], state[TEXT_END] = slot, a - base, b - base
            state[TEXTS] += 1


@kernel
def _stamp(spans: int, rules: Rules, clock: Clock) -> tuple[bool, int]:
    """The time of a row."""
    total = 0
    days = 0
    for k in range(clock[TIME_COLUMNS]):
        start, stop = int_at(spans + 16 * k), int_at(spans + 16 * k + 8)
        if clock[CLOCK_KIND] == DECIMALS or clock[CLOCK_KIND] == HHMMSS:
            valid, part = decimal_stamp(
                start, stop, rules[DECIMAL], rules[THOUSANDS], clock[UNITS + k], clock[ZERO]
            )
        elif clock[CLOCK_KIND] == OTHER_DECIMALS:
            valid, part = decimal_stamp(start, stop, 90 - rules[DECIMAL], -1, clock[UNITS + k], clock[ZERO])
        elif clock[CLOCK_KIND] == ELAPSED:
            valid, part = elapsed_stamp(start, stop)
        else:
            valid, day, part = calendar_stamp(start, stop, clock[DATE_ORDER])
            days += day
        if valid and clock[CLOCK_KIND] == HHMMSS:
            valid, part = clock_stamp(part)
        if not valid:
            return False, 0
        total += part
    if clock[CLOCK_KIND] == MOMENT or clock[CLOCK_KIND] == TIME_OF_DAY:
        return (days != 0) == (clock[CLOCK_KIND] == MOMENT), total + days
    return True, total


@kernel
def _is_empty(start: int, stop: int, rules: Rules) -> bool:
    """Whether a row holds nothing but separators, as spreadsheets add behind a table."""
    for i in range(start, stop):
        c = byte_at(i)
        if not (c == rules[SEPARATOR] or c == 32 or c == 9 or c == 34 or c == 13 or c == 10):
            return False
    return True


@kernel
def read_lines(
    data: ByteArray,
    start: int,
    stop: int,
    limit: int,
    rules: Rules,
    clock: Clock,
    slots: IntArray,
    numbers: FloatArray,
    time_ns: IntArray,
    gaps: ByteArray,
    hard: IntArray,
    state: IntArray,
) -> int:
    """Read the lines of data[start:stop] that begin before `limit`; where it stopped, at the end or with full arrays.

    data: data[stop - 1] or data[stop] is a line feed, and `PADDING` bytes follow. slots: shape (width,), where each column
    goes. Out, from row state[ROWS] on: numbers, shape (n, rows); time_ns, (rows,); gaps, (rows,), BROKEN_ROWS or
    BLOCK_LOST where lines that are no rows were left out before a row. hard: see `_fill_row`; it must hold more than a row of them. state: shape
    (STATE_SIZE,), counts that only grow; LEFT_OUT says in the same way what was left out since the last row.
    """
    # an array lives on only as long as it is used as such: `spans` is, in the loop, beside its address
    spans = np.zeros((2, 2), dtype=np.int64)
    cells = np.zeros((slots.shape[0], 2), dtype=np.int64)
    base, slots_at, spans_at = address_of(data), address_of(slots), address_of(spans)
    numbers_at, stride = address_of(numbers), numbers.shape[1] * 8
    row = state[ROWS]
    i, stop, limit = base + start, base + stop, base + limit
    room = hard.shape[0] - numbers.shape[0]
    while i < stop and i < limit and row < time_ns.shape[0] and state[HARDS] <= room:
        after = 0
        if rules[WITH_CARE] == 0:
            after = _plain_line(i, rules, slots_at, numbers_at + row * 8, stride, spans_at)
        hards = state[HARDS]
        if after == 0:
            end = i
            while end < stop and byte_at(end) != 10:
                end += 1
            if not _is_row(i, end, rules, cells, state):
                i = end + 1
                continue
            _fill_row(base, cells, rules, slots, numbers, row, spans, hard, state)
            after = end + 1
        begin = i
        i = after
        valid, stamp = _stamp(spans_at, rules, clock)
        if not valid and _is_empty(begin, after, rules):
            state[HARDS] = hards
            continue
        state[LAST_SHORT], state[LAST_KEPT] = 0, valid
        if not valid:
            state[NO_TIME] += 1
            state[LEFT_OUT] = max(state[LEFT_OUT], BROKEN_ROWS)
            state[HARDS] = hards
            continue
        time_ns[row] = stamp
        gaps[row] = state[LEFT_OUT]
        state[GAPS] += state[LEFT_OUT]
        state[LEFT_OUT] = 0
        row += 1
    state[ROWS] = row
    return i - base
