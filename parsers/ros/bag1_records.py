"""Records of a ROS 1 bag, format 2.0: reading one, checking it, and finding the next whole one after damage.

Source: http://wiki.ros.org/Bags/Format/2.0. Everything is little-endian; a record is a header (fields "name=value",
each after its length) and data, each after its length.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import BinaryIO

MAGIC = b"#ROSBAG V2.0\n"
OP_MESSAGE, OP_BAG_HEADER, OP_INDEX, OP_CHUNK, OP_CHUNK_INFO, OP_CONNECTION = 2, 3, 4, 5, 6, 7
OPS = frozenset({OP_MESSAGE, OP_BAG_HEADER, OP_INDEX, OP_CHUNK, OP_CHUNK_INFO, OP_CONNECTION})

MAX_HEADER = 1 << 16
MAX_CONNECTION = 1 << 23
_WINDOW = 1 << 22
_REACH = 256
_USUAL = 128
_CHUNK_MARK = re.compile(rb"\x04\x00\x00\x00op=\x05")


@dataclass(frozen=True)
class Record:
    """One record: where it begins, its header's fields, and where its data lie."""

    start: int
    op: int
    fields: Mapping[str, bytes]
    data_at: int
    data_len: int

    @property
    def end(self) -> int:
        """The first byte after the record."""
        return self.data_at + self.data_len

    def u32(self, name: str) -> int | None:
        """A field of 4 bytes, None where it is not there."""
        value = self.fields.get(name, b"")
        return int.from_bytes(value, "little") if len(value) == 4 else None

    def u64(self, name: str) -> int | None:
        """A field of 8 bytes, None where it is not there."""
        value = self.fields.get(name, b"")
        return int.from_bytes(value, "little") if len(value) == 8 else None

    def time_ns(self, name: str) -> int | None:
        """A time field (seconds, nanoseconds) in nanoseconds, None where it is not there."""
        value = self.fields.get(name, b"")
        if len(value) != 8:
            return None
        seconds, rest = struct.unpack("<II", value)
        return int(seconds) * 1_000_000_000 + int(rest)


@dataclass(frozen=True)
class Connection:
    """A publisher's topic as the bag describes it. md5 and definition as recorded."""

    id: int
    topic: str
    type_name: str
    md5: str
    definition: str


def parse_fields(header: bytes) -> dict[str, bytes] | None:
    """The fields of a record's header, or None where they do not fit together."""
    fields: dict[str, bytes] = {}
    at = 0
    while at < len(header):
        if len(header) - at < 4:
            return None
        size = int.from_bytes(header[at : at + 4], "little")
        at += 4
        name, equals, value = header[at : at + size].partition(b"=")
        if size < 1 or size > len(header) - at or not equals:
            return None
        fields[name.decode("ascii", "replace")] = value
        at += size
    return fields


def read_record(file: BinaryIO, start: int, size: int) -> Record | None:
    """The record at `start` of a file of `size` bytes; None where none begins there. Its data may run past the end."""
    if size - start < 8:
        return None
    file.seek(start)
    head = file.read(_USUAL)
    length = int.from_bytes(head[:4], "little")
    if length > MAX_HEADER or length > size - start - 8:
        return None
    if length + 8 > len(head):
        file.seek(start)
        head = file.read(length + 8)
    fields = parse_fields(head[4 : length + 4])
    data_len = head[length + 4 : length + 8]
    if fields is None or len(data_len) != 4 or len(fields.get("op", b"")) != 1 or fields["op"][0] not in OPS:
        return None
    return Record(start, fields["op"][0], fields, start + length + 8, int.from_bytes(data_len, "little"))


def record_breaks_off(file: BinaryIO, start: int, size: int) -> bool:
    """Whether the file ends inside the header of what may be a record at `start`."""
    if size - start < 4:
        return True
    file.seek(start)
    length = int.from_bytes(file.read(4), "little")
    return length <= MAX_HEADER and length > size - start - 8


def is_chunk(record: Record | None) -> bool:
    """Whether a record is a chunk with all that a chunk needs."""
    return (
        record is not None
        and record.op == OP_CHUNK
        and record.u32("size") is not None
        and "compression" in record.fields
    )


def next_chunk(file: BinaryIO, start: int, size: int) -> Record | None:
    """The first whole-looking chunk record at or after `start`, or None: where to go on after damage."""
    at = start
    while at < size:
        file.seek(max(start, at - _REACH))
        base = file.tell()
        window = file.read(_WINDOW + _REACH)
        for mark in _CHUNK_MARK.finditer(window):
            record = _chunk_around(file, window, base, mark.start(), start, size)
            if record is not None:
                return record
        if base + len(window) >= size:
            return None
        at = base + len(window)
    return None


def _chunk_around(
    file: BinaryIO, window: bytes, base: int, mark: int, start: int, size: int
) -> Record | None:
    """The chunk record whose "op" field lies at window[mark] (the window begins at byte `base` of the file)."""
    for begin in range(mark - 4, max(start - base, mark - 80, 0) - 1, -1):
        # fields may come in any order; the header's length must reach over this one, and not far
        length = int.from_bytes(window[begin : begin + 4], "little")
        if mark + 4 - begin <= length <= _REACH:
            record = read_record(file, base + begin, size)
            if is_chunk(record) and record is not None and record.end <= size:
                return record
    return None


def parse_connection(record: Record, data: bytes) -> Connection | None:
    """The connection that a record describes, or None where it does not."""
    number = record.u32("conn")
    fields = parse_fields(data)
    if number is None or fields is None or "type" not in fields:
        return None
    topic = record.fields.get("topic", fields.get("topic", b""))
    return Connection(
        id=number,
        topic=topic.decode("utf-8", "replace"),
        type_name=fields["type"].decode("utf-8", "replace"),
        md5=fields.get("md5sum", b"").decode("ascii", "replace"),
        definition=fields.get("message_definition", b"").decode("utf-8", "replace"),
    )


def read_connection(file: BinaryIO, record: Record) -> Connection | None:
    """The connection of a record in a file, or None where it is damaged."""
    if record.data_len > MAX_CONNECTION:
        return None
    file.seek(record.data_at)
    data = file.read(record.data_len)
    return parse_connection(record, data) if len(data) == record.data_len else None
