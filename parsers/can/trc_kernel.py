"""The compiled parser of PEAK TRC lines, whose columns the file names or its version fixes."""

from __future__ import annotations

import numpy as np

from parsers.can.blocks import BEGIN, STOP, next_block
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
    BUS as ON_BUS,
)
from parsers.can.linebook import (
    COUNT_AT,
    COUNT_END,
    DATA_AT,
    ERROR_FRAME,
    FOUND_SIZE,
    FRAMES,
    ID_AT,
    ID_END,
    LINE,
    NO_BUS,
    NO_DATA,
    NO_ID,
    NO_LAYOUT,
    NO_TIME,
    NUMBER_AT,
    NUMBER_END,
    OTHER_EVENT,
    REMOTE_FRAME,
    STAMP,
    STAMP_AT,
    STAMP_END,
    TORN,
    USED,
    Book,
    Rows,
    accept,
    leave_out,
    reject,
)
from parsers.can.linebook import (
    ID as FRAME_ID,
)
from parsers.can.linebook import (
    TIME as FRAME_TIME,
)
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel

MILLISECOND_NS = 1_000_000
_RX = np.frombuffer(b"rx", dtype=np.uint8)
_TX = np.frombuffer(b"tx", dtype=np.uint8)
_RTR = np.frombuffer(b"rtr", dtype=np.uint8)
_ERROR = np.frombuffer(b"error", dtype=np.uint8)
_WARNING = np.frombuffer(b"warng", dtype=np.uint8)

_DATA_TYPES = np.frombuffer(b"DTFDFBFEFIBI", dtype=np.uint8)
_REMOTE_TYPES = np.frombuffer(b"RR", dtype=np.uint8)
_ERROR_TYPES = np.frombuffer(b"ER", dtype=np.uint8)
_OTHER_TYPES = np.frombuffer(b"STECEV", dtype=np.uint8)
_FD_SIZES = np.array([12, 16, 20, 24, 32, 48, 64], dtype=np.int64)

NUMBER, TIME, TYPE, BUS, ID, DIRECTION, RESERVED, SIZE, CODE, DATA = (ord(c) for c in "NOTBIdRlLD")
"""Columns by the letters that $COLUMNS uses: l is a number of bytes, L a data length code."""


@lean_kernel
def one_of(text: ByteArray, at: int, end: int, pairs: ByteArray) -> bool:
    """Whether a word of two letters is one of `pairs`, which stand without separators."""
    if end - at != 2:
        return False
    found = False
    for k in range(0, pairs.size, 2):
        found = found or (text[at] == pairs[k] and text[at + 1] == pairs[k + 1])
    return found


@lean_kernel
def check_type(text: ByteArray, at: int, end: int) -> int:
    """0 for a data frame's type, else -10 - code."""
    if one_of(text, at, end, _DATA_TYPES):
        return 0
    if one_of(text, at, end, _REMOTE_TYPES):
        return -10 - REMOTE_FRAME
    if one_of(text, at, end, _ERROR_TYPES):
        return -10 - ERROR_FRAME
    return -10 - (OTHER_EVENT if one_of(text, at, end, _OTHER_TYPES) else NO_LAYOUT)


@lean_kernel
def check_direction(text: ByteArray, at: int, end: int) -> int:
    """0 for Rx and Tx, else -10 - code; versions 1.x put "Error" and "Warng" here."""
    if same_word(text, at, end, _RX) or same_word(text, at, end, _TX):
        return 0
    if same_word(text, at, end, _ERROR):
        return -10 - ERROR_FRAME
    return -10 - (OTHER_EVENT if same_word(text, at, end, _WARNING) else NO_LAYOUT)


@lean_kernel
def read_id(text: ByteArray, at: int, end: int) -> int:
    """Up to four digits are a standard id, more an extended one: bit 31. BAD where it is none."""
    value = whole_number(text, at, end, 16)
    if end - at <= 4:
        return value if 0 <= value <= 0x7FF else BAD
    return value | 0x80000000 if 0 <= value <= 0x1FFFFFFF else BAD


@lean_kernel
def read_size(text: ByteArray, at: int, end: int, is_code: bool) -> int:
    """The number of payload bytes, out of a byte count or a data length code; BAD where it is none."""
    value = whole_number(text, at, end, 10)
    if is_code and 9 <= value <= 15:
        return int(_FD_SIZES[value - 9])
    return value if 0 <= value <= 64 else BAD


@lean_kernel
def read_time(text: ByteArray, at: int, end: int, found: IntArray) -> int:
    """Read a stamp: 0, or -10 - code."""
    stamp = decimal_ns(text, at, end, MILLISECOND_NS)
    found[FRAME_TIME] = stamp
    found[STAMP] = stamp
    found[STAMP_AT] = at
    found[STAMP_END] = end
    return 0 if stamp != BAD else -10 - NO_TIME


@lean_kernel
def read_frame_id(text: ByteArray, at: int, end: int, found: IntArray) -> int:
    """Read an identifier: 0, or -10 - code."""
    if same_word(text, at, end, _ERROR):
        return -10 - ERROR_FRAME
    # version 1.0 reports the state of the bus under an id of all ones
    if same_word(text, at, end, _WARNING) or whole_number(text, at, end, 16) == 0xFFFFFFFF:
        return -10 - OTHER_EVENT
    can_id = read_id(text, at, end)
    found[FRAME_ID] = can_id
    found[ID_AT] = at
    found[ID_END] = end
    return 0 if can_id != BAD else -10 - NO_ID


@lean_kernel
def read_line(
    text: ByteArray, at: int, end: int, columns: ByteArray, data: ByteArray, into: int, found: IntArray
) -> int:
    """One line that is neither empty nor a comment: the payload's length, or -10 - code."""
    count = 0
    found[ON_BUS] = 1
    for column in columns:
        at = skip_space(text, at, end)
        stop = token_end(text, at, end)
        code = 0
        if column == DATA:
            break
        if at >= stop:
            return -10 - NO_LAYOUT
        if column == NUMBER:
            last = stop - 1 if text[stop - 1] == 41 else stop
            if whole_number(text, at, last, 10) == BAD:
                return -10 - NO_LAYOUT
            found[NUMBER_AT] = at
            found[NUMBER_END] = last
        elif column == TIME:
            code = read_time(text, at, stop, found)
        elif column == TYPE:
            code = check_type(text, at, stop)
        elif column == DIRECTION:
            code = check_direction(text, at, stop)
        elif column == BUS:
            found[ON_BUS] = whole_number(text, at, stop, 10)
            if found[ON_BUS] < 0 or found[ON_BUS] > 32767:
                return -10 - NO_BUS
        elif column == ID:
            code = read_frame_id(text, at, stop, found)
        elif column in (SIZE, CODE):
            count = read_size(text, at, stop, column == CODE)
            if count == BAD:
                return -10 - NO_DATA
            found[COUNT_AT] = at
            found[COUNT_END] = stop
        if code < 0:
            return code
        at = stop
    if same_word(text, at, token_end(text, at, end), _RTR):
        return -10 - REMOTE_FRAME
    found[DATA_AT] = at
    return count if read_bytes(text, at, end, 16, count, data, into) != BAD else -10 - NO_DATA


@kernel
def parse_trc(
    text: ByteArray, begin: int, stop: int, columns: ByteArray, book: Book, rows: Rows, layouts: Layouts
) -> int:
    """Parse the lines in [begin, stop) of the text into the rows, as long as there is room; where it stopped. columns: letters, in order."""
    found = np.zeros(FOUND_SIZE, dtype=np.int64)
    while begin < stop:
        begin = known_lines(text, begin, stop, False, book, rows, layouts)
        if begin >= stop or book.state[FRAMES] >= rows.time_ns.size:
            break
        feed = line_end(text, begin, stop)
        end = trimmed_end(text, begin, feed)
        book.state[LINE] += 1
        at = skip_space(text, begin, end)
        if at < end and text[at] != 59:
            count = read_line(text, at, end, columns, rows.data, book.state[USED], found)
            if count < 0:
                leave_out(text, begin, feed, -10 - count, book)
            else:
                accept(book, rows, found, count)
                learn(text, begin, stop, count, MILLISECOND_NS, found, book, layouts)
                if holds_zeros(text, begin, feed):
                    reject(book, TORN)
        elif swallowed(text, begin, feed):
            reject(book, TORN)
        begin = feed + 1
    return begin


@kernel
def walk_trc(
    text: ByteArray, walk: IntArray, columns: ByteArray, book: Book, rows: Rows, layouts: Layouts,
) -> bool:  # fmt: skip
    """`parse_trc` for all blocks of a walk (`parsers.can.blocks`); whether it stopped for want of room."""
    while next_block(text, walk):
        walk[BEGIN] = parse_trc(text, walk[BEGIN], walk[STOP], columns, book, rows, layouts)
        if walk[BEGIN] < walk[STOP]:
            return True
    return False
