"""Memory for threads that read a log: used again and again, or taken in large pieces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.allocator import Slabs
from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.lz4_frames import FrameUnpacker


@dataclass
class Scratch:
    """What one thread needs while it reads: bytes of the file, and where in them the messages are (2, rows).

    unpacked: of a compressed chunk; good until the next is asked for.
    """

    raw: bytearray = field(default_factory=bytearray)
    places: IntArray = field(default_factory=lambda: np.empty((2, 0), dtype=np.int64))
    unpacked: ByteArray = field(default_factory=lambda: np.empty(0, dtype=np.uint8))
    frames: FrameUnpacker = field(default_factory=FrameUnpacker)

    def room(self, size: int) -> ByteArray:
        """`size` bytes for an unpacked chunk; the one before is gone."""
        if self.unpacked.size < size:
            self.unpacked = np.empty(size + size // 4, dtype=np.uint8)
        return self.unpacked[:size]


@dataclass
class Memory:
    """Memory for all threads. Fresh memory costs as much as what is read into it: the system clears it page by page.

    So scratch is used again and again, and columns are cut from slabs with large pages.
    """

    free: list[Scratch] = field(default_factory=list)
    slabs: Slabs = field(default_factory=Slabs)

    def scratch(self) -> Scratch:
        """Scratch of any size; append it to `free` afterwards."""
        try:
            return self.free.pop()
        except IndexError:  # more threads than scratches so far
            return Scratch()

    def cells(self, count: int) -> FloatArray:
        """Room for so many numbers, with anything in it."""
        return self.slabs.cells(count)
