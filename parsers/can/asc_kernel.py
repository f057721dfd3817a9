"""The compiled parser of Vector ASC lines."""

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
    OTHER_EVENT,
    REMOTE_FRAME,
    SENDING_REQUEST,
    STATISTIC,
)
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel

_SECOND = 1_000_000_000
_RX = np.frombuffer(b"rx", dtype=np.uint8)
_TX = np.frombuffer(b"tx", dtype=np.uint8)
_TXRQ = np.frombuffer(b"txrq", dtype=np.uint8)
_CANFD = np.frombuffer(b"canfd", dtype=np.uint8)
_ERRORFRAME = np.frombuffer(b"errorframe", dtype=np.uint8)
_STATISTIC = np.frombuffer(b"statistic:", dtype=np.uint8)
_START = np.frombuffer(b"start", dtype=np.uint8)

_SILENT = -1
"""A line that says nothing of a frame and is not worth counting: comment, header, start of measurement."""


@kernel
def read_id(text: ByteArray, at: int, end: int, base: int) -> int:
    """An identifier with bit 31 where an x follows it; BAD where it is none."""
    extended = end > at and (text[end - 1] == 120 or text[end - 1] == 88)
    value = whole_number(text, at, end - 1 if extended else end, base)
    if value < 0 or value > (0x1FFFFFFF if extended else 0x7FF):
        return BAD
    return value | 0x80000000 if extended else value


@kernel
def read_direction(text: ByteArray, at: int, end: int) -> int:
    """0 for Rx and Tx, 1 for TxRq, BAD for anything else."""
    if same_word(text, at, end, _RX) or same_word(text, at, end, _TX):
        return 0
    return 1 if same_word(text, at, end, _TXRQ) else BAD


@kernel
def is_flag(text: ByteArray, at: int, end: int) -> bool:
    """Whether a word is a single 0 or 1."""
    return end - at == 1 and (text[at] == 48 or text[at] == 49)


@kernel
def read_classic(
    text: ByteArray, at: int, end: int, base: int, whole: bool, data: ByteArray, into: int, found: IntArray
) -> int:
    """What follows the channel of a CAN line: the payload's length, or -10 - code. found[1] becomes the id."""
    stop = token_end(text, at, end)
    if same_word(text, at, stop, _ERRORFRAME):
        return -10 - ERROR_FRAME
    if same_word(text, at, stop, _STATISTIC):
        return -10 - STATISTIC
    can_id = read_id(text, at, stop, base)
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    direction = read_direction(text, at, stop)
    if direction == BAD:
        # a line that breaks off in the id or direction looks like this too
        return -10 - (NO_LAYOUT if at >= end or not whole else OTHER_EVENT)
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
    last = read_bytes(text, stop, end, base, count, data, into)
    # of a decimal number that the file's end cuts short nobody can tell
    if last == BAD or (base == 10 and last == text.size and not whole):
        return -10 - NO_DATA
    found[1] = can_id
    return count


@kernel
def read_fd(
    text: ByteArray, at: int, end: int, base: int, whole: bool, data: ByteArray, into: int, found: IntArray
) -> int:
    """What follows the word CANFD: as `read_classic`, and found[2] becomes the bus."""
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
    last = read_bytes(text, stop, end, base, count, data, into)
    if last == BAD or (base == 10 and last == text.size and not whole):
        return -10 - NO_DATA
    found[1] = can_id
    found[2] = bus
    return count


@kernel
def read_line(
    text: ByteArray,
    at: int,
    end: int,
    base: int,
    relative: bool,
    whole: bool,
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
    stamp = decimal_ns(text, at, stop, _SECOND)
    fraction = False
    for i in range(at, stop):
        fraction = fraction or text[i] == 46 or text[i] == 44
    if stamp == BAD or not fraction:
        return -10 - NO_TIME
    if relative:
        state[CLOCK] += stamp
        stamp = state[CLOCK]
    found[0] = stamp
    at = skip_space(text, stop, end)
    stop = token_end(text, at, end)
    if at >= end:
        return -10 - NO_LAYOUT
    bus = whole_number(text, at, stop, 10)
    if bus != BAD:
        if bus > 32767:
            return -10 - NO_BUS
        found[2] = bus
        return read_classic(text, skip_space(text, stop, end), end, base, whole, data, into, found)
    if same_word(text, at, stop, _CANFD):
        return read_fd(text, skip_space(text, stop, end), end, base, whole, data, into, found)
    if same_word(text, at, stop, _START):
        return _SILENT
    return -10 - (OTHER_EVENT if whole else NO_LAYOUT)


@kernel
def parse_asc(
    text: ByteArray,
    base: int,
    relative: bool,
    ended: bool,
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
    """Parse a block of lines into the arrays; returns the number of frames. base: 16 or 10."""
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
        whole = ended or feed < text.size
        count = read_line(text, at, end, base, relative, whole, state, data, used, found)
        if count == _SILENT:
            continue
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
