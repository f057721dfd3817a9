"""ROS 1 bags (format 2.0; chunks uncompressed, bz2 or lz4; with or without an index)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np

from parsers.channels import ChannelInfo, Chunk, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.ros.bag1_chunks import ChunkError, ChunkRef, Walk, load_chunk
from parsers.ros.bag1_index import BagIndex, read_index, search
from parsers.ros.bag1_records import MAGIC, OP_BAG_HEADER, read_record
from parsers.ros.contract import MessageDecoder
from parsers.ros.grammar import short_name
from parsers.ros.stamps import StampChooser, is_wall_clock
from parsers.ros.topics import Topic, decode_chunks, find_decoder, group_names

BATCH_BYTES = 1 << 23
"""Chunks are decoded together until they hold this much: a bag of small chunks costs no more than one of large."""


@dataclass
class RosBag1Reader:
    """An opened bag. topics: by connection id; connections of one topic and type share one."""

    path: Path
    size: int
    index: BagIndex
    topics: dict[int, Topic]
    options: ReadOptions
    log: ImportLog
    wall_clock: bool
    chooser: StampChooser = field(default_factory=StampChooser)

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """All numbers and texts of all topics whose type is known."""
        groups = {topic.group: topic for topic in self.topics.values()}
        return tuple(channel for topic in groups.values() for channel in topic.channels())

    @property
    def clock(self) -> str:
        """Which clock the stamps are from."""
        return self.chooser.clock

    @property
    def absolute(self) -> bool:
        """Whether stamps count from 1970: not in bags of simulated time."""
        return self.wall_clock

    @property
    def start_utc_ns(self) -> int | None:
        """Not needed: stamps are absolute."""
        return None

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels; chunks of the bag without any of them are not even read."""
        paths = {conn: topic.wanted_paths(wanted) for conn, topic in self.topics.items()}
        paths = {conn: found for conn, found in paths.items() if found}
        ids = np.array(sorted(paths), dtype=np.int64)
        batch: list[Walk] = []
        held = 0
        with self.path.open("rb") as file:
            for ref in self.index.chunks:
                if ref.counts is not None and not any(ref.counts.get(conn) for conn in paths):
                    continue
                walk = self._load(file, ref)
                if walk is None:
                    continue
                self.options.progress(ref.start, self.size)
                batch.append(walk)
                held += len(walk.data)
                if held >= BATCH_BYTES:
                    yield from self._decode(batch, ids, paths)
                    batch, held = [], 0
            yield from self._decode(batch, ids, paths)
        self.chooser.finish(self.log)

    def _load(self, file: BinaryIO, ref: ChunkRef) -> Walk | None:
        """One chunk, or None where it is damaged; what was lost goes into the log book."""
        try:
            walk = load_chunk(file, ref, self.size)
        except ChunkError as error:
            self._lose(ref, ref.first_ns, f"a chunk was left out: {error}")
            return None
        if not walk.complete and ref.whole:
            messages = walk.time_ns[walk.conn >= 0]
            since = int(messages[-1]) if len(messages) else ref.first_ns
            self._lose(
                ref, since, f"a chunk is damaged after {len(messages)} messages; the rest of it was left out"
            )
        return walk

    def _lose(self, ref: ChunkRef, since: int | None, what: str) -> None:
        self.log.reject("damaged part of the bag")
        self.log.worsen("malformed", f"at byte {ref.start}: {what}")
        if since is not None and ref.last_ns is not None and since <= ref.last_ns:
            self.log.lost_spans_ns.append((since, ref.last_ns))

    def _decode(self, batch: list[Walk], ids: IntArray, paths: dict[int, tuple[str, ...]]) -> Iterator[Chunk]:
        """Decode the wanted messages of some chunks, topic by topic."""
        if not batch or not len(ids):
            return
        base = np.cumsum([0] + [len(walk.data) for walk in batch[:-1]])
        data = np.concatenate([walk.data for walk in batch])
        conn = np.concatenate([walk.conn for walk in batch])
        time_ns = np.concatenate([walk.time_ns for walk in batch])
        offset = np.concatenate([walk.offset + start for walk, start in zip(batch, base, strict=True)])
        length = np.concatenate([walk.length for walk in batch])
        place = np.minimum(np.searchsorted(ids, conn), len(ids) - 1)
        groups: dict[str, list[int]] = {}
        for i, number in enumerate(ids.tolist()):
            groups.setdefault(self.topics[number].group, []).append(i)
        chosen = ids[place] == conn
        for members in groups.values():
            rows = np.flatnonzero(chosen & np.isin(place, members))
            if len(rows):
                number = int(ids[members[0]])
                messages = (offset[rows], length[rows], time_ns[rows])
                yield from decode_chunks(
                    self.topics[number], paths[number], data, messages, self.chooser, self.log
                )


class RosBag1Importer:
    """ROS 1 bags."""

    name = "rosbag1"
    title = "ROS 1 bag"
    suffixes = (".bag",)

    def claims(self, path: Path, head: bytes) -> bool:
        """By the magic bytes, of any version."""
        return head.startswith(b"#ROSBAG V")

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        """Open a bag. Raises LogError where it is of another version, encrypted, or holds nothing."""
        size = path.stat().st_size
        with path.open("rb") as file:
            index = self._index(file, path, size, options, log)
        if not index.chunks or not index.connections:
            raise LogError(
                f"no messages were found in this bag of {size} bytes",
                path=path,
                hint="check that the recording was copied whole; `rosbag info` says what it should hold",
            )
        first_ns = min((chunk.first_ns for chunk in index.chunks if chunk.first_ns is not None), default=None)
        wall_clock = is_wall_clock(first_ns, log)
        reader = RosBag1Reader(path, size, index, _topics(index, log), options, log, wall_clock)
        for topic in reader.topics.values():
            reader.chooser.add(topic.group, has_header=topic.decoder.has_header)
        return reader

    def _index(self, file: BinaryIO, path: Path, size: int, options: ReadOptions, log: ImportLog) -> BagIndex:
        magic = file.read(len(MAGIC))
        if magic != MAGIC:
            raise LogError(
                f"a ROS bag of a version that cogest does not know ({magic[:12]!r}, expected {MAGIC[:12]!r})",
                path=path,
                hint="convert it with `rosbag migrate`",
            )
        header = read_record(file, len(MAGIC), size)
        if header is not None and header.op == OP_BAG_HEADER and header.fields.get("encryptor"):
            raise LogError("the bag is encrypted", path=path, hint="decrypt it with `rosbag decrypt`")
        index = read_index(file, size)
        if index is not None:
            return index
        if header is None or header.op != OP_BAG_HEADER:
            log.worsen("malformed", f"at byte {len(MAGIC)}: the bag header is damaged")
        indexed = header is not None and 0 < (header.u64("index_pos") or 0) < size
        return search(file, size, log, options.progress, indexed=indexed)


def _topics(index: BagIndex, log: ImportLog) -> dict[int, Topic]:
    """Topics by connection id, without those whose type cannot be decoded."""
    counts: dict[int, int] = {}
    for chunk in index.chunks:
        for conn, count in (chunk.counts or {}).items():
            counts[conn] = counts.get(conn, 0) + count
    lost = sum(count for conn, count in counts.items() if conn not in index.connections)
    log.reject("message of a topic whose description is lost", lost)
    connections = sorted(index.connections.values(), key=lambda connection: connection.id)
    kinds = {c.id: (c.topic, f"{c.type_name} {c.md5}") for c in connections}
    names = group_names(kinds.values())
    totals: dict[tuple[str, str], int] = {}
    for conn, kind in kinds.items():
        totals[kind] = totals.get(kind, 0) + counts.get(conn, 0)
    decoders: dict[str, MessageDecoder | None] = {}
    topics: dict[int, Topic] = {}
    for connection in connections:
        kind = kinds[connection.id]
        if kind[1] not in decoders:
            decoders[kind[1]] = find_decoder(connection.type_name, connection.definition, "ros1", log)
        decoder = decoders[kind[1]]
        if decoder is not None:
            type_name = short_name(connection.type_name)
            topics[connection.id] = Topic(names[kind], connection.topic, type_name, decoder, totals[kind])
    return topics
