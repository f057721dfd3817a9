"""The walk through a BLF file's inflated content: from objects to columns of CAN frames, by one compiled kernel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.allocator import Slab
from parsers.blf_objects import (
    FRAMES,
    GAP_OPEN,
    GAPS,
    LAST_TIME,
    MARK,
    MAX_CAN_OBJECT,
    MORE,
    NO_TIME,
    POS,
    SEARCHING,
    STATE_SIZE,
    USUAL_HEAD,
    accept,
    next_object,
)
from parsers.can.frames import CanFrames
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, load_u32, load_u64

FRONT = 4096
"""Bytes before a block's content, where the beginning of an object goes that the block before broke off."""
BEHIND = 1 << 16
"""Bytes at a buffer's end, for payloads that their writer left the last zeros out of."""
ROWS = 1 << 16
"""Most frames of a batch."""
COLUMNS_BYTES = 23 * ROWS
"""What the columns of a batch take."""
MAX_GAPS = 64

Bytes = bytes | bytearray | memoryview


@dataclass(frozen=True)
class Block:
    """A piece of the file. kind: "container" (inflated content), "raw" (objects outside a container),
    "damaged" or "cut". position, size: bytes in the file. What of it can be read is buffer[begin:end]; there are at least
    FRONT bytes before it that are not needed any more, and the buffer's last BEHIND bytes are not of it."""

    kind: str
    position: int
    size: int
    buffer: ByteArray
    begin: int = FRONT
    end: int = FRONT


NOTHING: ByteArray = np.zeros(FRONT + BEHIND, np.uint8)


def block_of(kind: str, position: int, size: int, *content: Bytes) -> Block:
    """A block that holds these bytes."""
    if not any(content):
        return Block(kind, position, size, NOTHING)
    buffer = np.frombuffer(b"".join((bytes(FRONT), *content, bytes(BEHIND))), np.uint8)
    return Block(kind, position, size, buffer.copy(), FRONT, buffer.size - BEHIND)


@kernel
def _usual_step(buffer: ByteArray, pos: int, end: int) -> int:
    """The size of the object at `pos` where it is of the usual sort: CAN_MESSAGE, CAN_MESSAGE2 or CAN_FD_MESSAGE; else 0."""
    if pos + 52 > end or load_u32(buffer, pos) != MARK or load_u32(buffer, pos + 4) != USUAL_HEAD:
        return 0
    size, kind = load_u32(buffer, pos + 8), load_u32(buffer, pos + 12)
    if size > MAX_CAN_OBJECT or (kind != 100 and ((kind != 1 and kind != 86) or size < 48)) or size < 48:
        return 0
    return size if kind != 100 or size >= 52 else 0


@kernel
def _walk_alike(
    buffer: ByteArray,
    pos: int,
    end: int,
    start_ns: int,
    time_ns: IntArray,
    can_id: NDArray[np.uint32],
    bus: NDArray[np.int16],
    length: ByteArray,
    offset: IntArray,
    count: int,
) -> tuple[int, int]:
    """Read objects as long as they are of the usual sort and all alike. Returns where it ended, and the frames by then.

    The next object's place hangs on no byte of this one but the comparison, which lets the processor look ahead.
    """
    step = _usual_step(buffer, pos, end)
    if step == 0:
        return pos, count
    head, shape, flags = load_u64(buffer, pos), load_u64(buffer, pos + 8), load_u32(buffer, pos + 16)
    is_fd = load_u32(buffer, pos + 12) == 100
    first, room = (52, min(step - 52, 64)) if is_fd else (40, 8)
    size_at = 46 if is_fd else 35
    unit, limit = (10_000, (1 << 61) // 10_000 >> 32) if flags == 1 else (1, 0x2000_0000)
    while count < time_ns.size and pos + step <= end:
        if load_u64(buffer, pos) != head or load_u64(buffer, pos + 8) != shape:
            break
        word, high, size = (
            load_u32(buffer, pos + 32),
            load_u32(buffer, pos + 28),
            int(buffer[pos + size_at]),
        )
        if not is_fd:
            size = min(size, 8)
        if word & 0x0080_0000 or high >= limit or size > room or load_u32(buffer, pos + 16) != flags:
            break
        time_ns[count] = start_ns + unit * (load_u32(buffer, pos + 24) | (high << 32))
        can_id[count], bus[count] = load_u32(buffer, pos + 36) & 0x9FFFFFFF, word & 0x7FFF
        length[count], offset[count] = size, pos + first
        count += 1
        pos += step
    return pos, count


@kernel
def _close_gap(stamp: int, state: IntArray, gaps: IntArray) -> None:
    """The first frame after damage: note the stamps around it."""
    if state[GAPS] < gaps.shape[0]:
        gaps[state[GAPS], 0], gaps[state[GAPS], 1] = state[LAST_TIME], stamp
        state[GAPS] += 1
    state[GAP_OPEN] = 0


@kernel
def _payload(buffer: ByteArray, found: IntArray, spare: int) -> int:
    """Where a whole payload is: in its object, or at `spare` where the writer left out zeros at its end."""
    size = min(found[3], 64)
    if found[4] + size <= found[5]:
        return int(found[4])
    for k in range(size):
        buffer[spare + k] = buffer[found[4] + k] if found[4] + k < found[5] else 0
    return spare


@kernel
def walk_objects(
    buffer: ByteArray,
    end: int,
    start_ns: int,
    time_ns: IntArray,
    can_id: NDArray[np.uint32],
    bus: NDArray[np.int16],
    length: ByteArray,
    offset: IntArray,
    state: IntArray,
    gaps: IntArray,
) -> None:
    """Walk the objects in buffer[state[POS]:end]; one that goes on beyond the end is left for the next call.

    The last BEHIND bytes of the buffer may be written to. state: see POS ... LAST_TIME; POS is set to the first byte not used.
    gaps: (MAX_GAPS, 2) stamps before and after damage. A wrong object size never loops: every turn of the loop moves on,
    or ends.
    """
    count, spare = 0, buffer.size - BEHIND
    found = np.zeros(6, np.int64)
    state[MORE] = 0
    while True:
        if count >= time_ns.size or spare + 64 > buffer.size:
            state[MORE] = 1
            break
        if not state[SEARCHING] and not state[GAP_OPEN]:
            before = count
            state[POS], count = _walk_alike(
                buffer, state[POS], end, start_ns, time_ns, can_id, bus, length, offset, count
            )
            if count > before:
                state[LAST_TIME] = time_ns[count - 1]
                continue
        at = next_object(buffer, end, state)
        if at < 0:
            break
        size, kind = load_u32(buffer, at + 8), load_u32(buffer, at + 12)
        if at + size > end:
            state[POS] = at
            break
        state[POS] = at + size
        stamp = accept(buffer, at, kind, start_ns, found, state)
        if stamp == NO_TIME:
            continue
        if state[GAP_OPEN]:
            _close_gap(stamp, state, gaps)
        state[LAST_TIME] = stamp
        place = _payload(buffer, found, spare)
        spare += 64 if place == spare else 0
        time_ns[count], bus[count], offset[count] = stamp, found[0] & 0x7FFF, place
        can_id[count], length[count] = found[1] & 0x9FFFFFFF, min(int(found[3]), 64)
        count += 1
    state[FRAMES] = count


@dataclass(frozen=True)
class Columns:
    """Room for the frames of a batch, which is used again: see `CanFrames`. (ROWS,) each."""

    time_ns: IntArray
    can_id: NDArray[np.uint32]
    bus: NDArray[np.int16]
    length: ByteArray
    offset: IntArray

    @classmethod
    def of(cls, slab: Slab) -> Columns:
        """Columns that lie in a slab; they take COLUMNS_BYTES of it."""
        return cls(
            slab.empty(ROWS, np.int64),
            slab.empty(ROWS, np.uint32),
            slab.empty(ROWS, np.int16),
            slab.empty(ROWS, np.uint8),
            slab.empty(ROWS, np.int64),
        )

    def walk(self, buffer: ByteArray, end: int, start_ns: int, state: IntArray, gaps: IntArray) -> None:
        """`walk_objects` into these columns."""
        walk_objects(
            buffer, end, start_ns, self.time_ns, self.can_id, self.bus, self.length, self.offset, state, gaps
        )

    def frames(self, count: int, buffer: ByteArray) -> CanFrames:
        """The first frames."""
        return CanFrames(
            self.time_ns[:count],
            self.can_id[:count],
            self.bus[:count],
            self.length[:count],
            self.offset[:count],
            buffer,
        )


def fresh_state() -> IntArray:
    """The kernel's state at the beginning of a file."""
    state = np.zeros(STATE_SIZE, np.int64)
    state[LAST_TIME] = NO_TIME
    return state


def no_gaps() -> IntArray:
    """Room for the stamps around damage."""
    return np.zeros((MAX_GAPS, 2), np.int64)
