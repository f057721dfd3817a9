"""The compiled parser of candump's two dialects."""

from __future__ import annotations

import numpy as np

from parsers.can.blocks import BEGIN, STOP, next_block
from parsers.can.bytescan import (
    BAD,
    days_from_civil,
    decimal_ns,
    holds_zeros,
    line_end,
    nibble,
    read_bytes,
    skip_space,
    token_end,
    trimmed_end,
    whole_number,
)
from parsers.can.layouts import Layouts, known_lines
from parsers.can.learn_layout import learn
from parsers.can.linebook import (
    BUS,
    BUSES,
    CLOCK,
    COUNT_AT,
    COUNT_END,
    DATA_AT,
    ERROR_FRAME,
    FOUND_SIZE,
    FRAMES,
    ID,
    ID_AT,
    ID_END,
    LINE,
    NO_BUS,
    NO_CLOCK,
    NO_DATA,
    NO_ID,
    NO_LAYOUT,
    NO_TIME,
    REMOTE_FRAME,
    STAMP,
    STAMP_AT,
    STAMP_END,
    TIME,
    TORN,
    USED,
    Book,
    Rows,
    accept,
    leave_out,
    reject,
)
from parsers.can.textlines import MOST_BUSES, NAME_BYTES
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel

PLAIN, DELTA, DATED = 0, 1, 2
"""How stamps are written: seconds as they stand; since the frame before; date and time of day (without a zone, so
that they are to be counted from the first, which `Book.state[CLOCK]` has)."""

SECOND_NS = 1_000_000_000


@lean_kernel
def read_stamp(text: ByteArray, at: int, end: int, how: int) -> int:
    """The stamp between the brackets in ns, BAD where it cannot be read."""
    if how != DATED:
        return decimal_ns(text, at, end, SECOND_NS)
    # 2015-07-10 09:00:52.249713
    if (
        end - at < 19
        or text[at + 4] != 45
        or text[at + 7] != 45
        or text[at + 13] != 58
        or text[at + 16] != 58
    ):
        return BAD
    year = whole_number(text, at, at + 4, 10)
    month = whole_number(text, at + 5, at + 7, 10)
    day = whole_number(text, at + 8, at + 10, 10)
    hour = whole_number(text, at + 11, at + 13, 10)
    minute = whole_number(text, at + 14, at + 16, 10)
    seconds = decimal_ns(text, at + 17, end, SECOND_NS)
    if (
        year < 1970
        or year > 2200
        or month < 1
        or month > 12
        or day < 1
        or hour < 0
        or minute < 0
        or seconds < 0
    ):
        return BAD
    return (days_from_civil(year, month, day) * 86400 + hour * 3600 + minute * 60) * SECOND_NS + seconds


@lean_kernel
def bus_number(text: ByteArray, at: int, end: int, names: ByteArray, sizes: IntArray, state: IntArray) -> int:
    """An interface's number, in order of appearance from 1; BAD where there are too many or the name is too long."""
    size = end - at
    if size < 1 or size > NAME_BYTES:
        return BAD
    met = int(state[BUSES])
    for k in range(met):
        if sizes[k] == size:
            same = True
            for i in range(size):
                if names[k * NAME_BYTES + i] != text[at + i]:
                    same = False
                    break
            if same:
                return k + 1
    k = met
    if k >= MOST_BUSES:
        return BAD
    for i in range(size):
        names[k * NAME_BYTES + i] = text[at + i]
    sizes[k] = size
    state[BUSES] = k + 1
    return k + 1


@lean_kernel
def read_id(text: ByteArray, at: int, end: int) -> int:
    """Three digits are a standard id, eight an extended one, as candump writes them. BAD, or with bit 31 for 29 bits."""
    value = whole_number(text, at, end, 16)
    if value < 0 or end - at > 8:
        return BAD
    if end - at <= 3:
        return value if value <= 0x7FF else BAD
    if value > 0x3FFFFFFF:
        return BAD
    if value & 0x20000000:
        return value
    return value | 0x80000000


@lean_kernel
def compact_payload(text: ByteArray, at: int, end: int, data: ByteArray, into: int, found: IntArray) -> int:
    """The payload after '#': its length, BAD where it cannot be read, -1 for a remote frame."""
    most = 8
    if at < end and text[at] == 35:
        if at + 1 >= end or nibble(text[at + 1]) < 0:
            return BAD
        at += 2
        most = 64
    elif at < end and (text[at] == 82 or text[at] == 114):
        return -1
    found[COUNT_AT] = 0
    found[COUNT_END] = most
    found[DATA_AT] = at
    count = 0
    while at < end and text[at] != 95:
        if text[at] == 46:
            at += 1
            continue
        if at + 1 >= end or count >= most or into + count >= data.size:
            return BAD
        high = nibble(text[at])
        low = nibble(text[at + 1])
        if high < 0 or low < 0:
            return BAD
        data[into + count] = high * 16 + low
        count += 1
        at += 2
    return count


@lean_kernel
def spaced_payload(text: ByteArray, at: int, end: int, data: ByteArray, into: int, found: IntArray) -> int:
    """The payload after '[n]': its length, BAD, or -1 for a remote frame. `at` is at the bracket."""
    bracket = at
    close = at + 1
    while close < end and text[close] != 93:
        close += 1
    count = whole_number(text, at + 1, close, 10)
    if close >= end or count < 0 or count > 64:
        return BAD
    at = skip_space(text, token_end(text, close, end), end)
    if at < end and (text[at] == 114 or text[at] == 82):
        return -1
    found[COUNT_AT] = bracket + 1
    found[COUNT_END] = close
    found[DATA_AT] = at
    return count if read_bytes(text, at, end, 16, count, data, into) != BAD else BAD


@lean_kernel
def read_frame(text: ByteArray, at: int, end: int, data: ByteArray, into: int, found: IntArray) -> int:
    """What follows the interface's name: the payload's length, or -10 - code. found[ID] becomes the id."""
    stop = token_end(text, at, end)
    mark = at
    while mark < stop and text[mark] != 35:
        mark += 1
    if mark < stop:
        id_end = mark
        count = compact_payload(text, mark + 1, stop, data, into, found)
    else:
        # the console form; -x puts direction and two flags before the id
        if stop - at == 2 and text[at + 1] == 88:
            at = skip_space(text, stop, end)
            while at < end and token_end(text, at, end) == at + 1:
                at = skip_space(text, at + 1, end)
            stop = token_end(text, at, end)
        id_end = stop
        bracket = skip_space(text, stop, end)
        if bracket >= end or text[bracket] != 91:
            return -10 - NO_LAYOUT
        count = spaced_payload(text, bracket, end, data, into, found)
    can_id = read_id(text, at, id_end)
    if can_id == BAD:
        return -10 - NO_ID
    if can_id & 0x20000000 and not can_id & 0x80000000:
        return -10 - ERROR_FRAME
    if count == -1:
        return -10 - REMOTE_FRAME
    if count < 0:
        return -10 - NO_DATA
    found[ID] = can_id
    found[ID_AT] = at
    found[ID_END] = id_end
    return count


@lean_kernel
def read_line(
    text: ByteArray,
    at: int,
    end: int,
    how: int,
    names: ByteArray,
    sizes: IntArray,
    state: IntArray,
    data: ByteArray,
    into: int,
    found: IntArray,
) -> int:
    """One line that is not empty: the payload's length, or -10 - code. found: all but NUMBER_AT and NUMBER_END."""
    if text[at] != 40:
        return -10 - NO_TIME
    close = at + 1
    while close < end and text[close] != 41:
        close += 1
    inner = skip_space(text, at + 1, close)
    stamp = read_stamp(text, inner, close, how)
    if close >= end or stamp == BAD:
        return -10 - NO_TIME
    found[STAMP] = stamp
    found[STAMP_AT] = inner + 17 if how == DATED else inner
    found[STAMP_END] = close
    if how == DELTA:
        state[CLOCK] += stamp
        stamp = state[CLOCK]
    elif how == DATED and state[CLOCK] == NO_CLOCK:
        state[CLOCK] = stamp
    found[TIME] = stamp
    name_at = skip_space(text, close + 1, end)
    name_end = token_end(text, name_at, end)
    count = read_frame(text, skip_space(text, name_end, end), end, data, into, found)
    if count < 0:
        return count
    bus = bus_number(text, name_at, name_end, names, sizes, state)
    if bus == BAD:
        return -10 - NO_BUS
    found[BUS] = bus
    return count


@kernel
def parse_candump(
    text: ByteArray,
    begin: int,
    stop: int,
    how: int,
    names: ByteArray,
    sizes: IntArray,
    book: Book,
    rows: Rows,
    layouts: Layouts,
) -> int:
    """Parse the lines in [begin, stop) of the text into the rows, as long as there is room; where it stopped. names: interfaces, 16 bytes each."""
    found = np.zeros(FOUND_SIZE, dtype=np.int64)
    while begin < stop:
        begin = known_lines(text, begin, stop, how == DELTA, book, rows, layouts)
        if begin >= stop or book.state[FRAMES] >= rows.time_ns.size:
            break
        feed = line_end(text, begin, stop)
        end = trimmed_end(text, begin, feed)
        book.state[LINE] += 1
        at = skip_space(text, begin, end)
        if at < end:
            into = book.state[USED]
            count = read_line(text, at, end, how, names, sizes, book.state, rows.data, into, found)
            if count < 0:
                leave_out(text, begin, feed, -10 - count, book)
            else:
                accept(book, rows, found, count)
                learn(text, begin, stop, count, SECOND_NS, found, book, layouts)
                if holds_zeros(text, begin, feed):
                    reject(book, TORN)
        begin = feed + 1
    return begin


@kernel
def walk_candump(
    text: ByteArray, walk: IntArray, how: int, names: ByteArray, sizes: IntArray, book: Book, rows: Rows, layouts: Layouts,
) -> bool:  # fmt: skip
    """`parse_candump` for all blocks of a walk (`parsers.can.blocks`); whether it stopped for want of room."""
    while next_block(text, walk):
        walk[BEGIN] = parse_candump(text, walk[BEGIN], walk[STOP], how, names, sizes, book, rows, layouts)
        if walk[BEGIN] < walk[STOP]:
            return True
    return False
