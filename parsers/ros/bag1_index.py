"""What is in a ROS 1 bag: its connections and chunks, from the index at its end or, without one, by a search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import BinaryIO, Literal

import numpy as np

from parsers.importer import ImportLog
from parsers.ros.bag1_chunks import ChunkError, ChunkRef, Walk, load_chunk, walk_data
from parsers.ros.bag1_kernels import chunk_infos
from parsers.ros.bag1_records import (
    MAGIC,
    OP_BAG_HEADER,
    OP_CHUNK,
    OP_CHUNK_INFO,
    OP_CONNECTION,
    OP_MESSAGE,
    Connection,
    Record,
    next_chunk,
    read_connection,
    read_record,
    record_breaks_off,
)

_WINDOW = 1 << 18
_LEAST_INFO = 60
"""Bytes of the index that are read at once, and of the shortest record of a chunk in it."""
_BARE_BYTES = 1 << 22

IndexState = Literal["whole", "damaged", "none"]


@dataclass
class BagIndex:
    """Connections by id, and chunks in the file's order."""

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[ChunkRef] = field(default_factory=list)


def read_index(file: BinaryIO, size: int) -> BagIndex | None:
    """The index as the bag header points at it; None where there is none, or it does not hold together."""
    header = read_record(file, len(MAGIC), size)
    if header is None or header.op != OP_BAG_HEADER:
        return None
    at, connections, chunks = header.u64("index_pos"), header.u32("conn_count"), header.u32("chunk_count")
    if not at or at > size or connections is None or chunks is None or connections + chunks > size // 16:
        return None
    index = BagIndex()
    left = connections + chunks
    while left > 0:
        record = read_record(file, at, size)
        if record is None or record.end > size:
            return None
        if record.op == OP_CONNECTION:
            connection = read_connection(file, record)
            if connection is None:
                return None
            index.connections[connection.id] = connection
            left, at = left - 1, record.end
        elif record.op == OP_CHUNK_INFO:
            found, at = _chunk_infos(file, at, record.end, size, left)
            if not found:
                return None
            index.chunks.extend(found)
            left -= len(found)
        else:
            return None
    index.chunks.sort(key=lambda chunk: chunk.start)
    starts = {chunk.start for chunk in index.chunks}
    return index if len(index.chunks) == len(starts) == chunks else None


def _chunk_infos(file: BinaryIO, at: int, least: int, size: int, most: int) -> tuple[list[ChunkRef], int]:
    """What the index says of some chunks, from `at` at least to `least`, and where it goes on; none where broken."""
    file.seek(at)
    raw = file.read(max(_WINDOW, least - at))
    infos = np.empty((min(most, len(raw) // _LEAST_INFO + 1), 5), dtype=np.int64)
    found, stop = chunk_infos(np.frombuffer(raw, dtype=np.uint8), 0, infos)
    refs: list[ChunkRef] = []
    for place, first, last, pairs, count in infos[:found].tolist():
        if place >= size:
            return [], at
        counts = np.frombuffer(raw, dtype="<u4", count=2 * count, offset=pairs).tolist()
        known = dict(zip(counts[::2], counts[1::2], strict=True))
        refs.append(ChunkRef(place, size, known, None if first < 0 else first, None if last < 0 else last))
    return refs, at + stop


@dataclass
class _Search:
    """State of a search through a bag without an index. cut: a sentence where the file breaks off."""

    file: BinaryIO
    size: int
    log: ImportLog
    found: BagIndex = field(default_factory=BagIndex)
    cut: str = ""
    last_ns: int | None = None
    lost_from: int | None = None
    lost: bool = False

    def chunk(self, record: Record, end: int, whole: bool) -> None:
        """Take in a chunk: its connections, how many messages of each, and their times."""
        ref = ChunkRef(record.start, end, None, whole=whole)
        try:
            walk = load_chunk(self.file, ref, self.size)
        except ChunkError as error:
            self.damage(record.start, f"a chunk was left out: {error}")
            return
        self._take(ref, walk)

    def messages(self, record: Record) -> int:
        """Take in messages that lie in the file itself, from one of them on; where the next other record begins."""
        self.file.seek(record.start)
        raw = self.file.read(max(_BARE_BYTES, record.end - record.start))
        walk = walk_data(np.frombuffer(raw, dtype=np.uint8), bare=True)
        end = record.start + walk.stop
        self._take(ChunkRef(record.start, end, None, bare=True), walk)
        return max(end, record.end)

    def _take(self, ref: ChunkRef, walk: Walk) -> None:
        for connection in walk.connections():
            self.found.connections.setdefault(connection.id, connection)
        messages = walk.conn >= 0
        ids, counts = np.unique(walk.conn[messages], return_counts=True)
        if not len(ids):
            return
        times = walk.time_ns[messages]
        first, last = int(times.min()), int(times.max())
        if self.lost and self.last_ns is not None and first > self.last_ns:
            self.log.lost_spans_ns.append((self.last_ns, first))
        self.lost, self.last_ns = False, last
        known = dict(zip(ids.tolist(), counts.tolist(), strict=True))
        self.found.chunks.append(replace(ref, counts=known, first_ns=first, last_ns=last))

    def damage(self, at: int, what: str) -> None:
        """Write down that something at `at` cannot be read."""
        self.lost = True
        self.log.reject("damaged part of the bag")
        self.log.worsen("malformed", f"at byte {at}: {what}")


def search(
    file: BinaryIO, size: int, log: ImportLog, progress: Callable[[int, int], None], index: IndexState
) -> BagIndex:
    """Find all chunks and connections by going through the file from its start, past damage where there is some.

    Messages that lie in the file itself, not in chunks, are found too: some at a time, as chunks that are `bare`.
    index: what the bag has of one; "whole" where it speaks of no chunks.
    """
    state = _Search(file, size, log)
    at = len(MAGIC)
    while at < size and not state.cut:
        progress(at, size)
        record = read_record(file, at, size)
        if record is None or record.end > size:
            at = _past_damage(state, at, record)
        else:
            if record.op == OP_CHUNK:
                state.chunk(record, record.end, True)
            elif record.op == OP_MESSAGE:
                at = state.messages(record)
                continue
            elif record.op == OP_CONNECTION:
                connection = read_connection(file, record)
                if connection is not None:
                    state.found.connections.setdefault(connection.id, connection)
            at = record.end
    chunks = state.found.chunks
    span = (chunks[-1].last_ns or 0) - (chunks[0].first_ns or 0) if chunks else 0
    read = f"{len(chunks)} chunks over {span / 1e9:.1f} s were found"
    if state.cut:
        log.worsen("truncated", f"{state.cut}; {read}")
    elif index == "damaged":
        log.worsen("malformed", f"the bag's index at its end is damaged; without it {read}")
    elif index == "none":
        log.worsen("truncated", f"the bag has no index (the recording was not closed properly); {read}")
    return state.found


def _past_damage(state: _Search, at: int, record: Record | None) -> int:
    """Where to go on after a record that is broken or runs past the file's end."""
    after = next_chunk(state.file, at + 1 if record is None else record.data_at, state.size)
    end = state.size if after is None else after.start
    if record is not None and record.op == OP_CHUNK:
        state.chunk(record, end, False)
    if after is not None:
        state.damage(at, f"the bag is damaged; reading goes on at byte {end}")
    elif record is not None or record_breaks_off(state.file, at, state.size):
        state.cut = f"the bag breaks off at byte {state.size}, inside the record at byte {at}"
    else:
        state.damage(at, "the bag is damaged from here to its end")
    return end
