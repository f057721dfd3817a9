"""The objects inside a BLF file's containers, read one by one by compiled kernels. `parsers.blf_walk` walks them.

Layouts as in the public Vector BLF descriptions: each object starts with "LOBJ", u16 header size, u16 header
version, u32 object size, u32 object type; then flags, a stamp and the type's own fields. Little-endian throughout.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, load_u16, load_u32

LOG_CONTAINER = 10
MAX_CAN_OBJECT = 4096
MAX_OBJECT = 4 << 20
NO_TIME = -(1 << 62)
MARK = 0x4A424F4C
USUAL_HEAD = 0x00010020
"""Header of 32 bytes, version 1: what nearly all objects have."""

# places in the kernels' state vector; MORE: the walk ended because there was no more room for frames
(
    POS, FRAMES, MORE, REMOTE, ERRORS, OTHERS, BAD, LOST, BAD_TIME, SEARCHING, GAP_OPEN, GAPS, LAST_TIME
) = range(13)  # fmt: skip
STATE_SIZE = 13


@kernel
def _is_mark(buffer: ByteArray, at: int, end: int) -> bool:
    """Whether "LOBJ" stands at a place."""
    return at + 4 <= end and load_u32(buffer, at) == MARK


@kernel
def _near_mark(buffer: ByteArray, pos: int, end: int) -> int:
    """The next "LOBJ" within the padding of an object (at most 7 bytes), or -1."""
    for at in range(pos, pos + 8):
        if _is_mark(buffer, at, end):
            return at
    return -1


@kernel
def _is_can(kind: int) -> bool:
    return kind in (1, 86, 100, 101)


@kernel
def _plausible(buffer: ByteArray, at: int) -> bool:
    """Whether the 16 bytes at a mark can be an object's header."""
    head, size, kind = load_u16(buffer, at + 4), load_u32(buffer, at + 8), load_u32(buffer, at + 12)
    if head < 16 or size < head:
        return False
    return size <= (MAX_CAN_OBJECT if _is_can(kind) else MAX_OBJECT)


@kernel
def first_object(buffer: ByteArray, start: int, end: int) -> int:
    """The next object that is followed by another one (a payload may hold the letters LOBJ too), or -1."""
    for at in range(start, end - 15):
        if not _is_mark(buffer, at, end) or not _plausible(buffer, at):
            continue
        if load_u16(buffer, at + 4) > 64 or load_u16(buffer, at + 6) > 2:
            continue
        after = at + load_u32(buffer, at + 8)
        if after + 8 > end or _near_mark(buffer, after, end) >= 0:
            return at
    return -1


@kernel
def _fields(buffer: ByteArray, at: int, kind: int, found: IntArray) -> bool:
    """Read one CAN object: found = channel, id, flags of a remote frame, length, where its data begin and end.

    Returns False where the object is too short for its own fields.
    """
    size, head = load_u32(buffer, at + 8), load_u16(buffer, at + 4)
    body, stop = at + head, at + size
    if kind == 101:
        if body + 40 > stop:
            return False
        found[0], found[3], found[1] = buffer[body], buffer[body + 2], load_u32(buffer, body + 4)
        found[2] = 1 if load_u32(buffer, body + 12) & 0x10 else 0
        found[4] = body + 40
        extra = int(np.int64(buffer[body + 35]))
        found[5] = at + extra if body + 40 <= at + extra <= stop else stop
        return True
    need = 20 if kind == 100 else 8
    if body + need > stop:
        return False
    found[0], found[1] = load_u16(buffer, body), load_u32(buffer, body + 4)
    found[2] = 1 if buffer[body + 2] & 0x80 else 0
    if kind == 100:
        found[3], found[4] = buffer[body + 14], body + 20
    else:
        found[3], found[4] = min(int(np.int64(buffer[body + 3])), 8), body + 8
    found[5] = stop
    return True


@kernel
def _stamp(buffer: ByteArray, at: int, start_ns: int) -> int:
    """An object's absolute stamp in ns, or NO_TIME where it is beyond any clock (292 years)."""
    high = load_u32(buffer, at + 28)
    if high >= 0x2000_0000:
        return NO_TIME
    ticks = load_u32(buffer, at + 24) | (high << 32)
    if load_u32(buffer, at + 16) == 1:
        if ticks > (1 << 61) // 10_000:
            return NO_TIME
        ticks *= 10_000
    return start_ns + ticks


@kernel
def next_object(buffer: ByteArray, end: int, state: IntArray) -> int:
    """Where the next plausible object begins, at or after state[POS]; -1 (and POS moved on) where more bytes are needed."""
    pos = state[POS]
    at = -1
    if not state[SEARCHING]:
        at = _near_mark(buffer, pos, end)
        if at < 0 and pos + 12 > end:
            return -1
        if at >= 0 and at + 16 > end:
            state[POS] = at
            return -1
        if at >= 0 and _plausible(buffer, at):
            return at
        state[BAD] += 1
    state[SEARCHING], state[GAP_OPEN] = 1, 1
    again = first_object(buffer, pos if at < 0 else at + 4, end)
    stop = max(pos, end - 15) if again < 0 else again
    state[LOST] += stop - pos
    state[POS] = stop
    if again >= 0:
        state[SEARCHING] = 0
    return again


@kernel
def accept(buffer: ByteArray, at: int, kind: int, start_ns: int, found: IntArray, state: IntArray) -> int:
    """The stamp of a data frame, whose fields are then in `found`; NO_TIME for anything else, which is tallied."""
    if not _is_can(kind):
        if kind in (2, 3, 73, 104):
            state[ERRORS] += 1
        else:
            state[OTHERS] += 1
        return NO_TIME
    known = load_u16(buffer, at + 6) in (1, 2) and load_u16(buffer, at + 4) >= 32
    if not known or not _fields(buffer, at, kind, found):
        state[BAD] += 1
        return NO_TIME
    if found[2]:
        state[REMOTE] += 1
        return NO_TIME
    stamp = _stamp(buffer, at, start_ns)
    if stamp == NO_TIME:
        state[BAD_TIME] += 1
    return stamp
