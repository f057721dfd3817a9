"""Pages of a Parquet file whose content is not what its checksum says: polars does not look at these, and gives other numbers.

Source: https://parquet.apache.org/docs/file-format/data-pages/checksumming/ (CRC32 of a page as it is stored, without its head).
"""

from __future__ import annotations

import contextlib
import zlib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from parsers.parquet_thrift_read import THRIFT_DAMAGE, ThriftReader

_HEAD_BYTES = 1 << 13
_MOST_HEAD = 1 << 20
_READ_BYTES = 1 << 20
_DATA, _DICTIONARY, _DATA_V2 = 0, 2, 3

Spans = list[tuple[int, int]]
"""Rows [start, stop) of the whole file."""


def torn_rows(path: Path, columns: Collection[str]) -> dict[str, Spans]:
    """For each of these columns that has any, the rows in pages that are not what their checksums say.

    Pages without a checksum count as whole, and so does what cannot be told: polars says itself what it cannot read. Raises OSError.
    """
    found: dict[str, Spans] = {}
    with path.open("rb") as file:
        for column, told, before, rows in _chunks(file, columns):
            with contextlib.suppress(*THRIFT_DAMAGE):
                for a, b in _torn_of(file, told, rows):
                    found.setdefault(column, []).append((before + a, before + b))
    return found


def _chunks(file: BinaryIO, columns: Collection[str]) -> Iterator[tuple[str, dict[int, Any], int, int]]:
    """Name, what the table of contents tells of it, rows before it and rows of the columns that have a value a row."""
    size = file.seek(0, 2)
    file.seek(max(0, size - 8))
    length = int.from_bytes(file.read(4), "little")
    if length + 12 > size:
        return
    file.seek(size - 8 - length)
    before = 0
    try:
        for group in ThriftReader(file.read(length)).struct()[4]:
            rows = int(group[3])
            for chunk in group[1]:
                told = chunk[3]
                name = told[3][0].decode("utf-8")
                if name in columns and len(told[3]) == 1 and told[5] == rows:
                    yield name, told, before, rows
            before += rows
    except THRIFT_DAMAGE:
        return


def _torn_of(file: BinaryIO, told: dict[int, Any], rows: int) -> Iterator[tuple[int, int]]:
    """The rows in a column's torn pages. Raises THRIFT_DAMAGE where a page has no head."""
    at = min(told[9], told.get(11) or told[9])
    stop = at + told[7]
    row = 0
    while at < stop and row < rows:
        page, head = _page_head(file, at, stop)
        if 4 not in page:
            # a writer gives all pages checksums or none
            return
        at += head
        kind, size = page[1], page[3]
        if size < 0 or at + size > stop:
            return
        count = int(page[5][1] if kind == _DATA else page[8][3] if kind == _DATA_V2 else 0)
        if count < 0:
            return
        if _checksum(file, at, size) != page[4] & 0xFFFFFFFF:
            if kind == _DICTIONARY:
                # all pages of the column point into it
                yield 0, rows
                return
            yield row, min(row + count, rows)
        row += count
        at += size


def _page_head(file: BinaryIO, at: int, stop: int) -> tuple[dict[int, Any], int]:
    """A page's head, and its size."""
    room = _HEAD_BYTES
    while True:
        file.seek(at)
        reader = ThriftReader(file.read(min(room, stop - at)))
        try:
            return reader.struct(), reader.at
        except THRIFT_DAMAGE:
            # least and greatest texts may make it long
            if room >= min(_MOST_HEAD, stop - at):
                raise
            room *= 16


def _checksum(file: BinaryIO, at: int, size: int) -> int:
    file.seek(at)
    crc = 0
    while size > 0 and (data := file.read(min(size, _READ_BYTES))):
        crc = zlib.crc32(data, crc)
        size -= len(data)
    return crc
