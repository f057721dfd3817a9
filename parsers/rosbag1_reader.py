"""The reader of ROS 1 bags: index, chunks, decoded columns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from parsers.allocator import keep_freed_memory
from parsers.channels import ChannelInfo, Chunk
from parsers.errors import LogError
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.parallel import in_order
from parsers.ros.bag1_index import BagIndex, IndexState, read_index, search
from parsers.ros.bag1_read import ChunkReader, Lost, Wanted, following, jobs
from parsers.ros.bag1_records import MAGIC, OP_BAG_HEADER, read_record
from parsers.ros.clock import BagClock
from parsers.ros.contract import MISFIT
from parsers.ros.decoder import LayoutDecoder
from parsers.ros.fields import short_name
from parsers.ros.layout import Layout
from parsers.ros.program import make_program
from parsers.ros.stamps import StampChooser, is_wall_clock
from parsers.ros.topics import Topic, find_decoder, group_names


@dataclass
class RosBag1Reader(BagClock):
    """An opened bag. topics: by connection id; connections of one topic and type share one. layouts: of their types."""

    path: Path
    size: int
    index: BagIndex
    topics: dict[int, Topic]
    layouts: dict[int, Layout]
    options: ReadOptions
    log: ImportLog
    wall_clock: bool
    chooser: StampChooser = field(default_factory=StampChooser)

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """All numbers and texts of all topics whose type is known."""
        groups = {topic.group: topic for topic in self.topics.values()}
        return tuple(channel for topic in groups.values() for channel in topic.channels())

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels; chunks of the bag without any of them are not even read."""
        topics, chosen = self._wanted(wanted)
        if chosen is None:
            return
        keep_freed_memory()
        reader = ChunkReader(self.path, self.size, chosen, following(self.index.chunks))
        paths = [topic.wanted_paths(wanted) for topic in topics]
        names = [
            [f"{topic.group}.{path}" for path in found] for topic, found in zip(topics, paths, strict=True)
        ]
        for result in in_order(reader, jobs(self.index.chunks, chosen, self.size)):
            self.options.progress(result.last.start, self.size)
            for lost in result.lost:
                self._lose(lost)
            self.log.reject(MISFIT, result.bad)
            for block in result.blocks:
                topic = topics[block.topic]
                self.log.messages += len(block.receive_ns)
                stamp_ns = block.stamp_ns if topic.decoder.has_header else None
                time_ns = self.chooser.choose(topic.group, stamp_ns, block.receive_ns, in_place=True)
                yield Chunk(topic.group, time_ns, dict(zip(names[block.topic], block.columns, strict=True)))
        self.chooser.finish(self.log)

    def _wanted(self, wanted: frozenset[str]) -> tuple[list[Topic], Wanted | None]:
        """The topics with wanted channels, and what is wanted of them for a `ChunkReader`."""
        places: dict[str, int] = {}
        topics: list[Topic] = []
        programs: list[tuple[Layout, tuple[str, ...]]] = []
        ids: dict[int, int] = {}
        for number, topic in sorted(self.topics.items()):
            paths = topic.wanted_paths(wanted)
            if not paths:
                continue
            if topic.group not in places:
                places[topic.group] = len(topics)
                topics.append(topic)
                programs.append((self.layouts[number], paths))
            ids[number] = places[topic.group]
        if not topics:
            return topics, None
        depth = max(layout.depth for layout, _ in programs)
        return topics, Wanted(ids, make_program(programs, "ros1"), depth)

    def _lose(self, lost: Lost) -> None:
        """Write down what cannot be used, and the time that it took."""
        self.log.reject("damaged part of the bag")
        self.log.worsen("malformed", f"at byte {lost.ref.start}: {lost.what}")
        if lost.since is not None and lost.ref.last_ns is not None and lost.since <= lost.ref.last_ns:
            self.log.lost_spans_ns.append((lost.since, lost.ref.last_ns))


def open_bag(path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
    """Open a bag. Raises LogError where it is of another version, encrypted, or holds nothing."""
    size = path.stat().st_size
    with path.open("rb") as file:
        index = _index(file, path, size, options, log)
    if not index.chunks or not index.connections:
        raise LogError(
            f"no messages were found in this bag of {size} bytes",
            path=path,
            hint="check that the recording was copied whole; `rosbag info` says what it should hold",
        )
    first_ns = min((chunk.first_ns for chunk in index.chunks if chunk.first_ns is not None), default=None)
    wall_clock = is_wall_clock(first_ns, log)
    topics, layouts = _topics(index, log)
    reader = RosBag1Reader(path, size, index, topics, layouts, options, log, wall_clock)
    for topic in reader.topics.values():
        reader.chooser.add(topic.group, has_header=topic.decoder.has_header)
    return reader


def _index(file: BinaryIO, path: Path, size: int, options: ReadOptions, log: ImportLog) -> BagIndex:
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
    if index is not None and index.chunks:
        return index
    if header is None or header.op != OP_BAG_HEADER:
        log.worsen("malformed", f"at byte {len(MAGIC)}: the bag header is damaged")
    state: IndexState = "whole" if index is not None else "none"
    if index is None and header is not None and 0 < (header.u64("index_pos") or 0) < size:
        state = "damaged"
    return search(file, size, log, options.progress, state)


def _topics(index: BagIndex, log: ImportLog) -> tuple[dict[int, Topic], dict[int, Layout]]:
    """Topics and their types' layouts by connection id, without those whose type cannot be decoded."""
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
    decoders: dict[str, LayoutDecoder | None] = {}
    topics: dict[int, Topic] = {}
    layouts: dict[int, Layout] = {}
    for connection in connections:
        kind = kinds[connection.id]
        if kind[1] not in decoders:
            decoders[kind[1]] = find_decoder(connection.type_name, connection.definition, "ros1", log)
        decoder = decoders[kind[1]]
        if decoder is not None:
            type_name = short_name(connection.type_name)
            topics[connection.id] = Topic(names[kind], connection.topic, type_name, decoder, totals[kind])
            layouts[connection.id] = decoder.layout
    return topics, layouts
