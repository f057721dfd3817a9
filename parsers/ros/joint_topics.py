"""Joint states by the joints' names: `velocity[front_left_wheel_joint]` is a channel, whatever place the joint has in a message.

sensor_msgs/JointState lists names beside values, and several publishers may share a topic, each with joints of its own. So the names are
read with every message: their letters come as numbers out of the compiled decoder (`layout.letter_path`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ChannelInfo, Chunk, FloatArray
from parsers.importer import ImportLog, LogReader
from parsers.ros.frame_topics import Reopen
from parsers.ros.layout import JOINTS, LETTERS, letter_path
from parsers.ros.over import OverMessages

JOINT_TYPE = "sensor_msgs/JointState"
_VALUES = ("position", "velocity", "effort")
SAMPLE_ROWS = 400
SAMPLE_CHUNKS = 400
"""How much of a log is looked into for the names in it: rows of a chunk, and chunks."""


@dataclass(frozen=True)
class _Topic:
    """A topic's joints: names as bytes; how many places and letters a message's names have at the most. values: those that it has
    numbers of."""

    group: str
    names: tuple[bytes, ...]
    places: int
    letters: int
    values: tuple[str, ...]

    def letter_channels(self) -> list[str]:
        """What must be read to know the names, place by place."""
        return [f"{self.group}.{letter_path(k, j)}" for k in range(self.places) for j in range(self.letters)]


def channel_name(group: str, value: str, joint: bytes) -> str:
    """The name of a joint's channel."""
    return f"{group}.{value}[{joint.decode('utf-8', 'replace')}]"


def with_joint_names(reader: LogReader, reopen: Reopen, log: ImportLog) -> LogReader:
    """The reader, with a channel for each named joint of its joint states. A log without such topics is returned as it is.

    Raises LogError where the messages cannot be read.
    """
    groups = sorted({each.group for each in reader.channels if each.tags.get("type") == JOINT_TYPE})
    if not groups:
        return reader
    topics = _sampled(reopen(ImportLog()), groups)
    if not topics:
        return reader
    return JointNamesReader(reader, MappingProxyType({topic.group: topic for topic in topics}))


def _sampled(reader: LogReader, groups: Sequence[str]) -> list[_Topic]:
    """The joints of the first messages."""
    paths = [letter_path(k, j) for k in range(JOINTS) for j in range(LETTERS)]
    firsts = [f"{value}[0]" for value in _VALUES]
    wanted = frozenset(f"{group}.{path}" for group in groups for path in (*paths, *firsts))
    texts: dict[str, list[NDArray[np.uint8]]] = {group: [] for group in groups}
    values: dict[str, set[str]] = {group: set() for group in groups}
    chunks = reader.read(wanted)
    for number, chunk in enumerate(chunks):
        found = bytes_of(chunk, [f"{chunk.group}.{path}" for path in paths])
        if found is not None and chunk.group in texts:
            texts[chunk.group].append(np.unique(found[:SAMPLE_ROWS], axis=0))
            values[chunk.group] |= {
                value
                for value, first in zip(_VALUES, firsts, strict=True)
                if np.isfinite(chunk.columns.get(f"{chunk.group}.{first}", np.empty(0))).any()
            }
        if number >= SAMPLE_CHUNKS or all(len(each) >= 3 for each in texts.values()):
            break
    topics = (_topic(group, texts[group], values[group]) for group in groups if texts[group])
    return [topic for topic in topics if topic.names and topic.values]


def _topic(group: str, texts: Sequence[NDArray[np.uint8]], values: set[str]) -> _Topic:
    layouts = np.unique(np.concatenate(texts), axis=0).reshape(-1, JOINTS, LETTERS)
    names: dict[bytes, None] = {}
    twice: set[bytes] = set()
    places = 0
    for layout in layouts:
        own = [row.tobytes().partition(b"\0")[0] for row in layout]
        places = max([places, *(k + 1 for k, name in enumerate(own) if name)])
        names.update(dict.fromkeys(name for name in own if name))
        # of two joints of one name nobody knows which is which
        twice |= {name for name in own if own.count(name) > 1}
    letters = min(max(map(len, names), default=0) + 1, LETTERS)
    kept = tuple(
        name for name in names if name not in twice and name.isascii() and name.decode().isprintable()
    )
    return _Topic(group, kept, places, letters, tuple(value for value in _VALUES if value in values))


def bytes_of(chunk: Chunk, names: Sequence[str]) -> NDArray[np.uint8] | None:
    """Letters of the chunk's messages, (rows, letters), 0 where there is none; None where the chunk does not have them."""
    if any(name not in chunk.columns for name in names):
        return None
    letters = np.empty((len(names), len(chunk.time_ns)), np.uint8)
    for row, name in zip(letters, names, strict=True):
        # of a number and NaN it is the number
        np.fmax(chunk.columns[name], 0.0, out=row, casting="unsafe")
    return letters.T


@dataclass(frozen=True)
class JointNamesReader(OverMessages):
    """A `LogReader` over another, with the joints of its joint states by name."""

    topics: Mapping[str, _Topic]

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """The log's own, each topic's followed by its joints'."""
        found: list[ChannelInfo] = []
        own = self.inner.channels
        for place, info in enumerate(own):
            found.append(info)
            topic = self.topics.get(info.group)
            if topic is not None and (place + 1 == len(own) or own[place + 1].group != info.group):
                found += _joint_channels(info, topic)
        return tuple(found)

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels; joints' values are picked by the names of each message."""
        picks: dict[str, dict[str, tuple[str, bytes]]] = {}
        needed: set[str] = set()
        for group, topic in self.topics.items():
            own = {
                name: (value, joint)
                for value in topic.values
                for joint in topic.names
                if (name := channel_name(group, value, joint)) in wanted
            }
            if own:
                picks[group] = own
                needed |= {f"{group}.{value}[{k}]" for value, _ in own.values() for k in range(topic.places)}
                needed.update(topic.letter_channels())
        joints = {name for own in picks.values() for name in own}
        rest = wanted - joints
        for chunk in self.inner.read(frozenset(rest | needed)):
            if chunk.group not in picks:
                yield chunk
                continue
            columns = {name: values for name, values in chunk.columns.items() if name in rest}
            columns |= _picked(chunk, self.topics[chunk.group], picks[chunk.group])
            yield Chunk(chunk.group, chunk.time_ns, columns)


def _joint_channels(info: ChannelInfo, topic: _Topic) -> list[ChannelInfo]:
    """The channels of a topic's joints. info: one of the topic's own."""
    return [
        ChannelInfo(
            name=channel_name(topic.group, value, joint),
            group=topic.group,
            unit=None,
            family=info.family,
            count=info.count,
            tags=MappingProxyType({**info.tags, "field": value, "joint": joint.decode()}),
        )
        for value in topic.values
        for joint in topic.names
    ]


def _picked(chunk: Chunk, topic: _Topic, wanted: Mapping[str, tuple[str, bytes]]) -> dict[str, FloatArray]:
    """The wanted joints' values, NaN in messages that do not have the joint."""
    rows = len(chunk.time_ns)
    letters = bytes_of(chunk, topic.letter_channels())
    if letters is None:
        return {name: np.full(rows, np.nan) for name in wanted}
    # messages mostly list the same joints: layouts are compared once, and rows by their layout
    layouts, which = _layouts(letters)
    columns: dict[str, FloatArray] = {}
    for name, (value, joint) in wanted.items():
        target = np.zeros(topic.letters, np.uint8)
        target[: len(joint)] = np.frombuffer(joint, np.uint8)[: topic.letters]
        there = (layouts.reshape(-1, topic.places, topic.letters) == target).all(axis=2)
        place = np.where(there.any(axis=1), there.argmax(axis=1), -1)[which]
        column = np.full(rows, np.nan)
        for k in np.unique(place[place >= 0]).tolist():
            source = chunk.columns.get(f"{chunk.group}.{value}[{k}]")
            if source is not None:
                column = np.where(place == k, source, column)
        columns[name] = column
    return columns


def _layouts(letters: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.intp]]:
    """The different rows, and which of them each row is."""
    if len(letters) and (letters == letters[0]).all():
        return letters[:1], np.zeros(len(letters), np.intp)
    found, which = np.unique(letters, axis=0, return_inverse=True)
    return found, which.reshape(-1)
