"""Memory for the records of a run and the columns of its frames, used again for the next run.

Fresh memory costs more than what is done with it: two cores that take it for each run wait for each other's page faults.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from parsers.allocator import Slab, room_of
from parsers.channels import ByteArray, IntArray

_ROW_BYTES = 8 + 4 + 2 + 1 + 8
_COLUMNS = 5


@dataclass(frozen=True)
class FrameRoom:
    """Room for a run. data: its records. The others: columns as in `FrameColumns`, of as many rows as a run can have.

    packed, turned: for compressed blocks as they are in the file, and inflated but not yet turned back into records.
    """

    data: ByteArray
    time_ns: IntArray
    can_id: NDArray[np.uint32]
    bus: NDArray[np.int16]
    length: NDArray[np.uint8]
    offset: IntArray
    packed: ByteArray
    turned: ByteArray

    @classmethod
    def of(cls, size: int, rows: int, packed: int = 0, turned: int = 0) -> FrameRoom:
        """size: bytes of the largest run. packed, turned: of the largest block, 0 where there is none."""
        slab = Slab(sum(map(room_of, (size, packed, turned))) + _ROW_BYTES * rows + _COLUMNS * room_of(1))
        return cls(
            slab.empty(size, np.uint8),
            slab.empty(rows, np.int64),
            slab.empty(rows, np.uint32),
            slab.empty(rows, np.int16),
            slab.empty(rows, np.uint8),
            slab.empty(rows, np.int64),
            slab.empty(packed, np.uint8),
            slab.empty(turned, np.uint8),
        )


@dataclass(frozen=True)
class FrameRooms:
    """Rooms of one size. Any thread may take one and give it back."""

    size: int
    rows: int
    packed: int = 0
    turned: int = 0
    _free: deque[FrameRoom] = field(default_factory=deque)

    def take(self) -> FrameRoom:
        """One that nobody uses."""
        try:
            return self._free.pop()
        except IndexError:
            return FrameRoom.of(self.size, self.rows, self.packed, self.turned)

    def give(self, room: FrameRoom) -> None:
        """Have it used again."""
        self._free.append(room)
