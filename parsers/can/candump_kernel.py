"""The compiled parser of candump's two dialects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.can.bytescan import (
    BAD,
    days_from_civil,
    decimal_ns,
    line_end,
    nibble,
    read_bytes,
    skip_space,
    token_end,
    whole_number,
)
from parsers.can.textlines import (
    BUSES,
    CLOCK,
    ERROR_FRAME,
    LAST_BAD_CODE,
    LAST_BAD_LINE,
    LINE,
    MALFORMED_END,
    NO_BUS,
    NO_DATA,
    NO_ID,
    NO_LAYOUT,
    NO_TIME,
    REMOTE_FRAME,
)
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel

MOST_BUSES = 64
NAME_BYTES = 16
"""IFNAMSIZ of Linux: no interface name is longer."""

PLAIN, DELTA, DATED = 0, 1, 2
"""How stamps are written: seconds as they stand; since the frame before; date and time of day (without a zone, so
that they are counted from the first)."""

_SECOND = 1_000_000_000


@kernel
def read_stamp(text: ByteArray, at: int, end: int, how: int) -> int:
    """The stamp between the brackets in ns, BAD where it cannot be read."""
    if how != DATED:
        return decimal_ns(text, at, end, _SECOND)
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
    seconds = decimal_ns(text, at + 17, end, _SECOND)
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
    return (days_from_civil(year, month, day) * 86400 + hour * 3600 + minute * 60) * _SECOND + seconds


@kernel
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


@kernel
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


@kernel
def compact_payload(text: ByteArray, at: int, end: int, data: ByteArray, into: int) -> int:
    """The payload after '#': its length, BAD where it cannot be read, -1 for a remote frame."""
    most = 8
    if at < end and text[at] == 35:
        if at + 1 >= end or nibble(text[at + 1]) < 0:
            return BAD
        at += 2
        most = 64
    elif at < end and (text[at] == 82 or text[at] == 114):
        return -1
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


@kernel
def spaced_payload(text: ByteArray, at: int, end: int, data: ByteArray, into: int) -> int:
    """The payload after '[n]': its length, BAD, or -1 for a remote frame. `at` is at the bracket."""
    close = at + 1
    while close < end and text[close] != 93:
        close += 1
    count = whole_number(text, at + 1, close, 10)
    if close >= end or count < 0 or count > 64:
        return BAD
    at = skip_space(text, token_end(text, close, end), end)
    if at < end and (text[at] == 114 or text[at] == 82):
        return -1
    return count if read_bytes(text, at, end, 16, count, data, into) != BAD else BAD


@kernel
def read_frame(text: ByteArray, at: int, end: int, data: ByteArray, into: int, found: IntArray) -> int:
    """What follows the interface's name: the payload's length, or -10 - code. found[1] becomes the id."""
    stop = token_end(text, at, end)
    mark = at
    while mark < stop and text[mark] != 35:
        mark += 1
    if mark < stop:
        id_end = mark
        count = compact_payload(text, mark + 1, stop, data, into)
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
        count = spaced_payload(text, bracket, end, data, into)
    can_id = read_id(text, at, id_end)
    if can_id == BAD:
        return -10 - NO_ID
    if can_id & 0x20000000 and not can_id & 0x80000000:
        return -10 - ERROR_FRAME
    if count == -1:
        return -10 - REMOTE_FRAME
    if count < 0:
        return -10 - NO_DATA
    found[1] = can_id
    return count


@kernel
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
    """One line that is not empty: the payload's length, or -10 - code. found: time, id and bus."""
    if text[at] != 40:
        return -10 - NO_TIME
    close = at + 1
    while close < end and text[close] != 41:
        close += 1
    inner = skip_space(text, at + 1, close)
    stamp = read_stamp(text, inner, close, how)
    if close >= end or stamp == BAD:
        return -10 - NO_TIME
    if how == DELTA:
        state[CLOCK] += stamp
        stamp = state[CLOCK]
    elif how == DATED:
        if state[CLOCK] == 0:
            state[CLOCK] = stamp
        stamp -= state[CLOCK]
    found[0] = stamp
    name_at = skip_space(text, close + 1, end)
    name_end = token_end(text, name_at, end)
    count = read_frame(text, skip_space(text, name_end, end), end, data, into, found)
    if count < 0:
        return count
    bus = bus_number(text, name_at, name_end, names, sizes, state)
    if bus == BAD:
        return -10 - NO_BUS
    found[2] = bus
    return count


@kernel
def parse_candump(
    text: ByteArray,
    how: int,
    names: ByteArray,
    sizes: IntArray,
    state: IntArray,
    counts: IntArray,
    first: IntArray,
    time_ns: IntArray,
    can_id: NDArray[np.uint32],
    bus: NDArray[np.int16],
    length: NDArray[np.uint8],
    offset: IntArray,
    data: ByteArray,
) -> int:
    """Parse a block of lines into the arrays; returns the number of frames. names: interfaces, 16 bytes each."""
    found = np.zeros(3, dtype=np.int64)
    n = 0
    used = 0
    begin = 0
    while begin < text.size:
        feed = line_end(text, begin)
        end = feed
        while end > begin and (text[end - 1] == 13 or text[end - 1] == 32):
            end -= 1
        state[LINE] += 1
        at = skip_space(text, begin, end)
        begin = feed + 1
        if at >= end:
            continue
        count = read_line(text, at, end, how, names, sizes, state, data, used, found)
        if count < 0:
            code = -10 - count
            counts[code] += 1
            if first[code] == 0:
                first[code] = state[LINE]
            if code < MALFORMED_END:
                state[LAST_BAD_LINE] = state[LINE]
                state[LAST_BAD_CODE] = code
            continue
        time_ns[n] = found[0]
        can_id[n] = found[1]
        bus[n] = found[2]
        length[n] = count
        offset[n] = used
        used += count
        n += 1
    return n
