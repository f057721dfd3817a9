"""What the system and the C library do with memory that a log takes.

The first touch of fresh memory costs as many page faults as it has pages; over a log of a hundred MiB that can take as long
as decoding it, and two cores that do so wait for each other. So freed memory is used again, and columns that live on lie
together in slabs that the system backs with large pages, 512 times fewer.
"""

from __future__ import annotations

import contextlib
import ctypes
import threading
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray
from parsers.jit import kernel
from parsers.parallel import cores, in_order

T = TypeVar("T", bound=np.generic)

_LARGEST_KEPT = (32 << 20) - (1 << 16)
"""Just below the highest limit that glibc takes, its own header included, in bytes."""
_ARENA_MAX = -8
"""`M_ARENA_MAX` of glibc's malloc.h."""
LARGE_PAGE = 2 << 20
"""Bytes, on the processors that there are. Numpy asks for large pages from two of them on."""
SLAB_BYTES = 8 << 20
"""One of `Slabs`: with a few columns in it that somebody keeps, all of it stays."""
_LINE = 64
"""Bytes that a core reads at once: no two columns share them."""


def keep_freed_memory() -> None:
    """Teach the C library's allocator (glibc's) to use the memory of freed pieces of a log again.

    By default it hands blocks of more than 128 KiB back to the system at once, and every new one then costs as many page
    faults as it has pages, which can take longer than all else together. It raises its limit to the largest block that it
    has seen freed. Nothing is written to this one, so that it costs two system calls. And by default it keeps a store of
    freed memory for every thread, of which no other thread may take: two are enough here. Elsewhere it does nothing.
    """
    np.empty(_LARGEST_KEPT, np.uint8)
    with contextlib.suppress(AttributeError, OSError, TypeError):
        # not in musl's C library, nor in those of macOS and Windows
        ctypes.CDLL(None).mallopt(_ARENA_MAX, 2)


@kernel
def _touch(room: ByteArray, begin: int, end: int) -> None:
    """Write to every large page of [begin, end)."""
    for at in range(begin, end, LARGE_PAGE):
        room[at] = 0


class Slab:
    """Room for several columns, freed when the last of them is. What is never written to takes no memory.

    One thread at a time takes from it. Beyond its size, or where it is too small for large pages, columns get memory of
    their own.
    """

    def __init__(self, size: int) -> None:
        """size: bytes in all; `room_of` says how many a column takes."""
        self._room: ByteArray = np.empty(0, np.uint8)
        self._at = 0
        if size >= 2 * LARGE_PAGE:
            raw = np.empty(size + LARGE_PAGE, np.uint8)
            shift = -raw.ctypes.data % LARGE_PAGE
            self._room = raw[shift : shift + size]

    def touch(self) -> None:
        """Have the system give all of its large pages at once, of which each core asks for some. To be called before anything is put in.

        Two cores that come to a page for the first time at once both clear one, and one of the two is thrown away.
        """
        pages = self._room.size // LARGE_PAGE
        each = -(-pages // cores()) * LARGE_PAGE
        begins = range(0, self._room.size, each) if pages else ()
        for _ in in_order(
            lambda begin: _touch(self._room, begin, min(begin + each, self._room.size)), begins
        ):
            pass

    @property
    def left(self) -> int:
        """Bytes that nothing was put into yet."""
        return self._room.size - self._at

    @property
    def cells(self) -> FloatArray:
        """All of it as numbers of eight bytes."""
        return self._room[: self._room.size // 8 * 8].view(np.float64)

    def cell_of(self, values: FloatArray) -> int:
        """Where in `cells` a column begins that was taken from the slab; -1 for one with memory of its own."""
        if not self._room.size:
            return -1
        first, own = values.ctypes.data - self._room.ctypes.data, values.flags.c_contiguous
        return first // 8 if own and 0 <= first <= self._room.size - values.nbytes and first % 8 == 0 else -1

    def empty(self, count: int, kind: type[T]) -> NDArray[T]:
        """(count,) values of a kind, not written yet."""
        size = count * np.dtype(kind).itemsize
        begin, end = self._at, self._at + size
        if end > self._room.size:
            return np.empty(count, kind)
        self._at += room_of(size)
        return self._room[begin:end].view(kind)


@dataclass
class Slabs:
    """Room for columns without end, from one slab after the other. Any thread may take from it."""

    slab: Slab = field(default_factory=lambda: Slab(0))
    lock: threading.Lock = field(default_factory=threading.Lock)

    def cells(self, count: int) -> FloatArray:
        """(count,) numbers, not written yet."""
        if 8 * count > SLAB_BYTES // 2:
            return np.empty(count)
        with self.lock:
            if self.slab.left < 8 * count:
                self.slab = Slab(SLAB_BYTES)
            return self.slab.empty(count, np.float64)


def room_of(size: int) -> int:
    """The bytes that a column of so many takes of a slab."""
    return -(-size // _LINE) * _LINE
