"""A Parquet file behind a URL as a file of this disk of which only the parts that are read have been filled.

polars reads files of a disk, or those of a few stores by a client of its own with other credentials. Here its reader gets a
file of the right size, empty but for the table of contents and the columns that are asked for: the rest of it is a hole,
which takes no room on the disk. Source: the Parquet format, https://parquet.apache.org/docs/file-format/ (FileMetaData,
RowGroup, ColumnChunk, ColumnMetaData), written in the compact protocol of Apache Thrift.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parsers.errors import LogError
from parsers.parallel import in_order
from parsers.parquet_thrift_read import THRIFT_DAMAGE, ThriftReader
from parsers.ros.bag2_files import Scratch

if TYPE_CHECKING:
    from parsers.places_path import RemotePath

_MOST_FOOTER = 256 << 20
_NEAR_BYTES = 64 << 10
"""Parts with less between them are fetched as one: a request costs more than so many bytes."""
_PART_BYTES = 8 << 20


@dataclass(frozen=True)
class ColumnPart:
    """Where a column lies within a group of rows. column: its name at the top level."""

    column: str
    rows_before: int
    start: int
    stop: int


def column_parts(footer: bytes, size: int) -> list[ColumnPart]:
    """Where each column lies, by the table of contents (without its length). Raises ValueError where it is damaged."""
    try:
        return list(_column_parts(ThriftReader(footer).struct(), size))
    except THRIFT_DAMAGE as error:
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
