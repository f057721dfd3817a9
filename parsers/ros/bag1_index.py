"""What is in a ROS 1 bag: its connections and chunks, from the index at its end or, without one, by a search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import BinaryIO

import numpy as np

from parsers.importer import ImportLog
from parsers.ros.bag1_chunks import ChunkError, ChunkRef, load_chunk
from parsers.ros.bag1_records import (
    MAGIC,
    OP_BAG_HEADER,
    OP_CHUNK,
    OP_CHUNK_INFO,
    OP_CONNECTION,
    Connection,
    Record,
    next_chunk,
    read_connection,
    read_record,
    record_breaks_off,
)


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
    for _ in range(connections + chunks):
        record = read_record(file, at, size)
        if record is None or record.end > size:
            return None
        if record.op == OP_CONNECTION:
            connection = read_connection(file, record)
            if connection is None:
                return None
            index.connections[connection.id] = connection
        elif record.op == OP_CHUNK_INFO:
            chunk = _chunk_info(file, record, size)
            if chunk is None:
                return None
            index.chunks.append(chunk)
        else:
            return None
        at = record.end
    index.chunks.sort(key=lambda chunk: chunk.start)
    starts = {chunk.start for chunk in index.chunks}
    return index if len(index.chunks) == len(starts) == chunks else None


def _chunk_info(file: BinaryIO, record: Record, size: int) -> ChunkRef | None:
    place, count = record.u64("chunk_pos"), record.u32("count")
    if place is None or count is None or place >= size or count * 8 != record.data_len:
        return None
    file.seek(record.data_at)
    pairs = np.frombuffer(file.read(record.data_len), dtype="<u4").reshape(-1, 2)
    counts: dict[int, int] = dict(pairs.tolist())
    return ChunkRef(place, size, counts, record.time_ns("start_time"), record.time_ns("end_time"))


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
        self.found.chunks.append(ChunkRef(record.start, end, known, first, last, whole))

    def damage(self, at: int, what: str) -> None:
        """Write down that something at `at` cannot be read."""
        self.lost = True
        self.log.reject("damaged part of the bag")
        self.log.worsen("malformed", f"at byte {at}: {what}")


def search(
    file: BinaryIO, size: int, log: ImportLog, progress: Callable[[int, int], None], *, indexed: bool
) -> BagIndex:
    """Find all chunks and connections by going through the file from its start, past damage where there is some.

    indexed: whether the bag header points at an index inside the file (which then cannot be used).
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
    elif indexed:
        log.worsen("malformed", f"the bag's index at its end is damaged; without it {read}")
    else:
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
