"""What readers of records hand on: rows of one group, and the variable-length records that go with them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.mf4.invalidation import BitSource
from parsers.mf4.model import Group


@dataclass(frozen=True)
class Window:
    """A piece of the records of variable length (VLSD group): u32 length and bytes, one after the other.

    base: place of data[0] in all of them. starts: place of each record in this window, numbered from first.
    lost: the file was damaged before, so that no place is certain any more.
    """

    base: int
    data: ByteArray
    first: int
    starts: IntArray
    lost: bool = False

    @property
    def end(self) -> int:
        """Place behind the window's last byte."""
        return self.base + self.data.size

    def behind(self, place: int) -> Window:
        """Without the records that begin before a place."""
        skip = int(np.searchsorted(self.starts, place))
        base = int(self.starts[skip]) if skip < self.starts.size else self.end
        return Window(base, self.data[base - self.base :], self.first + skip, self.starts[skip:])


EMPTY = Window(0, np.zeros(0, np.uint8), 0, np.zeros(0, np.int64))


@dataclass(frozen=True)
class Batch:
    """Records of one group, one every `stride` bytes of `data` (contiguous, at least count * stride bytes).

    first: number of the first. skip: bytes of each that are no record (its id). windows: by the VLSD group's place.
    bits: where the invalidation bytes are, if they are not in the records.
    """

    group: Group
    first: int
    data: ByteArray
    count: int
    stride: int
    skip: int = 0
    windows: dict[int, Window] = field(default_factory=dict)
    file_at: int = 0
    bits: BitSource | None = None

    @property
    def rows(self) -> ByteArray:
        """The records, shape (count, record bytes): a view."""
        return self.data[: self.count * self.stride].reshape(self.count, self.stride)[:, self.skip :]

    def invalid_rows(self) -> ByteArray:
        """The records' invalidation bytes, shape (count, bytes)."""
        if self.bits is not None:
            return self.bits.rows(self.first, self.count)
        return self.rows[:, self.group.invalid_at :]

    def with_data(self, data: ByteArray) -> Batch:
        """The same records, now with their bytes."""
        return replace(self, data=data)

    def part(self, begin: int, end: int) -> Batch:
        """The records from begin to end (a view)."""
        data = self.data[begin * self.stride : end * self.stride]
        return replace(self, first=self.first + begin, data=data, count=end - begin)
