"""The compact protocol of Apache Thrift, as far as Parquet's table of contents is written in it.

Source: https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

I32, I64, BINARY, LIST = 5, 6, 8, 9
_STRUCT = 12


def varint(value: int) -> bytes:
    """A whole number, not negative, seven bits a byte."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


class Thrift:
    """A structure. fields: (number, kind, value) with rising numbers; kind: I32, I64, BINARY (text or bytes), Thrift, or
    LIST, whose value is (kind of the items, items)."""

    def __init__(self, fields: Sequence[tuple[int, Any, Any]]) -> None:
        self._fields = fields

    def pack(self) -> bytes:
        """Its bytes. Fields that are None are left out."""
        out, before = bytearray(), 0
        for number, kind, value in self._fields:
            if value is None:
                continue
            # rising numbers, at most fifteen apart
            out.append((number - before) << 4 | _code(kind))
            out += _packed(kind, value)
            before = number
        return bytes(out) + b"\0"


def _code(kind: Any) -> int:
    return _STRUCT if kind is Thrift else int(kind)


def _packed(kind: Any, value: Any) -> bytes:
    if kind is Thrift:
        return bytes(value.pack())
    if kind == BINARY:
        data = value.encode("utf-8") if isinstance(value, str) else value
        return varint(len(data)) + data
    if kind == LIST:
        inner, items = value
        head = (
            bytes([len(items) << 4 | _code(inner)])
            if len(items) < 15
            else bytes([0xF0 | _code(inner)]) + varint(len(items))
        )
        return head + b"".join(_packed(inner, item) for item in items)
    return varint((value << 1) ^ (value >> 63))
