"""Topics of an MCAP file and the decoders of their messages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import ChannelInfo, Family, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.json_decode import (
    SAMPLES,
    JsonDecoder,
    make_json_decoder,
    needs_samples,
    numbers_as_texts,
)
from parsers.mcap_chunks import ChunkSpan, McapFile, Span
from parsers.mcap_messages import holds, messages_in
from parsers.mcap_records import ChannelRecord, SchemaRecord
from parsers.mcap_survey import Survey
from parsers.protobuf_decode import ProtobufDecoder, make_protobuf_decoder
from parsers.ros.contract import MessageDecoder
from parsers.ros.fields import Encoding
from parsers.ros.packed import UnpackingDecoder
from parsers.ros.topics import Topic, find_decoder, group_names

_NO_SCHEMA = SchemaRecord(0, "", "", b"")
_IDL = ("ros2idl", "omgidl")
_LARGE_SAMPLE = 1 << 20
_SAMPLE_CHUNKS = 4
ENCODINGS = ("ros1", "cdr", "json", "protobuf")


@dataclass(frozen=True)
class Source:
    """A topic, and the ids of the MCAP channels that carry it."""

    topic: Topic
    ids: tuple[int, ...]

    def channels(self) -> list[ChannelInfo]:
        """The topic's channels, with the family that mapping profiles go by."""
        family: Family = "json" if isinstance(self.topic.decoder, (JsonDecoder, ProtobufDecoder)) else "ros"
        return [replace(channel, family=family) for channel in self.topic.channels()]

    def notes(self) -> Sequence[str]:
        """What the decoder has to say of the messages."""
        decoder = self.topic.decoder
        return decoder.notes if isinstance(decoder, (JsonDecoder, ProtobufDecoder)) else ()


@dataclass(frozen=True)
class _Stream:
    """What makes messages alike: topic, encoding and type."""

    topic: str
    encoding: str
    schema: SchemaRecord

    @property
    def type_name(self) -> str:
        """ "sensor_msgs/Imu" for "sensor_msgs/msg/Imu", whatever the encoding; other names as they are."""
        return self.schema.name.replace("/msg/", "/", 1)


def _streams(survey: Survey, log: ImportLog) -> dict[_Stream, list[ChannelRecord]]:
    """The channels of the file, those that carry the same stream together."""
    found: dict[_Stream, list[ChannelRecord]] = {}
    for channel in survey.definitions.channels.values():
        schema = survey.definitions.schemas.get(channel.schema_id)
        if schema is None and channel.schema_id:
            log.note(f"topic {channel.topic}: the file does not have its schema {channel.schema_id}")
        schema = replace(schema, id=0) if schema else _NO_SCHEMA
        found.setdefault(_Stream(channel.topic, channel.message_encoding, schema), []).append(channel)
    return found


def _spread(rows: IntArray, count: int, shift: float) -> IntArray:
    """So many of some rows: the first ones, and others all over the rest, by `shift` (0 to 1) of their distance further."""
    ahead = count // 3
    if len(rows) <= count:
        return rows
    rest = rows[ahead:]
    at = ((np.arange(count - ahead) + shift) * len(rest) / (count - ahead)).astype(np.int64)
    return np.concatenate([rows[:ahead], rest[at]])


def _sample_span(
    file: McapFile,
    span: Span,
    found: dict[int, list[bytes]],
    missing: set[int],
    enough: int,
    shift: float,
) -> None:
    """Collect payloads of the missing channels from one span; those that have enough are missing no more."""
    for messages in messages_in(file, span, frozenset(missing)):
        for channel in sorted(missing):
            rows = np.flatnonzero((messages.channel == channel) & (messages.length <= _LARGE_SAMPLE))
            for i in _spread(rows, enough - len(found[channel]), shift).tolist():
                start = int(messages.offset[i])
                found[channel].append(messages.data[start : start + int(messages.length[i])].tobytes())
        missing -= {channel for channel in missing if len(found[channel]) >= enough}
        if not missing:
            return


def _samples(file: McapFile, survey: Survey, ids: frozenset[int]) -> dict[int, list[bytes]]:
    """Some messages of channels, by channel id: of the first chunks and of the last one that has any.

    A key may come up late, when a sensor is ready: not only a chunk's first messages are looked at.
    """
    found: dict[int, list[bytes]] = {channel: [] for channel in ids}
    missing = {channel for channel in ids if survey.counts is None or survey.counts.get(channel)}
    looked: dict[int, int] = dict.fromkeys(ids, 0)
    for span in survey.spans:
        if not missing:
            break
        if not holds(span, frozenset(missing)):
            continue
        _sample_span(file, span, found, missing, SAMPLES // 2, 0.9)
        # a few chunks are enough where messages are rare
        for channel in found:
            looked[channel] += bool(found[channel])
        missing -= {channel for channel, spans in looked.items() if spans >= _SAMPLE_CHUNKS}
    last = next((s for s in reversed(survey.spans) if isinstance(s, ChunkSpan) and holds(s, ids)), None)
    if last is not None:
        _sample_span(file, last, found, set(ids), SAMPLES, 0.4)
    return found


def _decoder(stream: _Stream, samples: list[bytes], log: ImportLog) -> MessageDecoder | None:
    """The decoder for a stream of a known encoding; None, with a note, where its definition cannot be used."""
    schema = stream.schema
    if stream.encoding in ("ros1", "cdr"):
        encoding: Encoding = "ros1" if stream.encoding == "ros1" else "cdr"
        form = "idl" if schema.encoding in _IDL else "msg"
        decoder = find_decoder(schema.name, schema.data.decode("utf-8", "replace"), encoding, log, form)
        return decoder if decoder is None or encoding == "ros1" else UnpackingDecoder(decoder)
    try:
        if stream.encoding == "protobuf":
            return make_protobuf_decoder(schema.name, schema.data)
        made = make_json_decoder(schema.data if schema.encoding == "jsonschema" else b"", samples)
        if texts := numbers_as_texts(made):
            log.note(
                f"topic {stream.topic}: numbers in quotes are texts in JSON and not read: {', '.join(texts[:6])}{', …' if len(texts) > 6 else ''}"
            )
        return made
    except LogError as error:
        log.note(f"topic {stream.topic} was left out: {error.problem}")
        return None


def _left_out(streams: dict[_Stream, list[ChannelRecord]], log: ImportLog) -> None:
    """Name the topics whose encoding cogest does not read."""
    topics: dict[str, list[str]] = {}
    for stream in streams:
        if stream.encoding not in ENCODINGS:
            topics.setdefault(stream.encoding, []).append(stream.topic)
    for encoding, names in topics.items():
        more = f" and {len(names) - 6} more" if len(names) > 6 else ""
        log.note(
            f"messages in the encoding {encoding!r} are not read (cogest reads {', '.join(ENCODINGS)}): "
            f"{', '.join(names[:6])}{more}"
        )


def sources_of(file: McapFile, survey: Survey, log: ImportLog) -> list[Source]:
    """The topics that can be read. Raises LogError where there is none; notes say why others are left out."""
    streams = _streams(survey, log)
    _left_out(streams, log)
    usable = {stream: channels for stream, channels in streams.items() if stream.encoding in ENCODINGS}
    unclear = frozenset(
        channel.id
        for stream, channels in usable.items()
        if stream.encoding == "json" and needs_samples(stream.schema.data)
        for channel in channels
    )
    samples = _samples(file, survey, unclear) if unclear else {}
    groups = group_names(
        (stream.topic, f"{stream.type_name} {number}") for number, stream in enumerate(usable)
    )
    sources: list[Source] = []
    for number, (stream, channels) in enumerate(usable.items()):
        ids = tuple(channel.id for channel in channels)
        decoder = _decoder(stream, [text for channel in ids for text in samples.get(channel, [])], log)
        if decoder is None:
            continue
        count = None if survey.counts is None else sum(survey.counts.get(channel, 0) for channel in ids)
        group = groups[stream.topic, f"{stream.type_name} {number}"]
        sources.append(Source(Topic(group, stream.topic, stream.type_name, decoder, count), ids))
    if not sources:
        raise LogError(
            _nothing(streams, log), path=file.path, hint="check what the recorder was set to record"
        )
    return sources


def _nothing(streams: dict[_Stream, list[ChannelRecord]], log: ImportLog) -> str:
    if not streams:
        why = log.notes[-1] if log.notes else "it holds no messages"
        return f"the MCAP file has no topic ({why})"
    return f"no topic of the MCAP file can be read ({log.notes[-1] if log.notes else 'all are empty'})"
