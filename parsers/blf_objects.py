"""The objects inside a BLF file's containers, walked by one compiled kernel into columns of CAN frames.

Layouts as in the public Vector BLF descriptions: each object starts with "LOBJ", u16 header size, u16 header
version, u32 object size, u32 object type; then flags, a stamp and the type's own fields. Little-endian throughout.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.can.frames import CanFrames
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel

LOG_CONTAINER = 10
MAX_CAN_OBJECT = 4096
MAX_OBJECT = 4 << 20
MIN_FRAME_OBJECT = 48
MAX_GAPS = 64
NO_TIME = -(1 << 62)

# places in the kernel's state vector
POS, FRAMES, USED, REMOTE, ERRORS, OTHERS, BAD, LOST, BAD_TIME, SEARCHING, GAP_OPEN, GAPS, LAST_TIME = range(
    13
)
STATE_SIZE = 13


@kernel
def _u16(buffer: ByteArray, at: int) -> int:
    return int(np.int64(buffer[at]) | (np.int64(buffer[at + 1]) << 8))


@kernel
def _u32(buffer: ByteArray, at: int) -> int:
    return _u16(buffer, at) | (_u16(buffer, at + 2) << 16)


@kernel
def _is_mark(buffer: ByteArray, at: int, end: int) -> bool:
    """Whether "LOBJ" stands at a place."""
    if at + 4 > end:
        return False
    return bool(buffer[at] == 76 and buffer[at + 1] == 79 and buffer[at + 2] == 66 and buffer[at + 3] == 74)


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
    head, size, kind = _u16(buffer, at + 4), _u32(buffer, at + 8), _u32(buffer, at + 12)
    if head < 16 or size < head:
        return False
    return size <= (MAX_CAN_OBJECT if _is_can(kind) else MAX_OBJECT)


@kernel
def _resync(buffer: ByteArray, start: int, end: int) -> int:
    """The next object that is followed by another one (a payload may hold the letters LOBJ too), or -1."""
    for at in range(start, end - 15):
        if not _is_mark(buffer, at, end) or not _plausible(buffer, at):
            continue
        if _u16(buffer, at + 4) > 64 or _u16(buffer, at + 6) > 2:
            continue
        after = at + _u32(buffer, at + 8)
        if after + 8 > end or _near_mark(buffer, after, end) >= 0:
            return at
    return -1


@kernel
def _fields(buffer: ByteArray, at: int, kind: int, found: IntArray) -> bool:
    """Read one CAN object: found = channel, id, flags of a remote frame, length, where its data begin and end.

    Returns False where the object is too short for its own fields.
    """
    size, head = _u32(buffer, at + 8), _u16(buffer, at + 4)
    body, stop = at + head, at + size
    if kind == 101:
        if body + 40 > stop:
            return False
        found[0], found[3], found[1] = buffer[body], buffer[body + 2], _u32(buffer, body + 4)
        found[2] = 1 if _u32(buffer, body + 12) & 0x10 else 0
        found[4] = body + 40
        extra = int(np.int64(buffer[body + 35]))
        found[5] = at + extra if body + 40 <= at + extra <= stop else stop
        return True
    need = 20 if kind == 100 else 8
    if body + need > stop:
        return False
    found[0], found[1] = _u16(buffer, body), _u32(buffer, body + 4)
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
    for high in range(at + 28, at + 32):
        if high == at + 31 and buffer[high] >= 0x20:
            return NO_TIME
    ticks = _u32(buffer, at + 24) | (_u32(buffer, at + 28) << 32)
    if _u32(buffer, at + 16) == 1:
        if ticks > (1 << 61) // 10_000:
            return NO_TIME
        ticks *= 10_000
    return start_ns + ticks


@kernel
def _next_object(buffer: ByteArray, end: int, state: IntArray) -> int:
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
    again = _resync(buffer, pos if at < 0 else at + 4, end)
    stop = max(pos, end - 15) if again < 0 else again
    state[LOST] += stop - pos
    state[POS] = stop
    if again >= 0:
        state[SEARCHING] = 0
    return again


@kernel
def _accept(buffer: ByteArray, at: int, kind: int, start_ns: int, found: IntArray, state: IntArray) -> int:
    """The stamp of a data frame, whose fields are then in `found`; NO_TIME for anything else, which is tallied."""
    if not _is_can(kind):
        if kind in (2, 3, 73, 104):
            state[ERRORS] += 1
        else:
            state[OTHERS] += 1
        return NO_TIME
    known = _u16(buffer, at + 6) in (1, 2) and _u16(buffer, at + 4) >= 32
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


@kernel
def walk_objects(
    buffer: ByteArray,
    begin: int,
    start_ns: int,
    time_ns: IntArray,
    can_id: NDArray[np.uint32],
    bus: NDArray[np.int16],
    length: NDArray[np.uint8],
    offset: IntArray,
    data: ByteArray,
    state: IntArray,
    gaps: IntArray,
) -> None:
    """Walk the objects of an inflated buffer; an object that goes on beyond the buffer is left for the next call.

    state: see POS ... LAST_TIME; POS is set to the first byte not used. gaps: (MAX_GAPS, 2) stamps before and
    after damage. A wrong object size never loops: every turn of the loop moves on, or ends.
    """
    end, count, used = buffer.shape[0], 0, 0
    found = np.zeros(6, np.int64)
    state[POS] = begin
    while True:
        at = _next_object(buffer, end, state)
        if at < 0:
            break
        size, kind = _u32(buffer, at + 8), _u32(buffer, at + 12)
        if at + size > end:
            state[POS] = at
            break
        state[POS] = at + size
        stamp = _accept(buffer, at, kind, start_ns, found, state)
        if stamp == NO_TIME or count >= time_ns.shape[0] or used + 64 > data.shape[0]:
            continue
        if state[GAP_OPEN]:
            if state[GAPS] < gaps.shape[0]:
                gaps[state[GAPS], 0], gaps[state[GAPS], 1] = state[LAST_TIME], stamp
                state[GAPS] += 1
            state[GAP_OPEN] = 0
        state[LAST_TIME] = stamp
        take = min(found[3], 64)
        time_ns[count], bus[count], offset[count] = stamp, found[0] & 0x7FFF, used
        can_id[count], length[count] = found[1] & 0x9FFFFFFF, take
        for k in range(take):
            # writers may leave out trailing zeros: a frame is as long as it says
            data[used + k] = buffer[found[4] + k] if found[4] + k < found[5] else 0
        used += take
        count += 1
    state[FRAMES], state[USED] = count, used


@dataclass
class ObjectWalker:
    """Buffers in, frames out; keeps the piece of an object that straddles two buffers, and the tallies.

    start_ns: added to every stamp. state: the kernel's tallies, read after the last buffer.
    """

    start_ns: int
    state: IntArray
    gaps: IntArray
    tail: bytes = b""

    @classmethod
    def starting_at(cls, start_ns: int) -> ObjectWalker:
        """A walker at the beginning of a file."""
        state = np.zeros(STATE_SIZE, np.int64)
        state[LAST_TIME] = NO_TIME
        return cls(start_ns, state, np.zeros((MAX_GAPS, 2), np.int64))

    def lose(self, size: int) -> None:
        """A block of `size` bytes could not be read: what straddles it is lost too, and the next object is searched."""
        self.state[LOST] += size + len(self.tail)
        self.tail = b""
        self.state[SEARCHING] = self.state[GAP_OPEN] = 1

    def walk(self, block: bytes) -> CanFrames:
        """The frames that end in this block."""
        buffer = np.frombuffer(self.tail + block, np.uint8)
        room = buffer.size // MIN_FRAME_OBJECT + 1
        time_ns, offset = np.empty(room, np.int64), np.empty(room, np.int64)
        can_id, bus = np.empty(room, np.uint32), np.empty(room, np.int16)
        length, data = np.empty(room, np.uint8), np.empty(room * 64 + 64, np.uint8)
        walk_objects(
            buffer, 0, self.start_ns, time_ns, can_id, bus, length, offset, data, self.state, self.gaps
        )
        count = int(self.state[FRAMES])
        self.tail = buffer[int(self.state[POS]) :].tobytes()
        payload = data[: int(self.state[USED])].copy()
        return CanFrames(
            time_ns[:count], can_id[:count], bus[:count], length[:count], offset[:count], payload
        )

    def walk_pieces(self, blocks: list[bytes], size: int) -> Iterator[CanFrames]:
        """The frames of several blocks, about `size` bytes at a time however large a block is."""
        joined = b"".join(blocks)
        for begin in range(0, len(joined), size):
            yield self.walk(joined[begin : begin + size])
