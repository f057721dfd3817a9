"""Leaf pages of a table to rows: reads a batch of pages and finds what is wanted on them, with memory that is kept."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel
from parsers.sqlite_kernels import FIELDS, LENGTH, MARK, NEXT, PLACE, TIME, TOPIC, BoolArray, leaf_rows
from parsers.sqlite_pages import PagedFile, PageReader
from parsers.sqlite_tree import Nodes

LEAST_ROWS = 1 << 14
"""Room for so many rows of a batch is made at first."""


@dataclass(frozen=True)
class Query:
    """What is wanted of a table's rows: those whose number is one of `ids`, sorted; with a time and a blob.

    columns: (3,) which of a row's values are the number, the time and the blob.
    """

    columns: IntArray
    ids: IntArray


@kernel
def group_rows(
    rows: IntArray,
    first: int,
    last: int,
    mark: int,
    edges: IntArray,
    time: IntArray,
    place: IntArray,
    length: IntArray,
) -> tuple[bool, bool]:
    """Rows `first` to `last` of a table sorted by number, in their order within each; (any overflow, any with `mark`).

    edges: (numbers + 1,), those of number k are edges[k] to edges[k + 1]. time, place, length: (last - first,) at least.
    """
    overflow = marked = False
    edges[:] = 0
    for row in range(first, last):
        edges[rows[TOPIC, row] + 1] += 1
    for k in range(1, edges.shape[0]):
        edges[k] += edges[k - 1]
    at = edges.copy()
    for row in range(first, last):
        k = rows[TOPIC, row]
        time[at[k]], place[at[k]], length[at[k]] = rows[TIME, row], rows[PLACE, row], rows[LENGTH, row]
        at[k] += 1
        overflow = overflow or rows[NEXT, row] != 0
        marked = marked or rows[MARK, row] == mark
    return overflow, marked


@dataclass(frozen=True)
class Grouped:
    """Rows by number: those of the query's id k are edges[k] to edges[k + 1]. time is the caller's; place and length of
    the blobs are valid until the next scan."""

    edges: tuple[int, ...]
    time: IntArray
    place: IntArray
    length: IntArray


@dataclass
class LeafScanner:
    """Scans leaf pages, at most `room` at a time: one for each thread. `close` it."""

    paged: PagedFile
    query: Query
    room: int
    _reader: PageReader = field(init=False, repr=False)
    _table: IntArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Make room. Raises OSError."""
        self._reader = PageReader(self.paged, self.room)
        self._table = np.empty((FIELDS, LEAST_ROWS), dtype=np.int64)

    def close(self) -> None:
        """Close the file."""
        self._reader.close()

    @property
    def buffer(self) -> ByteArray:
        """The pages' bytes, until the next scan."""
        return self._reader.buffer

    def scan(self, nodes: Nodes) -> tuple[IntArray, BoolArray]:
        """(rows, bad): a table as `leaf_rows` fills it, valid until the next scan, and which pages are damaged."""
        place = self._reader.load(nodes.page)
        bad = np.empty(len(place), dtype=np.bool_)
        about = (nodes.low, nodes.high, self.paged.size, self.query.columns, self.query.ids)
        while True:
            found = leaf_rows(self.buffer, place, self.paged.usable, *about, self._table, bad)
            if found >= 0:
                return self._table[:, :found], bad
            # more rows than ever before on as many pages
            self._table = np.empty((FIELDS, 2 * self._table.shape[1]), dtype=np.int64)

    def group(self, first: int, last: int, mark: int) -> Grouped | None:
        """Rows `first` to `last` of the last scan by number; None where that is not enough to use them: blobs that go on
        over other pages, or begin with `mark`."""
        time = np.empty(last - first, dtype=np.int64)
        place, length = np.empty_like(time), np.empty_like(time)
        edges = np.empty(len(self.query.ids) + 1, dtype=np.int64)
        if any(group_rows(self._table, first, last, mark, edges, time, place, length)):
            return None
        return Grouped(tuple(edges.tolist()), time, place, length)
