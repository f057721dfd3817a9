"""The compiled parser of PEAK TRC lines, whose columns the file names or its version fixes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.can.bytescan import (
    BAD,
    decimal_ns,
    line_end,
    read_bytes,
    same_word,
    skip_space,
    token_end,
    whole_number,
)
from parsers.can.textlines import (
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
    OTHER_EVENT,
    REMOTE_FRAME,
)
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel

_MILLISECOND = 1_000_000
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


@kernel
def one_of(text: ByteArray, at: int, end: int, pairs: ByteArray) -> bool:
    """Whether a word of two letters is one of `pairs`, which stand without separators."""
    if end - at != 2:
        return False
    found = False
    for k in range(0, pairs.size, 2):
        found = found or (text[at] == pairs[k] and text[at + 1] == pairs[k + 1])
    return found


@kernel
def check_type(text: ByteArray, at: int, end: int) -> int:
    """0 for a data frame's type, else -10 - code."""
    if one_of(text, at, end, _DATA_TYPES):
        return 0
    if one_of(text, at, end, _REMOTE_TYPES):
        return -10 - REMOTE_FRAME
    if one_of(text, at, end, _ERROR_TYPES):
        return -10 - ERROR_FRAME
    return -10 - (OTHER_EVENT if one_of(text, at, end, _OTHER_TYPES) else NO_LAYOUT)


@kernel
def check_direction(text: ByteArray, at: int, end: int) -> int:
    """0 for Rx and Tx, else -10 - code; versions 1.x put "Error" and "Warng" here."""
    if same_word(text, at, end, _RX) or same_word(text, at, end, _TX):
        return 0
    if same_word(text, at, end, _ERROR):
        return -10 - ERROR_FRAME
    return -10 - (OTHER_EVENT if same_word(text, at, end, _WARNING) else NO_LAYOUT)


@kernel
def read_id(text: ByteArray, at: int, end: int) -> int:
    """Up to four digits are a standard id, more an extended one: bit 31. BAD where it is none."""
    value = whole_number(text, at, end, 16)
    if end - at <= 4:
        return value if 0 <= value <= 0x7FF else BAD
    return value | 0x80000000 if 0 <= value <= 0x1FFFFFFF else BAD


@kernel
def read_size(text: ByteArray, at: int, end: int, is_code: bool) -> int:
    """The number of payload bytes, out of a byte count or a data length code; BAD where it is none."""
    value = whole_number(text, at, end, 10)
    if is_code and 9 <= value <= 15:
        return int(_FD_SIZES[value - 9])
    return value if 0 <= value <= 64 else BAD


@kernel
def read_line(
    text: ByteArray, at: int, end: int, columns: ByteArray, data: ByteArray, into: int, found: IntArray
) -> int:
    """One line that is neither empty nor a comment: the payload's length, or -10 - code."""
    count = 0
    found[2] = 1
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
        elif column == TIME:
            found[0] = decimal_ns(text, at, stop, _MILLISECOND)
            if found[0] == BAD:
                return -10 - NO_TIME
        elif column == TYPE:
            code = check_type(text, at, stop)
        elif column == DIRECTION:
            code = check_direction(text, at, stop)
        elif column == BUS:
            found[2] = whole_number(text, at, stop, 10)
            if found[2] < 0 or found[2] > 32767:
                return -10 - NO_BUS
        elif column == ID:
            if same_word(text, at, stop, _ERROR):
                return -10 - ERROR_FRAME
            # version 1.0 reports the state of the bus under an id of all ones
            if same_word(text, at, stop, _WARNING) or whole_number(text, at, stop, 16) == 0xFFFFFFFF:
                return -10 - OTHER_EVENT
            found[1] = read_id(text, at, stop)
            if found[1] == BAD:
                return -10 - NO_ID
        elif column in (SIZE, CODE):
            count = read_size(text, at, stop, column == CODE)
            if count == BAD:
                return -10 - NO_DATA
        if code < 0:
            return code
        at = stop
    if same_word(text, at, token_end(text, at, end), _RTR):
        return -10 - REMOTE_FRAME
    return count if read_bytes(text, at, end, 16, count, data, into) != BAD else -10 - NO_DATA


@kernel
def parse_trc(
    text: ByteArray,
    columns: ByteArray,
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
    """Parse a block of lines into the arrays; returns the number of frames. columns: letters, in order."""
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
        # a byte order mark may stand before the first comment
        if state[LINE] == 1 and end - at > 3 and text[at] == 0xEF:
            at += 3
        if at >= end or text[at] == 59:
            continue
        count = read_line(text, at, end, columns, data, used, found)
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
