"""Topics of a log as channels, and batches of their messages as chunks: what all containers of ROS messages share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from types import MappingProxyType

from parsers.channels import ByteArray, ChannelInfo, Chunk, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.ros.contract import FieldInfo, MessageDecoder
from parsers.ros.decoder import LayoutDecoder, make_decoder, make_standard_decoder
from parsers.ros.fields import Encoding, short_name
from parsers.ros.stamps import StampChooser

MAX_CELLS = 1 << 22
"""Numbers decoded at once: a batch of a type with many fields has fewer rows."""


@dataclass(frozen=True)
class Topic:
    """One topic with one message type. group: its name among the log's groups, usually the topic itself."""

    group: str
    topic: str
    type_name: str
    decoder: MessageDecoder
    count: int | None = None

    def channels(self) -> list[ChannelInfo]:
        """The topic's channels, numbers and texts."""
        return [
            ChannelInfo(
                name=f"{self.group}.{info.path}",
                group=self.group,
                unit=info.unit,
                family="ros",
                kind="text" if info.kind == "text" else "number",
                count=self.count,
                comment=info.comment,
                tags=MappingProxyType(self._tags(info)),
            )
            for info in self.decoder.fields
            if info.kind != "letter"
        ]

    def _tags(self, info: FieldInfo) -> dict[str, str]:
        tags = {"topic": self.topic, "type": self.type_name, "field": info.path}
        return tags | {"element": info.element} if info.element else tags

    def wanted_paths(self, wanted: frozenset[str]) -> tuple[str, ...]:
        """Field paths of this topic among wanted channel names."""
        return tuple(
            info.path
            for info in self.decoder.fields
            if info.kind != "text" and f"{self.group}.{info.path}" in wanted
        )


def find_decoder(
    type_name: str, definition: str, encoding: Encoding, log: ImportLog, definition_format: str = "msg"
) -> LayoutDecoder | None:
    """A decoder for a type as a log defines it; without a definition the standard type of that name.

    None, with a note, where there is neither: the caller leaves the topics of that type out.
    """
    try:
        if definition.strip():
            return make_decoder(type_name, definition, encoding, definition_format)
        decoder = make_standard_decoder(type_name, encoding)
    except LogError as error:
        log.note(f"message type {short_name(type_name)} was left out: {error.problem}")
        return None
    if decoder is None:
        log.note(
            f"message type {short_name(type_name)} was left out: "
            "the log holds no definition of it, and it is no standard type"
        )
    return decoder


def group_names(topics: Iterable[tuple[str, str]]) -> dict[tuple[str, str], str]:
    """(topic, type) -> group: the topic alone for its first type, "topic (type)" for any further one.

    What follows a type's name after a space (its hash) tells types apart and is not shown.
    """
    names: dict[tuple[str, str], str] = {}
    taken: set[str] = set()
    for topic, type_name in topics:
        if (topic, type_name) in names:
            continue
        name = topic if topic not in taken else f"{topic} ({short_name(type_name.split()[0])})"
        while name in taken:
            name += "'"
        taken.add(name)
        names[topic, type_name] = name
    return names


def decode_chunk(
    topic: Topic,
    paths: tuple[str, ...],
    data: ByteArray,
    messages: tuple[IntArray, IntArray, IntArray],
    chooser: StampChooser,
    log: ImportLog,
) -> Chunk:
    """Decode a batch of one topic's messages: (offset, length, receive_ns), each of shape (n,)."""
    offset, length, receive_ns = messages
    decoded = topic.decoder.decode(data, offset, length, paths)
    log.messages += len(offset)
    log.reject(decoded.why_bad, decoded.bad)
    time_ns = chooser.choose(topic.group, decoded.stamp_ns, receive_ns, unread=decoded.bad)
    return Chunk(topic.group, time_ns, {f"{topic.group}.{path}": x for path, x in decoded.columns.items()})


def decode_chunks(
    topic: Topic,
    paths: tuple[str, ...],
    data: ByteArray,
    messages: tuple[IntArray, IntArray, IntArray],
    chooser: StampChooser,
    log: ImportLog,
) -> Iterator[Chunk]:
    """Like `decode_chunk`, but at most MAX_CELLS numbers at a time: small messages can have thousands of fields."""
    rows = max(1, MAX_CELLS // max(1, len(paths)))
    for start in range(0, len(messages[0]), rows):
        offset, length, receive_ns = (column[start : start + rows] for column in messages)
        yield decode_chunk(topic, paths, data, (offset, length, receive_ns), chooser, log)
