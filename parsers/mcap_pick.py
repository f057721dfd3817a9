"""The messages of the wanted channels among the records of a chunk, topic by topic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel, load_u16, load_u64
from parsers.mcap_records import (
    DATA_END,
    MESSAGE,
    MESSAGE_HEAD,
    RECORD_HEAD,
    WALK_CUT,
    WALK_DATA_END,
    WALK_DONE,
    WALK_INVALID,
)

Slots = NDArray[np.int32]
CHANNEL_IDS = 1 << 16
LEAST = RECORD_HEAD + MESSAGE_HEAD
"""Bytes of the shortest message's record."""
SLOT, LOG, OFFSET, LENGTH = range(4)
"""Rows of the table of picked messages."""


@lean_kernel
def signed(bits: int) -> int:
    """The same bits as int64."""
    return np.int64(bits)  # type: ignore[return-value]


@kernel
def pick(
    data: ByteArray, start: int, end: int, slot_of: Slots, picked: IntArray, count: int
) -> tuple[int, int, int, int]:
    """Add the wanted messages among the records of data[start:end] to picked[:, count:].

    Returns how many are picked now, where the walk stopped and why (WALK_…), and how many message records were too
    short to be one. `picked` must have room for a message every LEAST bytes.
    """
    at, short = start, 0
    while at < end:
        op = data[at]
        if op == 0:
            return count, at, WALK_INVALID, short
        left = end - at - RECORD_HEAD
        if left < 0:
            return count, at, WALK_CUT, short
        size = signed(load_u64(data, at + 1))
        if size < 0 or size > left:
            return count, at, WALK_CUT, short
        content = at + RECORD_HEAD
        at = content + size
        if op == MESSAGE:
            if size < MESSAGE_HEAD:
                short += 1
                continue
            slot = slot_of[load_u16(data, content)]
            if slot >= 0:
                picked[SLOT, count] = slot
                picked[LOG, count] = signed(load_u64(data, content + 6))
                picked[OFFSET, count] = content + MESSAGE_HEAD
                picked[LENGTH, count] = size - MESSAGE_HEAD
                count += 1
        elif op == DATA_END:
            return count, at, WALK_DATA_END, short
    return count, at, WALK_DONE, short


@kernel
def _sort(picked: IntArray, count: int, first: IntArray, out: IntArray) -> None:
    """Put the messages of one slot behind one another, in their order: out (3, count) is log time, offset, length.

    first: shape (slots + 2,), zero; slot s is out[:, first[s] : first[s + 1]] afterwards.
    """
    for i in range(count):
        first[picked[SLOT, i] + 2] += 1
    for s in range(2, first.size):
        first[s] += first[s - 1]
    for i in range(count):
        slot = picked[SLOT, i] + 1
        place = first[slot]
        first[slot] = place + 1
        out[0, place] = picked[LOG, i]
        out[1, place] = picked[OFFSET, i]
        out[2, place] = picked[LENGTH, i]


@dataclass(frozen=True)
class Picks:
    """Messages of one topic in a buffer: shape (n,) each. The arrays are scratch: valid until the next batch."""

    number: int
    log_ns: IntArray
    offset: IntArray
    length: IntArray


class Picker:
    """Collects the wanted messages of one batch after the other; belongs to one thread.

    slot_of: for each channel id the number of its topic, -1 where it is not wanted. topics: how many there are. picked, count:
    the table for `pick`, and how much of it is filled.
    """

    def __init__(self, slot_of: Slots, topics: int) -> None:
        self._slot_of, self._topics = slot_of, topics
        self.picked: IntArray = np.empty((4, 0), dtype=np.int64)
        self._sorted: IntArray = np.empty((3, 0), dtype=np.int64)
        self.count = 0

    def walk(self, data: ByteArray, start: int, end: int) -> tuple[int, int, int]:
        """Collect from the records in data[start:end]; returns where and why it stopped, and how many were too short."""
        if not 0 <= start <= end <= data.size:
            raise ValueError("records outside of the buffer")
        self.make_room(end - start)
        self.count, at, state, short = pick(data, start, end, self._slot_of, self.picked, self.count)
        return at, state, short

    def mark(self) -> int:
        """How much is collected, for `rewind`."""
        return self.count

    def rewind(self, mark: int) -> None:
        """Forget what was collected since the mark."""
        self.count = mark

    def take(self) -> list[Picks]:
        """What was collected, by topic; then it starts anew."""
        count, self.count = self.count, 0
        if self._sorted.shape[1] < count:
            self._sorted = np.empty((3, count + count // 4), dtype=np.int64)
        first = np.zeros(self._topics + 2, dtype=np.int64)
        _sort(self.picked, count, first, self._sorted)
        log_ns, offset, length = self._sorted
        bounds = first.tolist()
        parts = [(slot, slice(bounds[slot], bounds[slot + 1])) for slot in range(self._topics)]
        return [Picks(slot, log_ns[p], offset[p], length[p]) for slot, p in parts if p.start < p.stop]

    def make_room(self, size: int) -> None:
        """Make room for the messages of so many bytes of records."""
        rows = self.count + size // LEAST
        if self.picked.shape[1] < rows:
            larger = np.empty((4, rows + rows // 4), dtype=np.int64)
            larger[:, : self.count] = self.picked[:, : self.count]
            self.picked = larger


def slot_table(topics: list[tuple[int, ...]]) -> Slots:
    """The table of a `Picker` from the channel ids of each topic."""
    slot_of = np.full(CHANNEL_IDS, -1, dtype=np.int32)
    for number, ids in enumerate(topics):
        slot_of[list(ids)] = number
    return slot_of
