"""MCAP records: their layout, and a kernel that walks over them.

Source: the MCAP specification, https://mcap.dev/spec. A record is an opcode (1 byte), a length (8 bytes) and that
many bytes; all integers are little-endian; strings and maps have a 4-byte length in front.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel, load_u16, load_u64

MAGIC = b"\x89MCAP0\r\n"
RECORD_HEAD = 9
MESSAGE_HEAD = 22
CHUNK_HEAD = 40
"""Bytes of a chunk record before its records when the compression's name is empty."""

FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x02, 0x03, 0x04, 0x05, 0x06
MESSAGE_INDEX, CHUNK_INDEX, STATISTICS, DATA_END = 0x07, 0x08, 0x0B, 0x0F

RECORDS_AT_ONCE = 1 << 17
WALK_DONE, WALK_FULL, WALK_CUT, WALK_INVALID, WALK_DATA_END = 0, 1, 2, 3, 4


_CHUNK_HEAD = struct.Struct("<QQQII")
_CHUNK_INDEX = struct.Struct("<QQQQI")
_CHUNK_OFFSET = struct.Struct("<HQ")


class BadRecordError(ValueError):
    """A record's content does not fit its layout."""


@dataclass(frozen=True)
class SchemaRecord:
    """A message type: its name, how it is written down ("ros1msg", "protobuf" …) and the definition."""

    id: int
    name: str
    encoding: str
    data: bytes


@dataclass(frozen=True)
class ChannelRecord:
    """A topic's stream of messages. schema_id 0: none."""

    id: int
    schema_id: int
    topic: str
    message_encoding: str


@dataclass(frozen=True)
class ChunkHead:
    """What stands before a chunk's records. records_at: offset of the records inside the record's content."""

    start_ns: int
    end_ns: int
    uncompressed_size: int
    crc: int
    compression: str
    records_length: int
    records_at: int


@dataclass(frozen=True)
class ChunkIndexRecord:
    """Where a chunk is, and which channels are in it (None: the index does not say)."""

    start_ns: int
    end_ns: int
    offset: int
    length: int
    index_length: int
    channels: frozenset[int] | None


@dataclass(frozen=True)
class StatisticsRecord:
    """The recorder's own count. counts: channel id -> messages."""

    message_count: int
    chunk_count: int
    start_ns: int
    end_ns: int
    counts: dict[int, int]


class _Fields:
    """Reads fields one after the other and refuses to read past the end."""

    def __init__(self, content: bytes) -> None:
        self.content = content
        self.at = 0

    def number(self, code: str) -> int:
        size = struct.calcsize("<" + code)
        if self.at + size > len(self.content):
            raise BadRecordError(f"{size} bytes wanted at byte {self.at} of a record of {len(self.content)}")
        value = struct.unpack_from("<" + code, self.content, self.at)[0]
        self.at += size
        return int(value)

    def data(self) -> bytes:
        length = self.number("I")
        if length > len(self.content) - self.at:
            raise BadRecordError(f"a field of {length} bytes in a record of {len(self.content)}")
        self.at += length
        return self.content[self.at - length : self.at]

    def text(self) -> str:
        return self.data().decode("utf-8", "replace")


def parse_schema(content: bytes) -> SchemaRecord:
    """Raises BadRecordError."""
    fields = _Fields(content)
    return SchemaRecord(fields.number("H"), fields.text(), fields.text(), fields.data())


def parse_channel(content: bytes) -> ChannelRecord:
    """Raises BadRecordError. The metadata map is not looked at."""
    fields = _Fields(content)
    return ChannelRecord(fields.number("H"), fields.number("H"), fields.text(), fields.text())


def parse_chunk_head(content: bytes) -> ChunkHead:
    """From the first bytes of a chunk's content. Raises BadRecordError."""
    if len(content) < CHUNK_HEAD:
        raise BadRecordError(f"a chunk of {len(content)} bytes")
    start, end, size, crc, name_length = _CHUNK_HEAD.unpack_from(content)
    at = _CHUNK_HEAD.size + name_length + 8
    if at > len(content):
        raise BadRecordError(f"a compression's name of {name_length} bytes in a record of {len(content)}")
    name = content[_CHUNK_HEAD.size : at - 8].decode("utf-8", "replace")
    return ChunkHead(start, end, size, crc, name, int.from_bytes(content[at - 8 : at], "little"), at)


def parse_chunk_index(content: bytes) -> ChunkIndexRecord:
    """Raises BadRecordError."""
    if len(content) < _CHUNK_INDEX.size:
        raise BadRecordError(f"a chunk index of {len(content)} bytes")
    start, end, offset, length, map_length = _CHUNK_INDEX.unpack_from(content)
    behind = _CHUNK_INDEX.size + map_length
    if map_length % _CHUNK_OFFSET.size or behind + 8 > len(content):
        raise BadRecordError(f"a map of {map_length} bytes in a record of {len(content)}")
    pairs = _CHUNK_OFFSET.iter_unpack(content[_CHUNK_INDEX.size : behind])
    index_length = int.from_bytes(content[behind : behind + 8], "little")
    known = frozenset(channel for channel, _ in pairs) if index_length else None
    return ChunkIndexRecord(start, end, offset, length, index_length, known)


def parse_statistics(content: bytes) -> StatisticsRecord:
    """Raises BadRecordError."""
    fields = _Fields(content)
    messages = fields.number("Q")
    fields.number("H"), fields.number("I"), fields.number("I"), fields.number("I")
    chunks, start, end = fields.number("I"), fields.number("Q"), fields.number("Q")
    pairs = _Fields(fields.data())
    counts: dict[int, int] = {}
    while pairs.at < len(pairs.content):
        channel = pairs.number("H")
        counts[channel] = pairs.number("Q")
    return StatisticsRecord(messages, chunks, start, end, counts)


@lean_kernel
def _long(data: ByteArray, at: int) -> int:
    """A little-endian integer of 8 bytes, as int64; the caller has checked the bounds."""
    return np.int64(load_u64(data, at))  # type: ignore[return-value]


@kernel
def _walk(
    data: ByteArray, start: int, end: int, opcode: ByteArray, offset: IntArray, length: IntArray
) -> tuple[int, int, int]:
    """Fill the three arrays with the records in data[start:end]; returns how many, where it stopped and why.

    offset is that of the content. Stops at a record that reaches beyond `end` (WALK_CUT), at an opcode that
    cannot be (WALK_INVALID), after DataEnd, or when the arrays are full.
    """
    count = 0
    at = start
    end = min(end, data.size)
    while at < end:
        if count == opcode.size:
            return count, at, WALK_FULL
        op = data[at]
        if op == 0:
            return count, at, WALK_INVALID
        if end - at < RECORD_HEAD:
            return count, at, WALK_CUT
        size = _long(data, at + 1)
        if size < 0 or size > end - at - RECORD_HEAD:
            return count, at, WALK_CUT
        opcode[count] = op
        offset[count] = at + RECORD_HEAD
        length[count] = size
        count += 1
        at += RECORD_HEAD + size
        if op == DATA_END:
            return count, at, WALK_DATA_END
    return count, at, WALK_DONE


@kernel
def _message_heads(data: ByteArray, offset: IntArray, channel: IntArray, log_ns: IntArray) -> None:
    """Read channel and log time of message records; a content too near the end gives channel -1."""
    for i in range(offset.size):
        at = offset[i]
        if at < 0 or at + MESSAGE_HEAD > data.size:
            channel[i] = -1
            continue
        channel[i] = load_u16(data, at)
        log_ns[i] = _long(data, at + 6)


@kernel
def gather(data: ByteArray, offset: IntArray, length: IntArray, to: IntArray, out: ByteArray) -> None:
    """Copy data[offset[i] : offset[i] + length[i]] to out[to[i] :] for all i; what does not fit is left out."""
    for i in range(offset.size):
        n = length[i]
        if offset[i] < 0 or n < 0 or n > data.size - offset[i] or to[i] < 0 or n > out.size - to[i]:
            continue
        out[to[i] : to[i] + n] = data[offset[i] : offset[i] + n]


@dataclass(frozen=True)
class Records:
    """Some records in a buffer, in order: shape (n,) each. offset: of the content, inside the buffer."""

    opcode: ByteArray
    offset: IntArray
    length: IntArray


@dataclass(frozen=True)
class Messages:
    """Some messages in a buffer: shape (n,) each; the payload of i is data[offset[i] : offset[i] + length[i]]."""

    data: ByteArray
    channel: IntArray
    log_ns: IntArray
    offset: IntArray
    length: IntArray


class Walker:
    """Walks over the records of a buffer, so many at once that memory stays bounded.

    at and state tell where the last walk ended and why (WALK_…).
    """

    def __init__(self) -> None:
        self.at = 0
        self.state = WALK_DONE
        self._opcode = np.empty(RECORDS_AT_ONCE, dtype=np.uint8)
        self._offset = np.empty(RECORDS_AT_ONCE, dtype=np.int64)
        self._length = np.empty(RECORDS_AT_ONCE, dtype=np.int64)

    def walk(self, data: ByteArray, start: int = 0) -> Iterator[Records]:
        """Yield the records of data[start:]."""
        self.at, self.state = start, WALK_FULL
        while self.state == WALK_FULL:
            count, self.at, self.state = _walk(
                data, self.at, data.size, self._opcode, self._offset, self._length
            )
            yield Records(
                self._opcode[:count].copy(), self._offset[:count].copy(), self._length[:count].copy()
            )


def find_messages(data: ByteArray, records: Records) -> tuple[Messages, int]:
    """The messages among the records, and how many message records were too short to be one."""
    rows = np.flatnonzero(records.opcode == MESSAGE)
    whole = rows[records.length[rows] >= MESSAGE_HEAD]
    offset, length = records.offset[whole], records.length[whole]
    channel = np.empty(whole.size, dtype=np.int64)
    log_ns = np.zeros(whole.size, dtype=np.int64)
    _message_heads(data, offset, channel, log_ns)
    found = Messages(data, channel, log_ns, offset + MESSAGE_HEAD, length - MESSAGE_HEAD)
    return found, rows.size - whole.size
