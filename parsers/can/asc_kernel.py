"""The compiled parser of Vector ASC lines."""

from __future__ import annotations

import numpy as np

from parsers.can.blocks import BEGIN, CUT, STOP, next_block
from parsers.can.bytescan import (
    BAD,
    decimal_ns,
    holds_zeros,
    line_end,
    read_bytes,
    same_word,
    skip_space,
    swallowed,
    token_end,
    trimmed_end,
    whole_number,
)
from parsers.can.layouts import Layouts, known_lines
from parsers.can.learn_layout import learn
from parsers.can.linebook import (
    BUS,
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
    NO_DATA,
    NO_ID,
    NO_LAYOUT,
    NO_TIME,
    OTHER_EVENT,
    REMOTE_FRAME,
    SENDING_REQUEST,
    STAMP,
    STAMP_AT,
    STAMP_END,
    STATISTIC,
    TIME,
    TORN,
    USED,
    Book,
    Rows,
    accept,
    leave_out,
    reject,
)
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel

SECOND_NS = 1_000_000_000
_RX = np.frombuffer(b"rx", dtype=np.uint8)
_TX = np.frombuffer(b"tx", dtype=np.uint8)
_TXRQ = np.frombuffer(b"txrq", dtype=np.uint8)
_CANFD = np.frombuffer(b"canfd", dtype=np.uint8)
_ERRORFRAME = np.frombuffer(b"errorframe", dtype=np.uint8)
_OVERLOADFRAME = np.frombuffer(b"overloadframe", dtype=np.uint8)
_STATISTIC = np.frombuffer(b"statistic:", dtype=np.uint8)
_START = np.frombuffer(b"start", dtype=np.uint8)

_SILENT = -1
"""A line that says nothing of a frame and is not worth counting: comment, header, start of measurement."""


@lean_kernel
def read_id(text: ByteArray, at: int, end: int, base: int) -> int:
    """An identifier with bit 31 where an x follows it; BAD where it is none."""
    extended = end > at and (text[end - 1] == 120 or text[end - 1] == 88)
    value = whole_number(text, at, end - 1 if extended else end, base)
    if value < 0 or value > (0x1FFFFFFF if extended else 0x7FF):
        return BAD
    return value | 0x80000000 if extended else value


@lean_kernel
def tell_id(text: ByteArray, at: int, end: int, can_id: int, found: IntArray) -> None:
    """Note the identifier, and where its digits stand."""
    found[ID] = can_id
    found[ID_AT] = at
    found[ID_END] = end - 1 if end > at and (text[end - 1] == 120 or text[end - 1] == 88) else end


@lean_kernel
def tell_payload(text: ByteArray, at: int, stop: int, end: int, found: IntArray) -> None:
    """Note where the payload's size stands, which is the word [at, stop), and where the payload does."""
    found[COUNT_AT] = at
    found[COUNT_END] = stop
    found[DATA_AT] = skip_space(text, stop, end)


@lean_kernel
def read_direction(text: ByteArray, at: int, end: int) -> int:
    """0 for Rx and Tx, 1 for TxRq, BAD for anything else."""
    if same_word(text, at, end, _RX) or same_word(text, at, end, _TX):
        return 0
    return 1 if same_word(text, at, end, _TXRQ) else BAD


@lean_kernel
def is_flag(text: ByteArray, at: int, end: int) -> bool:
    """Whether a word is a single 0 or 1."""
    return end - at == 1 and (text[at] == 48 or text[at] == 49)


@lean_kernel
def read_classic(
    text: ByteArray, at: int, end: int, base: int, broken_at: int, data: ByteArray, into: int, found: IntArray
) -> int:
    """What follows the channel of a CAN line: the payload's length, or -10 - code. found[ID] becomes the id.

    broken_at: where the file breaks off in this line, -1 where the line is whole.
    """
    stop = token_end(text, at, end)
    if same_word(text, at, stop, _ERRORFRAME):
        return -10 - ERROR_FRAME
    if same_word(text, at, stop, _STATISTIC):
        return -10 - STATISTIC
    if same_word(text, at, stop, _OVERLOADFRAME):
        return -10 - OTHER_EVENT
    can_id = read_id(text, at, stop, base)
    tell_id(text, at, stop, can_id, found)
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    direction = read_direction(text, at, stop)
    if direction == BAD:
        # a line that breaks off in the id or direction looks like this too
        return -10 - (NO_LAYOUT if at >= end or broken_at >= 0 else OTHER_EVENT)
    if can_id == BAD:
        return -10 - NO_ID
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    if stop - at != 1 or (text[at] != 100 and text[at] != 68 and text[at] != 114 and text[at] != 82):
        return -10 - NO_LAYOUT
    if text[at] == 114 or text[at] == 82:
        return -10 - REMOTE_FRAME
    if direction == 1:
        return -10 - SENDING_REQUEST
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    count = whole_number(text, at, stop, base)
    if count < 0 or count > 15:
        return -10 - NO_DATA
    count = min(count, 8)
    tell_payload(text, at, stop, end, found)
    last = read_bytes(text, stop, end, base, count, data, into)
    # of a decimal number that the file's end cuts short nobody can tell
    if last == BAD or (base == 10 and last == broken_at):
        return -10 - NO_DATA
    return count


@lean_kernel
def read_fd(
    text: ByteArray, at: int, end: int, base: int, broken_at: int, data: ByteArray, into: int, found: IntArray
) -> int:
    """What follows the word CANFD: as `read_classic`, and found[BUS] becomes the bus."""
    stop = token_end(text, at, end)
    bus = whole_number(text, at, stop, 10)
    if bus < 0 or bus > 32767:
        return -10 - NO_BUS
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    direction = read_direction(text, at, stop)
    if direction == BAD:
        return -10 - NO_LAYOUT
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    if same_word(text, at, stop, _ERRORFRAME):
        return -10 - ERROR_FRAME
    can_id = read_id(text, at, stop, base)
    if can_id == BAD:
        return -10 - NO_ID
    tell_id(text, at, stop, can_id, found)
    # a symbolic name may stand before the two flags
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    if not is_flag(text, at, stop):
        at = skip_space(text, stop, end)
        stop = token_end(text, at, end)
    if not is_flag(text, at, stop):
        return -10 - NO_LAYOUT
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    if not is_flag(text, at, stop):
        return -10 - NO_LAYOUT
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    code = whole_number(text, at, stop, 16)
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    count = whole_number(text, at, stop, 10)
    if code < 0 or count < 0 or count > 64:
        return -10 - NO_DATA
    if count == 0 and code > 0:
        return -10 - REMOTE_FRAME
    if direction == 1:
        return -10 - SENDING_REQUEST
    tell_payload(text, at, stop, end, found)
    last = read_bytes(text, stop, end, base, count, data, into)
    if last == BAD or (base == 10 and last == broken_at):
        return -10 - NO_DATA
    found[BUS] = bus
    return count


@lean_kernel
def read_line(
    text: ByteArray,
    at: int,
    end: int,
    base: int,
    relative: bool,
    broken_at: int,
    state: IntArray,
    data: ByteArray,
    into: int,
    found: IntArray,
) -> int:
    """One line that is not empty: the payload's length, -10 - code, or -1 for a line of no account."""
    if not 48 <= text[at] <= 57 and text[at] != 45:
        # comments, header, trigger blocks; damage begins with something that is no letter
        letter = 65 <= text[at] <= 90 or 97 <= text[at] <= 122 or text[at] == 47
        return _SILENT if letter else -10 - NO_TIME
    stop = token_end(text, at, end)
    stamp = decimal_ns(text, at, stop, SECOND_NS)
    fraction = False
    for i in range(at, stop):
        fraction = fraction or text[i] == 46 or text[i] == 44
    if stamp == BAD or not fraction:
        return -10 - NO_TIME
    found[STAMP] = stamp
    found[STAMP_AT] = at
    found[STAMP_END] = stop
    if relative:
        state[CLOCK] += stamp
        stamp = state[CLOCK]
    found[TIME] = stamp
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    if at >= end:
        return -10 - NO_LAYOUT
    bus = whole_number(text, at, stop, 10)
    if bus != BAD:
        if bus > 32767:
            return -10 - NO_BUS
        found[BUS] = bus
        return read_classic(text, skip_space(text, stop, end), end, base, broken_at, data, into, found)
    if same_word(text, at, stop, _CANFD):
        return read_fd(text, skip_space(text, stop, end), end, base, broken_at, data, into, found)
    if same_word(text, at, stop, _START):
        return _SILENT
    return -10 - (OTHER_EVENT if broken_at < 0 else NO_LAYOUT)


@kernel
def parse_asc(
    text: ByteArray,
    begin: int,
    stop: int,
    base: int,
    relative: bool,
    ended: bool,
    book: Book,
    rows: Rows,
    layouts: Layouts,
) -> int:
    """Parse the lines in [begin, stop) of the text into the rows, as long as there is room; where it stopped. base: 16 or 10. ended: the last one has its feed."""
    found = np.zeros(FOUND_SIZE, dtype=np.int64)
    while begin < stop:
        begin = known_lines(text, begin, stop, relative, book, rows, layouts)
        if begin >= stop or book.state[FRAMES] >= rows.time_ns.size:
            break
        feed = line_end(text, begin, stop)
        end = trimmed_end(text, begin, feed)
        book.state[LINE] += 1
        at = skip_space(text, begin, end)
        if at < end:
            broken_at = -1 if ended or feed < stop else stop
            into = book.state[USED]
            count = read_line(text, at, end, base, relative, broken_at, book.state, rows.data, into, found)
            if count >= 0:
                accept(book, rows, found, count)
                if base == 16:
                    learn(text, begin, stop, count, SECOND_NS, found, book, layouts)
            elif count != _SILENT:
                leave_out(text, begin, feed, -10 - count, book)
            if (count >= 0 and holds_zeros(text, begin, feed)) or (
                count == _SILENT and swallowed(text, begin, feed)
            ):
                reject(book, TORN)
        begin = feed + 1
    return begin


@kernel
def walk_asc(
    text: ByteArray, walk: IntArray, base: int, relative: bool, book: Book, rows: Rows, layouts: Layouts,
) -> bool:  # fmt: skip
    """`parse_asc` for all blocks of a walk (`parsers.can.blocks`); whether it stopped for want of room."""
    while next_block(text, walk):
        ended = walk[CUT] == 1 or text[walk[STOP] - 1] == 10
        walk[BEGIN] = parse_asc(text, walk[BEGIN], walk[STOP], base, relative, ended, book, rows, layouts)
        if walk[BEGIN] < walk[STOP]:
            return True
    return False
