"""The summary section at the end of an MCAP file: channels, schemas, the chunk index and the recorder's counts."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

from parsers.channels import ByteArray
from parsers.importer import ImportLog
from parsers.mcap_chunks import McapFile
from parsers.mcap_records import (
    CHANNEL,
    CHUNK_INDEX,
    FOOTER,
    MAGIC,
    RECORD_HEAD,
    SCHEMA,
    STATISTICS,
    BadRecordError,
    ChannelRecord,
    ChunkIndexRecord,
    Records,
    SchemaRecord,
    StatisticsRecord,
    Walker,
    parse_channel,
    parse_chunk_index,
    parse_schema,
    parse_statistics,
)

FOOTER_BYTES = RECORD_HEAD + 20
MAX_SUMMARY_BYTES = 1 << 28


@dataclass
class Definitions:
    """The schemas and channels of a file by their ids; the first definition of an id holds."""

    schemas: dict[int, SchemaRecord] = field(default_factory=dict)
    channels: dict[int, ChannelRecord] = field(default_factory=dict)

    def take(self, opcode: int, content: bytes) -> None:
        """Take a schema or channel record in. Raises BadRecordError."""
        if opcode == SCHEMA:
            schema = parse_schema(content)
            self.schemas.setdefault(schema.id, schema)
        else:
            channel = parse_channel(content)
            self.channels.setdefault(channel.id, channel)

    def is_known(self, channel: int) -> bool:
        """Whether a channel and its schema are defined."""
        record = self.channels.get(channel)
        return record is not None and (not record.schema_id or record.schema_id in self.schemas)


@dataclass
class Summary:
    """data_end: where the data section ends. broken_off: there is no footer."""

    data_end: int
    definitions: Definitions = field(default_factory=Definitions)
    chunks: list[ChunkIndexRecord] = field(default_factory=list)
    statistics: StatisticsRecord | None = None
    broken_off: bool = False

    @property
    def names_all(self) -> bool:
        """Whether it says that there is no chunk, and names every channel that has messages."""
        known = self.statistics
        if known is None or known.chunk_count or self.chunks or (known.message_count and not known.counts):
            return False
        return all(self.definitions.is_known(channel) for channel in known.counts)


def read_summary(file: McapFile, log: ImportLog) -> Summary:
    """The summary of a file; an empty one, with a line in the log book, where it is damaged."""
    nothing = Summary(file.size)
    at = file.size - FOOTER_BYTES - len(MAGIC)
    tail = file.bytes(max(at, 0), FOOTER_BYTES + len(MAGIC))
    if at <= len(MAGIC) or not tail.endswith(MAGIC) or tail[0] != FOOTER:
        nothing.broken_off = True
        return nothing
    length, start, _, crc = struct.unpack_from("<QQQI", tail, 1)
    if length != FOOTER_BYTES - RECORD_HEAD or start >= at or 0 < start <= len(MAGIC):
        log.worsen("malformed", "the footer is damaged; the records were read without the index")
        return nothing
    if not start:
        return Summary(at)
    if at - start > MAX_SUMMARY_BYTES:
        log.note(f"the summary is {at - start} bytes long and was not used")
        return Summary(start)
    raw = file.array(start, at - start)
    if crc and zlib.crc32(tail[: RECORD_HEAD + 16], zlib.crc32(raw.data)) != crc:
        log.worsen("malformed", "the index at the end is damaged (wrong checksum) and was not used")
        return nothing
    summary = Summary(start)
    try:
        for records in Walker().walk(raw):
            _take(raw, records, summary)
    except BadRecordError as error:
        log.worsen("malformed", f"the index at the end is damaged ({error}) and was not used")
        return nothing
    return summary


def _take(raw: ByteArray, records: Records, summary: Summary) -> None:
    for opcode, offset, length in zip(
        records.opcode.tolist(), records.offset.tolist(), records.length.tolist(), strict=True
    ):
        if opcode not in (SCHEMA, CHANNEL, CHUNK_INDEX, STATISTICS):
            continue
        content = raw[offset : offset + length].tobytes()
        if opcode == CHUNK_INDEX:
            summary.chunks.append(parse_chunk_index(content))
        elif opcode == STATISTICS:
            summary.statistics = parse_statistics(content)
        else:
            summary.definitions.take(opcode, content)
