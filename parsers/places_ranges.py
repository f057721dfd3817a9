"""A remote file as a raw stream that can seek: fetched in ranges, of which the last ones are kept.

What is read in jumps (an index at the end, one topic of many) costs a small block a jump; what is read on and on is
fetched ahead in ever larger ranges. All streams of one file share what is kept, and no range is fetched by two threads.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from threading import Condition
from typing import TYPE_CHECKING

from parsers.placed_stream import PlacedStream

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

BLOCK_BYTES = 16 << 10
"""Fetched is always from a multiple of this to another."""

JUMP_BLOCKS = 2
"""What is fetched at least: few bytes beyond those that a jump wants, and often enough for all that it wants."""

AHEAD_BYTES = 4 << 20
"""The most that is fetched ahead of a reader: then a store's latency is small against the time for the bytes."""

SMALL_BYTES = 512 << 10
"""A file of no more is fetched with one request."""

KEPT_BYTES = 32 << 20
_SURE_BLOCKS = 8
"""Whoever was given so many blocks in a row is taken for one that goes on to the end."""
_STREAMS = 64


class Ranges:
    """The bytes of one file of known size. fetch(start, stop) gives bytes [start, stop); requests, fetched: so far."""

    def __init__(self, size: int, fetch: Callable[[int, int], bytes]) -> None:
        self.size = size
        self.requests = 0
        self.fetched = 0
        self._fetch = fetch
        self._kept: OrderedDict[int, memoryview] = OrderedDict()
        self._coming: set[int] = set()
        # where a reader that goes on and on will ask next -> how many blocks it was given last
        self._streams: OrderedDict[int, int] = OrderedDict()
        self._changed = Condition()

    def read_into(self, at: int, out: memoryview) -> int:
        """Fill `out` from byte `at`; how many bytes there were. Raises OSError."""
        end = min(at + len(out), self.size)
        done = 0
        while at + done < end:
            index = (at + done) // BLOCK_BYTES
            block = self._block(index, (end - 1) // BLOCK_BYTES)
            begin = at + done - index * BLOCK_BYTES
            part = block[begin : begin + end - at - done]
            out[done : done + len(part)] = part
            done += len(part)
        return done

    def forget(self) -> None:
        """Let go of what is kept."""
        with self._changed:
            self._kept.clear()
            self._streams.clear()

    def _block(self, index: int, last: int) -> memoryview:
        """A block; where it has to be fetched, those up to `last` with it."""
        with self._changed:
            while index not in self._kept:
                if index not in self._coming:
                    blocks = self._plan(index, last)
                    self._coming.update(blocks)
                    break
                self._changed.wait()
            else:
                self._kept.move_to_end(index)
                return self._kept[index]
        data = b""
        try:
            data = self._fetch(index * BLOCK_BYTES, min(blocks.stop * BLOCK_BYTES, self.size))
        finally:
            with self._changed:
                self._coming.difference_update(blocks)
                if data:
                    self._keep(blocks, memoryview(data))
                self._changed.notify_all()
        return memoryview(data)[:BLOCK_BYTES]

    def _plan(self, index: int, last: int) -> range:
        """Which blocks to fetch with this one."""
        total = -(-self.size // BLOCK_BYTES)
        if self.size <= SMALL_BYTES:
            count = total - index
        else:
            before = self._streams.pop(index, 0)
            ahead = before * (2 if before < _SURE_BLOCKS else 4)
            count = max(last - index + 1, min(ahead, AHEAD_BYTES // BLOCK_BYTES), JUMP_BLOCKS)
        # what is wanted may be more than is kept: the reader asks again for the rest
        stop = min(index + min(count, KEPT_BYTES // BLOCK_BYTES // 2), total)
        for k in range(index + 1, stop):
            if k in self._kept or k in self._coming:
                stop = k
                break
        self._streams[stop] = stop - index
        if len(self._streams) > _STREAMS:
            self._streams.popitem(last=False)
        return range(index, stop)

    def _keep(self, blocks: range, data: memoryview) -> None:
        self.requests += 1
        self.fetched += len(data)
        for place, index in enumerate(blocks):
            # a copy: a block must not hold the whole range in memory
            self._kept[index] = memoryview(bytes(data[place * BLOCK_BYTES : (place + 1) * BLOCK_BYTES]))
        while len(self._kept) > KEPT_BYTES // BLOCK_BYTES:
            self._kept.popitem(last=False)


class RangeFile(PlacedStream):
    """A stream over `Ranges`."""

    def __init__(self, ranges: Ranges) -> None:
        super().__init__()
        self._ranges = ranges

    def length(self) -> int:
        """As the store said; nothing is fetched."""
        return self._ranges.size

    def readinto(self, buffer: WriteableBuffer) -> int:
        """Fill the buffer, short only at the end of the file. Raises OSError."""
        self._checkClosed()
        with memoryview(buffer) as view:
            got = self._ranges.read_into(self._at, view.cast("B"))
        self._at += got
        return got

    def readall(self) -> bytes:
        """All that follows. Raises OSError."""
        out = bytearray(max(0, self._ranges.size - self._at))
        del out[self.readinto(out) :]
        return bytes(out)
