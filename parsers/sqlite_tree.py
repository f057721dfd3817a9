"""The leaf pages of a table in an SQLite file, in the order of their keys, found from its root page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from parsers.sqlite_kernels import INTERIOR, LEAF, BoolArray, children, most_children
from parsers.sqlite_pages import PagedFile, PageReader

MAX_DEPTH = 20
"""SQLite follows no deeper tree."""
PARENTS = 16
"""Interior pages whose children are listed together: 16 of the usual size lead to some 30 MB of leaf pages."""
FIRST_KEY, LAST_KEY = -(1 << 63), (1 << 63) - 1


@dataclass(frozen=True)
class Nodes:
    """Pages of one level of the tree, in the order of their keys; shape (n,) each.

    The keys on page i and below it are above low[i] and not above high[i]. Page 0 stands for one that is damaged.
    """

    page: IntArray
    low: IntArray
    high: IntArray

    def part(self, start: int, stop: int) -> Nodes:
        """Some of them."""
        return Nodes(self.page[start:stop], self.low[start:stop], self.high[start:stop])


@dataclass
class TableTree:
    """The tree of one table. root: its root page, as the schema gives it."""

    paged: PagedFile
    root: int
    depth: int
    seen: BoolArray

    def leaves(self, reader: PageReader, at_most: int) -> Iterator[Nodes]:
        """Yield the leaf pages, at most `at_most` at a time; only the interior pages are read, as they are needed."""
        level = _nodes(self.root)
        if not self.depth:
            yield level
            return
        for _ in range(self.depth - 1):
            parts = [self._below(reader, part) for part in _slices(level, reader.room)]
            level = Nodes(
                *(
                    np.concatenate(each)
                    for each in zip(*((p.page, p.low, p.high) for p in parts), strict=True)
                )
            )
        for parents in _slices(level, PARENTS):
            yield from _slices(self._below(reader, parents), at_most)

    def _below(self, reader: PageReader, nodes: Nodes) -> Nodes:
        place = reader.load(nodes.page)
        out = np.empty((3, most_children(reader.buffer, place, self.paged.usable)), dtype=np.int64)
        found = children(reader.buffer, place, self.paged.usable, nodes.low, nodes.high, self.seen, out)
        return Nodes(*out[:, :found])


def table_tree(paged: PagedFile, root: int, reader: PageReader) -> TableTree | None:
    """The tree with this root page; None where neither its left nor its right edge leads down to a leaf page."""
    if not 2 <= root <= paged.pages:
        return None
    for edge in (0, -1):
        depth = _depth(paged, root, reader, edge)
        if depth is not None:
            seen = np.zeros(paged.pages + 1, dtype=np.bool_)
            seen[root] = True
            return TableTree(paged, root, depth, seen)
    return None


def _depth(paged: PagedFile, root: int, reader: PageReader, edge: int) -> int | None:
    """How many levels of interior pages there are, going down one edge of the tree."""
    seen = np.zeros(paged.pages + 1, dtype=np.bool_)
    trial = TableTree(paged, root, 0, seen)
    node = _nodes(root)
    for depth in range(MAX_DEPTH):
        place = int(reader.load(node.page)[0])
        kind = int(reader.buffer[place]) if place >= 0 else 0
        if kind == LEAF:
            return depth
        if kind != INTERIOR:
            return None
        below = trial._below(reader, node)
        at = edge % len(below.page)
        node = below.part(at, at + 1)
    return None


def _nodes(page: int) -> Nodes:
    """One page with all keys."""
    return Nodes(*(np.array([value], dtype=np.int64) for value in (page, FIRST_KEY, LAST_KEY)))


def _slices(nodes: Nodes, size: int) -> Iterator[Nodes]:
    for start in range(0, len(nodes.page), size):
        yield nodes.part(start, start + size)
