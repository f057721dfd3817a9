"""Messages of a ROS 2 bag straight from the pages of its SQLite file: many times faster than through the library.

The library is still what opens the database, reads its small tables, and is asked for whatever the pages do not give.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from queue import Empty, SimpleQueue

import numpy as np

from parsers.allocator import Slabs, keep_freed_memory
from parsers.channels import ByteArray, IntArray
from parsers.jit_foreign import pread_address
from parsers.ros.bag2_decode import Chosen, Outcome, Piece, decode_rows, decode_topic
from parsers.ros.bag2_flow import LeafFlow
from parsers.ros.bag2_messages import ZSTD_MARK
from parsers.ros.bag2_rows import DAMAGED_MESSAGE, Rows
from parsers.ros.flow import Filled, Plan, plan_of
from parsers.sqlite_kernels import LENGTH, NEXT, PAGE, PLACE, TIME, TOPIC, BoolArray
from parsers.sqlite_overflow import gather, pages_needed
from parsers.sqlite_pages import PagedFile, PageReader, paged_file
from parsers.sqlite_scan import Grouped, LeafScanner, Query
from parsers.sqlite_tree import PARENTS, Nodes, TableTree, table_tree

LEAF_BYTES = 1 << 22
"""Leaf pages that the slower way reads, searches and decodes together."""
FLOW_BYTES = 1 << 23
"""Leaf pages that a thread is given at once where it can decode them with one call."""
CHAIN_BYTES = 1 << 20
"""Overflow pages that are read together."""
BATCH_BYTES = 1 << 24
"""Payloads that are gathered together where some of them are on overflow pages."""

MOST_ODD = 8
"""So often may pages of a batch be left to the slower way before all are."""

MOST_COLUMNS = 12
"""So many columns always have a record header of less than 128 bytes, as `leaf_rows` expects it."""


@dataclass(frozen=True)
class MessagePages:
    """Where the messages are. root: the table's first page. columns: which values of a record are topic, time, data."""

    paged: PagedFile
    root: int
    columns: IntArray


def message_pages(connection: sqlite3.Connection, path: Path) -> MessagePages | None:
    """Look whether the table of messages can be read from its pages; None where only the library can.

    Needs a plain table whose values are stored as they are declared: no view, no generated columns, rowids; integers
    before the payload and nothing that defaults to a value which is not stored.
    """
    try:
        paged = paged_file(path)
        tables = connection.execute(
            "SELECT type, rootpage, sql FROM sqlite_master WHERE lower(name) = 'messages'"
        ).fetchall()
        columns = connection.execute("PRAGMA table_xinfo(messages)").fetchall()
    except (sqlite3.Error, OSError):
        return None
    if paged is None or len(tables) != 1:
        return None
    kind, root, sql = tables[0]
    plain = kind == "table" and isinstance(root, int) and isinstance(sql, str)
    if not plain or re.search(r"\bWITHOUT\b|\bVIRTUAL\b", sql, re.IGNORECASE):
        return None
    names = [str(column[1]).lower() for column in columns]
    if {"rowid", "_rowid_", "oid"} & set(names) or not {"topic_id", "timestamp", "data"} <= set(names):
        return None
    at = [names.index(name) for name in ("topic_id", "timestamp", "data")]
    integers = all("INT" in str(column[2]).upper() for column in columns[: at[2]])
    odd = any(column[6] for column in columns) or any(columns[i][4] is not None or columns[i][5] for i in at)
    if not integers or odd or at[2] < max(at) or len(columns) > MOST_COLUMNS:
        return None
    return MessagePages(paged, root, np.array(at, dtype=np.int64))


@dataclass(frozen=True)
class Unread:
    """Keys above `low` and not above `high` are on damaged pages."""

    low: int
    high: int


@dataclass(frozen=True)
class Batch:
    """What some leaf pages gave, in order. size: how much of the file they are, in bytes."""

    parts: tuple[Outcome | Unread, ...]
    size: int


@dataclass(frozen=True)
class _Hands:
    """What one thread reads with. flow: None where only the slower way will do."""

    scanner: LeafScanner
    chains: PageReader
    flow: LeafFlow | None

    def close(self) -> None:
        """Close the files."""
        for each in (self.scanner, self.chains, self.flow):
            if each is not None:
                each.close()


@dataclass
class PageSource:
    """Reads the chosen topics' messages batch by batch: `batches` in one thread, `read` in any, `close` at the end."""

    pages: MessagePages
    tree: TableTree
    chosen: Chosen
    _query: Query = field(init=False)
    _slabs: Slabs = field(init=False, default_factory=Slabs)
    _free: SimpleQueue[_Hands] = field(init=False, default_factory=SimpleQueue)
    _plan: Plan | None = field(init=False)

    def __post_init__(self) -> None:
        """Sort the topics' numbers, and let what batches take be used again."""
        keep_freed_memory()
        ids = sorted(self.chosen)
        self._query = Query(self.pages.columns, np.array(ids, dtype=np.int64))
        self._plan = None
        if pread_address():
            self._plan = plan_of(
                [(topic.decoder, paths) for topic, paths in map(self.chosen.__getitem__, ids)]
            )

    def batches(self) -> Iterator[Nodes]:
        """Yield the leaf pages, a batch at a time."""
        size = LEAF_BYTES if self._plan is None else FLOW_BYTES
        with PageReader(self.pages.paged, PARENTS) as reader:
            yield from self.tree.leaves(reader, _room(self.pages.paged, size))

    def read(self, nodes: Nodes) -> Batch:
        """Read a batch: what its pages hold and which of its keys are on damaged pages, in order."""
        hands = self._borrow()
        try:
            parts = tuple(_joined(self._parts(nodes, hands)))
        finally:
            self._free.put(hands)
        return Batch(parts, len(nodes.page) * self.pages.paged.page_size)

    def close(self) -> None:
        """Close the files."""
        while True:
            try:
                self._free.get_nowait().close()
            except Empty:
                return

    def _borrow(self) -> _Hands:
        try:
            return self._free.get_nowait()
        except Empty:  # more threads than before
            paged, plan = self.pages.paged, self._plan
            scanner = LeafScanner(paged, self._query, _room(paged, LEAF_BYTES))
            chains = PageReader(paged, _room(paged, CHAIN_BYTES))
            flow = None if plan is None else LeafFlow(paged, self._query, plan, self._slabs.cells, ZSTD_MARK)
            return _Hands(scanner, chains, flow)

    def _parts(self, nodes: Nodes, hands: _Hands) -> Iterator[Outcome | Unread]:
        at, odd, end = 0, 0, len(nodes.page)
        while self._plan is not None and hands.flow is not None and at < end:
            stretch = hands.flow.decode(nodes, at)
            if stretch.span_ns is not None:
                yield self._flown(stretch.filled, stretch.span_ns)
            at = stretch.end
            if not stretch.more:
                return
            stop = min(at + hands.flow.step, end)
            yield from self._slowly(nodes.part(at, stop), hands)
            at, odd = stop, odd + 1
            if odd >= MOST_ODD:
                # a bag of compressed messages, or of large ones: its pages are not to be read twice
                self._plan = None
        yield from self._slowly(nodes.part(at, end), hands)

    def _flown(self, filled: Sequence[Filled], span_ns: tuple[int, int]) -> Outcome:
        numbers = self._query.ids.tolist()
        pieces = (Piece(self.chosen[numbers[each.number]][0], each.decoded, each.time_ns) for each in filled)
        return Outcome(tuple(pieces), {}, span_ns)

    def _slowly(self, nodes: Nodes, hands: _Hands) -> Iterator[Outcome | Unread]:
        """The same in several calls, and for all that there may be on the pages."""
        room = hands.scanner.room
        for start in range(0, len(nodes.page), room):
            yield from self._scanned(nodes.part(start, start + room), hands.scanner, hands.chains)

    def _scanned(self, nodes: Nodes, scanner: LeafScanner, chains: PageReader) -> Iterator[Outcome | Unread]:
        rows, bad = scanner.scan(nodes)
        edges = [0, *(np.flatnonzero(np.diff(bad)) + 1).tolist(), len(bad)]
        for start, stop in pairwise(edges):
            if bad[start]:
                yield Unread(int(nodes.low[start]), int(nodes.high[stop - 1]))
            else:
                first, last = np.searchsorted(rows[PAGE], (start, stop))
                group = scanner.group(int(first), int(last), ZSTD_MARK)
                if group is None:
                    yield from self._decoded(rows[:, first:last], scanner.buffer, chains)
                else:
                    yield self._grouped(group, rows[TIME, first:last], scanner.buffer)

    def _grouped(self, group: Grouped, time_ns: IntArray, data: ByteArray) -> Outcome:
        """Decode what is whole in the buffer, topic by topic."""
        pieces: list[Piece] = []
        for number, (start, stop) in zip(self._query.ids.tolist(), pairwise(group.edges), strict=True):
            part = slice(start, stop)
            messages = group.time[part], group.place[part], group.length[part]
            pieces += decode_topic(self.chosen[number], data, *messages, self._slabs.cells)
        span = (int(time_ns[0]), int(time_ns[-1])) if len(time_ns) else None
        return Outcome(tuple(pieces), {}, span)

    def _decoded(self, rows: IntArray, data: ByteArray, chains: PageReader) -> Iterator[Outcome]:
        """Decode rows, a bounded amount of payloads at a time: of which some are on overflow pages, or compressed."""
        topic_id = self._query.ids[rows[TOPIC]]
        if not rows[NEXT].any():
            yield decode_rows(Rows(topic_id, rows[TIME], rows[PLACE], rows[LENGTH], data), self.chosen)
            return
        # pages belong to one message each: where a batch asks for more of them than there are, it would read for ever
        rows[NEXT, np.cumsum(pages_needed(self.pages.paged, rows)) > self.pages.paged.pages] = -1
        filled = np.cumsum(rows[LENGTH]) // BATCH_BYTES
        cuts = [0, *(np.flatnonzero(np.diff(filled)) + 1).tolist(), len(filled)]
        for start, stop in pairwise(cuts):
            yield self._gathered(topic_id[start:stop], rows[:, start:stop], data, chains)

    def _gathered(self, topic_id: IntArray, rows: IntArray, data: ByteArray, chains: PageReader) -> Outcome:
        blobs = gather(data, rows, chains)
        time_ns = rows[TIME]
        whole = np.flatnonzero(blobs.whole)
        good = Rows(topic_id[whole], time_ns[whole], blobs.offset[whole], blobs.length[whole], blobs.data)
        done = replace(decode_rows(good, self.chosen), overflow=blobs.pages)
        return done if len(whole) == len(time_ns) else _with_losses(done, blobs.whole, time_ns)


def _joined(parts: Iterator[Outcome | Unread]) -> Iterator[Outcome | Unread]:
    """Damaged pages that follow each other as one."""
    held: Unread | None = None
    for part in parts:
        if isinstance(part, Unread):
            held = part if held is None else Unread(held.low, part.high)
            continue
        if held is not None:
            yield held
            held = None
        yield part
    if held is not None:
        yield held


def _with_losses(done: Outcome, whole: BoolArray, time_ns: IntArray) -> Outcome:
    """Say which messages could not be gathered."""
    at = np.flatnonzero(whole)
    jumps = np.flatnonzero(np.diff(at) > 1)
    inside = tuple(zip(time_ns[at[jumps]].tolist(), time_ns[at[jumps + 1]].tolist(), strict=True))
    return replace(
        done,
        rejected={**done.rejected, DAMAGED_MESSAGE: int((~whole).sum())},
        lost_before=not whole[0],
        lost_after=not whole[-1],
        lost_inside=inside,
    )


def page_source(pages: MessagePages, chosen: Chosen) -> PageSource | None:
    """Get ready to read; None where the tree of the table does not even begin well."""
    with PageReader(pages.paged, PARENTS) as reader:
        tree = table_tree(pages.paged, pages.root, reader)
    return None if tree is None else PageSource(pages, tree, chosen)


def count_from_pages(pages: MessagePages, topic_ids: Sequence[int]) -> dict[int, int] | None:
    """Topic id -> number of its messages; None where the pages do not tell. Reads all leaf pages of the table."""
    ids = np.array(sorted(set(topic_ids)), dtype=np.int64)
    total = np.zeros(len(ids), dtype=np.int64)
    room = _room(pages.paged, LEAF_BYTES)
    with (
        PageReader(pages.paged, PARENTS) as reader,
        closing(LeafScanner(pages.paged, Query(pages.columns, ids), room)) as scanner,
    ):
        tree = table_tree(pages.paged, pages.root, reader)
        if tree is None:
            return None
        for nodes in tree.leaves(reader, room):
            rows, bad = scanner.scan(nodes)
            if bad.any():
                return None
            total += np.bincount(rows[TOPIC], minlength=len(ids))
    return dict(zip(ids.tolist(), total.tolist(), strict=True))


def _room(paged: PagedFile, size: int) -> int:
    """How many pages are in so many bytes, at least one and no more than there are."""
    return max(1, min(size // paged.page_size, paged.pages))
