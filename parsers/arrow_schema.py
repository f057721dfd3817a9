"""What Arrow's schema says of columns beside their types: the metadata of fields, as Parquet files and others carry it.

Parquet keeps the schema as an IPC message in base64 under the key "ARROW:schema". Source: https://arrow.apache.org/docs/format/Columnar.html
(Message.fbs, Schema.fbs) and https://flatbuffers.dev/internals/. Only names and metadata of columns at the top level are read.
"""

from __future__ import annotations

import base64
import binascii
import struct
from collections.abc import Iterator

_MOST_BYTES = 64 << 20
_CONTINUED = b"\xff\xff\xff\xff"
_SCHEMA = 1
# places of fields in their tables
_HEADER_KIND, _HEADER = 1, 2
_FIELDS = 1
_NAME, _FIELD_METADATA = 0, 6
_KEY, _VALUE = 0, 1


def field_metadata(encoded: str) -> dict[str, dict[str, str]]:
    """The metadata of each column that has any, by name. Empty where the text is no schema: what is damaged says nothing."""
    try:
        return dict(_fields(_Buffer(_message(encoded))))
    except (ValueError, binascii.Error, struct.error, IndexError):
        return {}


def _message(encoded: str) -> bytes:
    """The message's flat buffer, without what stands before it."""
    if len(encoded) > _MOST_BYTES:
        raise ValueError("a schema larger than any")
    data = base64.b64decode(encoded)
    return data[8:] if data.startswith(_CONTINUED) else data[4:]


def _fields(buffer: _Buffer) -> Iterator[tuple[str, dict[str, str]]]:
    message = buffer.target(0)
    kind, header = buffer.place(message, _HEADER_KIND), buffer.place(message, _HEADER)
    if not kind or not header or buffer.data[kind] != _SCHEMA:
        return
    for field in buffer.tables(buffer.target(header), _FIELDS):
        said = {
            buffer.text(entry, _KEY): buffer.text(entry, _VALUE)
            for entry in buffer.tables(field, _FIELD_METADATA)
        }
        if said:
            yield buffer.text(field, _NAME), said


class _Buffer:
    """A flat buffer. Tables are told by where they begin; every place is checked."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    def _number(self, code: str, at: int) -> int:
        if at < 0:
            raise ValueError("a place before the buffer")
        return int(struct.unpack_from(code, self.data, at)[0])

    def target(self, at: int) -> int:
        """What the reference at a place points to."""
        return at + self._number("<I", at)

    def place(self, table: int, field: int) -> int:
        """Where a table's field is; 0 where it has none."""
        slots = table - self._number("<i", table)
        slot = 4 + 2 * field
        if slot + 2 > self._number("<H", slots):
            return 0
        offset = self._number("<H", slots + slot)
        return table + offset if offset else 0

    def text(self, table: int, field: int) -> str:
        """A field of text; "" where there is none."""
        at = self.place(table, field)
        if not at:
            return ""
        start = self.target(at)
        return self.data[start + 4 : start + 4 + self._number("<I", start)].decode("utf-8", "replace")

    def tables(self, table: int, field: int) -> Iterator[int]:
        """The tables that a field lists. Raises ValueError for a list longer than the buffer."""
        at = self.place(table, field)
        if not at:
            return
        start = self.target(at)
        count = self._number("<I", start)
        if 4 * count > len(self.data):
            raise ValueError("a list longer than the buffer")
        for k in range(count):
            yield self.target(start + 4 + 4 * k)
