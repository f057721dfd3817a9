"""Writes tables of numbers as Parquet files, a group of rows at a time; the columns are packed on all cores.

A library for it takes longer to load than reading a log and writing its tables does. Source: the Parquet format,
https://parquet.apache.org/docs/file-format/metadata/ (FileMetaData, SchemaElement, RowGroup, ColumnMetaData, Statistics).
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import TracebackType

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.parallel import cores, in_order
from parsers.parquet_pages import DOUBLE, INT64, RLE, PackedColumn, pack_column
from parsers.parquet_thrift import BINARY, I32, I64, LIST, Thrift

Column = IntArray | FloatArray
Table = Mapping[str, Column]
"""Columns (n,) by name: int64, or float64 with NaN where a cell is empty."""

_MAGIC = b"PAR1"
_ZSTD = 6
_OPTIONAL = 1
MOST_ROWS = 1 << 20
"""A group of rows has no more than this."""


class TableFile:
    """A Parquet file that is written group by group. kinds: INT64 or DOUBLE, by column. Raises OSError."""

    def __init__(self, path: Path, kinds: Mapping[str, int]) -> None:
        self._file = path.open("wb")
        self._kinds = kinds
        self._groups: list[tuple[int, list[Thrift], int]] = []
        self._at = 0
        self._write(_MAGIC)

    def _write(self, data: bytes) -> int:
        place, self._at = self._at, self._at + len(data)
        self._file.write(data)
        return place

    def begin(self, rows: int) -> None:
        """Begin a group of rows; its columns follow."""
        self._groups.append((rows, [], 0))

    def add(self, column: PackedColumn) -> None:
        """The next column of the group."""
        rows, columns, size = self._groups[-1]
        columns.append(_column_chunk(column, self._write(column.data)))
        self._groups[-1] = rows, columns, size + column.size

    def close(self) -> None:
        """Write the table of contents."""
        groups = [
            Thrift([(1, LIST, (Thrift, columns)), (2, I64, size), (3, I64, rows)])
            for rows, columns, size in self._groups
        ]
        contents = Thrift(
            [
                (1, I32, 1),
                (2, LIST, (Thrift, _schema(self._kinds))),
                (3, I64, sum(rows for rows, _, _ in self._groups)),
                (4, LIST, (Thrift, groups)),
                (6, BINARY, "cogest"),
                # the values' own order, for the least and the largest
                (7, LIST, (Thrift, [Thrift([(1, Thrift, Thrift([]))]) for _ in self._kinds])),
            ]
        ).pack()
        self._write(contents + len(contents).to_bytes(4, "little") + _MAGIC)
        self._file.close()

    def __enter__(self) -> TableFile:
        """Start."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the file, which is whole if it was closed."""
        self._file.close()


def _schema(kinds: Mapping[str, int]) -> list[Thrift]:
    columns = [
        Thrift([(1, I32, kind), (3, I32, _OPTIONAL), (4, BINARY, name)]) for name, kind in kinds.items()
    ]
    return [Thrift([(4, BINARY, "root"), (5, I32, len(kinds))]), *columns]


def _column_chunk(column: PackedColumn, place: int) -> Thrift:
    figures = Thrift([(3, I64, column.empty), (5, BINARY, column.high), (6, BINARY, column.low)])
    encodings = (I32, sorted({RLE, column.encoding}))
    about = [(1, I32, column.kind), (2, LIST, encodings), (3, LIST, (BINARY, [column.name])), (4, I32, _ZSTD)]
    about += [(5, I64, column.rows), (6, I64, column.size), (7, I64, len(column.data)), (9, I64, place)]
    return Thrift([(2, I64, place), (3, Thrift, Thrift([*about, (12, Thrift, figures)]))])


def kinds_of(table: Table) -> dict[str, int]:
    """The columns of a table for `TableFile`."""
    return {name: INT64 if values.dtype.kind == "i" else DOUBLE for name, values in table.items()}


def _rows(table: Table) -> int:
    return len(next(iter(table.values())))


def _packed(item: tuple[str, Column]) -> PackedColumn:
    return pack_column(*item)


class PackedAhead:
    """Columns that are packed on another core while it is not yet sure that they will be written as they are.

    Which they are is asked of the array itself: a column that became another one is packed anew.
    """

    def __init__(self, columns: Iterable[Column] = ()) -> None:
        """Nothing is packed ahead where there is one core only."""
        self._pool = ThreadPoolExecutor(1) if cores() > 1 else None
        self._begun: dict[int, tuple[Column, Future[PackedColumn]]] = {}
        for column in columns:
            self.begin(column)

    def begin(self, column: Column) -> None:
        """Pack this column as soon as there is a core for it."""
        if self._pool is not None and id(column) not in self._begun:
            self._begun[id(column)] = column, self._pool.submit(pack_column, "", column)

    def packed(self, item: tuple[str, Column]) -> PackedColumn:
        """A column of that name and those values."""
        name, values = item
        column, future = self._begun.pop(id(values), (None, None))
        # one whose turn has not come is packed here: all cores are wanted now
        if column is not values or future is None or future.cancel():
            return pack_column(name, values)
        return replace(future.result(), name=name)

    def close(self) -> None:
        """Pack no more of them."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)


def _groups(table: Table) -> Iterator[Table]:
    """A table in groups of rows; a short one as it is."""
    if 0 < _rows(table) <= MOST_ROWS:
        yield table
        return
    for start in range(0, _rows(table), MOST_ROWS):
        yield {name: values[start : start + MOST_ROWS] for name, values in table.items()}


def write_tables(tables: Sequence[tuple[Path, Table]], ahead: PackedAhead | None = None) -> None:
    """Write each table to a file. All columns of a table have one length. ahead: columns that are packed already.

    Raises OSError.
    """
    pack = _packed if ahead is None else ahead.packed
    columns = (item for _, table in tables for group in _groups(table) for item in group.items())
    # one queue for all of them: no core waits at the end of a table
    with contextlib.closing(in_order(pack, columns)) as packed:
        for path, table in tables:
            with TableFile(path, kinds_of(table)) as file:
                for group in _groups(table):
                    file.begin(_rows(group))
                    for _ in group:
                        file.add(next(packed))
                file.close()


def write_pieces(
    pieces: Iterable[Table], path: Path, kinds: Mapping[str, int], least_bytes: int = 8 << 20
) -> None:
    """Write tables of one layout, one below the other, into one file; only a few of them are in memory at a time.

    least_bytes: pieces are gathered into groups of rows of so much. Raises OSError, and what `pieces` raises.
    """
    with TableFile(path, kinds) as file:
        held: list[Table] = []
        size = 0

        def flush() -> None:
            nonlocal held, size
            if held:
                gathered = {name: np.concatenate([each[name] for each in held]) for name in kinds}
                held, size = [], 0
                file.begin(_rows(gathered))
                for column in in_order(_packed, gathered.items()):
                    file.add(column)

        for piece in pieces:
            held.append(piece)
            size += sum(values.nbytes for values in piece.values())
            if size >= least_bytes:
                flush()
        flush()
        file.close()
