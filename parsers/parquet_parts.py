"""A Parquet file behind a URL as a file of this disk of which only the parts that are read have been filled.

polars reads files of a disk, or those of a few stores by a client of its own with other credentials. Here its reader gets a
file of the right size, empty but for the table of contents and the columns that are asked for: the rest of it is a hole,
which takes no room on the disk. Source: the Parquet format, https://parquet.apache.org/docs/file-format/ (FileMetaData,
RowGroup, ColumnChunk, ColumnMetaData), written in the compact protocol of Apache Thrift.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parsers.errors import LogError
from parsers.parallel import in_order
from parsers.ros.bag2_files import Scratch

if TYPE_CHECKING:
    from parsers.places_path import RemotePath

_MOST_FOOTER = 256 << 20
_DEEPEST = 32
_NEAR_BYTES = 64 << 10
"""Parts with less between them are fetched as one: a request costs more than so many bytes."""
_PART_BYTES = 8 << 20
_DAMAGE = (IndexError, struct.error, KeyError, TypeError, ValueError)


@dataclass(frozen=True)
class ColumnPart:
    """Where a column lies within a group of rows. column: its name at the top level."""

    column: str
    rows_before: int
    start: int
    stop: int


class _Thrift:
    """Reads structures of the compact protocol as {field number: value}; a list as a list."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def struct(self, depth: int = 0) -> dict[int, Any]:
        """The structure that begins here. Raises ValueError, IndexError, struct.error where there is none."""
        if depth > _DEEPEST:
            raise ValueError("nested too deeply")
        found: dict[int, Any] = {}
        field = 0
        while head := self._byte():
            field = field + (head >> 4) if head >> 4 else self._signed()
            found[field] = self._value(head & 15, depth)
        return found

    def _value(self, kind: int, depth: int) -> Any:
        if kind in (1, 2):
            return kind == 1
        if kind == 3:
            return self._byte()
        if kind in (4, 5, 6):
            return self._signed()
        if kind == 7:
            self._at += 8
            return struct.unpack_from("<d", self._data, self._at - 8)[0]
        if kind == 8:
            size = self._varint()
            self._at += size
            return self._data[self._at - size : self._at]
        if kind in (9, 10):
            return self._list(depth)
        if kind == 12:
            return self.struct(depth + 1)
        raise ValueError(f"a value of the unknown kind {kind}")

    def _list(self, depth: int) -> list[Any]:
        head = self._byte()
        size = head >> 4 if head >> 4 < 15 else self._varint()
        if size > len(self._data) - self._at:
            raise ValueError("a list longer than the file")
        kind = head & 15
        # in a list a truth value has a byte of its own
        return [self._byte() == 1 if kind in (1, 2) else self._value(kind, depth) for _ in range(size)]

    def _byte(self) -> int:
        self._at += 1
        return self._data[self._at - 1]

    def _varint(self) -> int:
        value = shift = 0
        while True:
            byte = self._byte()
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def _signed(self) -> int:
        value = self._varint()
        return (value >> 1) ^ -(value & 1)


def column_parts(footer: bytes, size: int) -> list[ColumnPart]:
    """Where each column lies, by the table of contents (without its length). Raises ValueError where it is damaged."""
    try:
        return list(_column_parts(_Thrift(footer).struct(), size))
    except _DAMAGE as error:
        raise ValueError("its table of contents is damaged") from error


def _column_parts(contents: dict[int, Any], size: int) -> Iterator[ColumnPart]:
    rows = 0
    for group in contents[4]:
        for chunk in group[1]:
            told = chunk[3]
            # the dictionary, where there is one, stands before the data
            start = min(told[9], told.get(11) or told[9])
            stop = start + told[7]
            if not 0 < start <= stop <= size:
                raise ValueError("a column lies outside of the file")
            yield ColumnPart(told[3][0].decode("utf-8"), rows, start, stop)
        rows += group[3]


class PartlyFilled:
    """A file of this disk, filled as far as it was asked for; removed with this object. path: for polars to scan."""

    def __init__(self, far: RemotePath) -> None:
        """Fetch the table of contents. Raises OSError; LogError where it is damaged."""
        self._far = far
        self._size = far.facts().size
        self._scratch = Scratch()
        self._filled: set[tuple[int, int]] = set()
        self.path = self._scratch.place(far.name, 0)
        with self.path.open("wb") as file:
            file.truncate(self._size)
        tail = far.part(max(0, self._size - _NEAR_BYTES), self._size)
        length = int.from_bytes(tail[-8:-4], "little")
        begin = self._size - 8 - length
        if begin < 4 or length > _MOST_FOOTER:
            raise LogError("the Parquet file is damaged (no table of contents)", path=Path(far.name))
        if length + 8 > len(tail):
            tail = far.part(begin, self._size)
        self._put(0, b"PAR1")
        self._put(self._size - len(tail), tail)
        self._parts = column_parts(tail[-8 - length : -8], self._size)

    def fill(self, columns: Collection[str], rows: int | None = None) -> None:
        """Fetch columns, of the groups with the first `rows` rows or of all. Raises OSError, LogError (no room)."""
        spans = [
            (part.start, part.stop)
            for part in self._parts
            if part.column in columns and (rows is None or part.rows_before < rows)
        ]
        new = sorted(set(spans) - self._filled)
        self._scratch.place(self.path.name, sum(stop - start for start, stop in new))
        for start, data in in_order(self._fetched, _joined(new)):
            self._put(start, data)
        self._filled.update(new)

    def _fetched(self, span: tuple[int, int]) -> tuple[int, bytes]:
        return span[0], self._far.part(*span)

    def _put(self, at: int, data: bytes) -> None:
        with self.path.open("r+b") as file:
            file.seek(at)
            file.write(data)


def _joined(spans: Sequence[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Spans, in order, as what to fetch: those near each other as one, long ones in parts."""
    at = 0
    while at < len(spans):
        start, stop = spans[at]
        at += 1
        while at < len(spans) and spans[at][0] - stop < _NEAR_BYTES:
            stop = max(stop, spans[at][1])
            at += 1
        for begin in range(start, stop, _PART_BYTES):
            yield begin, min(begin + _PART_BYTES, stop)
