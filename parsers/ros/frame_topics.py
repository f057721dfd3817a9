"""CAN frames that travel as ROS messages (can_msgs/Frame): decoded with a database like those of any CAN log.

Bridges between a bus and ROS (ros_canopen, ros2_socketcan, Dataspeed's and AutonomouStuff's drivers) publish each frame as a
message; a vehicle's own sensors are then in the bag only as payloads. Sources: can_msgs/Frame.msg of ros_canopen
(`id` without flags, `dlc`, `data` of eight bytes).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from parsers.can.frames import EXTENDED, CanFrames
from parsers.channels import ChannelInfo, Chunk, FloatArray
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.ros.over import OverMessages

FRAME_TYPE = "can_msgs/Frame"
_PAYLOAD = 8
_BYTES = tuple(f"data[{place}]" for place in range(_PAYLOAD))
_NEEDED = ("id", "is_rtr", "is_extended", "is_error", "dlc", *_BYTES)
_STANDARD_IDS = 1 << 11
_ID_BITS = (1 << 29) - 1

Reopen = Callable[[ImportLog], LogReader]
"""Opens the log once more, with a log book of its own."""


def with_frame_topics(
    reader: LogReader, reopen: Reopen, options: ReadOptions, log: ImportLog, path: Path
) -> LogReader:
    """The reader, with the signals of frames that travel as messages where a database is there to decode them.

    A log without such topics, or opened without a database, is returned as it is; in the latter case the log book says
    what a database would be of use for. Raises DatabaseError where a database cannot be used, LogError where
    the frames cannot be read.
    """
    topics = _frame_topics(reader.channels)
    if not topics:
        return reader
    if not options.dbc:
        log.note(
            f"CAN frames travel as messages in {', '.join(topics[:4])} ({FRAME_TYPE}): "
            "name their database with --dbc FILE, and their signals are decoded"
        )
        return reader
    if len(topics) > 1:
        buses = ", ".join(f"bus {place} is {topic}" for place, topic in enumerate(topics, start=1))
        log.note(f"CAN frames travel as messages: {buses}")
    # only here, since the decoder of frames takes a while to import
    from parsers.can.reader import CanReader

    source = _TopicFrames(reader, reopen, tuple(topics), log)
    return FrameTopicsReader(reader, CanReader(source, options, log, path), frozenset(topics))


def _frame_topics(channels: Sequence[ChannelInfo]) -> list[str]:
    """Groups of messages that hold a whole frame, in the log's order."""
    fields: dict[str, set[str]] = {}
    for info in channels:
        if info.kind == "number" and info.tags.get("type") == FRAME_TYPE:
            fields.setdefault(info.group, set()).add(info.tags.get("field", ""))
    return [group for group, found in fields.items() if found.issuperset(_NEEDED)]


@dataclass(frozen=True)
class FrameTopicsReader(OverMessages):
    """A `LogReader` over a log's messages and over the signals of the frames in some of its topics."""

    frames: LogReader
    topics: frozenset[str]

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """Messages' fields first, then what databases make of frames."""
        known = self.inner.channels
        names = {info.name for info in known}
        return known + tuple(info for info in self.frames.channels if info.name not in names)

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels: messages' own first, then frames'."""
        own = wanted & {info.name for info in self.inner.channels}
        if own:
            yield from self.inner.read(own)
        rest = wanted - own
        if rest:
            yield from self.frames.read(rest)


@dataclass(frozen=True)
class _TopicFrames(OverMessages):
    """A `FrameSource` over the topics' messages; the first topic is bus 1."""

    reopen: Reopen
    topics: tuple[str, ...]
    log: ImportLog

    def frames(self, *, counting: bool) -> Iterator[CanFrames]:
        """Yield the topics' frames; with counting also into the log book."""
        book = ImportLog()
        bus = {topic: place for place, topic in enumerate(self.topics, start=1)}
        wanted = frozenset(f"{topic}.{name}" for topic in self.topics for name in _NEEDED)
        for chunk in self.reopen(book).read(wanted):
            fields = {name: chunk.columns[f"{chunk.group}.{name}"] for name in _NEEDED}
            yield _frames(chunk, fields, bus[chunk.group], book)
        if counting:
            self.log.take_over(book)


def _frames(chunk: Chunk, fields: dict[str, FloatArray], bus: int, book: ImportLog) -> CanFrames:
    """A chunk's data frames; error and remote frames, and messages that could not be read, are counted."""
    error, remote = fields["is_error"] > 0, fields["is_rtr"] > 0
    whole = np.isfinite(fields["id"])
    book.reject("error frame", int(np.count_nonzero(whole & error)))
    book.reject("remote frame", int(np.count_nonzero(whole & remote & ~error)))
    rows = np.flatnonzero(whole & ~error & ~remote)
    stated = fields["id"][rows].astype(np.uint32)
    # some drivers leave socketcan's flags in the number
    number = stated & np.uint32(_ID_BITS)
    long = (fields["is_extended"][rows] > 0) | (stated >= EXTENDED) | (number >= _STANDARD_IDS)
    data = np.empty((len(rows), _PAYLOAD), np.uint8)
    for place, name in enumerate(_BYTES):
        data[:, place] = fields[name][rows]
    return CanFrames(
        time_ns=chunk.time_ns[rows],
        can_id=np.where(long, number | np.uint32(EXTENDED), number).astype(np.uint32),
        bus=np.full(len(rows), bus, np.int16),
        length=np.minimum(fields["dlc"][rows], _PAYLOAD).astype(np.uint8),
        offset=np.arange(len(rows), dtype=np.int64) * _PAYLOAD,
        data=data.reshape(-1),
    )
