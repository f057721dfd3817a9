"""The compact protocol of Apache Thrift read: Parquet's table of contents and the heads of its pages.

Source: https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md
"""

from __future__ import annotations

import struct
from typing import Any

_DEEPEST = 32
THRIFT_DAMAGE = (IndexError, struct.error, KeyError, TypeError, ValueError)
"""What reading a damaged structure, and looking for its fields, raises."""


class ThriftReader:
    """Reads structures of the compact protocol as {field number: value}; a list as a list. at: how far it came."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    @property
    def at(self) -> int:
        """Where the structure that was read ends."""
        return self._at

    def struct(self, depth: int = 0) -> dict[int, Any]:
        """The structure that begins here. Raises ValueError, IndexError, struct.error where there is none."""
        if depth > _DEEPEST:
            raise ValueError("nested too deeply")
        found: dict[int, Any] = {}
        field = 0
        while head := self._byte():
            field = field + (head >> 4) if head >> 4 else self._signed()
            found[field] = self._value(head & 15, depth)
        return found

    def _value(self, kind: int, depth: int) -> Any:
        if kind in (1, 2):
            return kind == 1
        if kind == 3:
            return self._byte()
        if kind in (4, 5, 6):
            return self._signed()
        if kind == 7:
            self._at += 8
            return struct.unpack_from("<d", self._data, self._at - 8)[0]
        if kind == 8:
            size = self._varint()
            self._at += size
            return self._data[self._at - size : self._at]
        if kind in (9, 10):
            return self._list(depth)
        if kind == 12:
            return self.struct(depth + 1)
        raise ValueError(f"a value of the unknown kind {kind}")

    def _list(self, depth: int) -> list[Any]:
        head = self._byte()
        size = head >> 4 if head >> 4 < 15 else self._varint()
        if size > len(self._data) - self._at:
            raise ValueError("a list longer than the file")
        kind = head & 15
        # in a list a truth value has a byte of its own
        return [self._byte() == 1 if kind in (1, 2) else self._value(kind, depth) for _ in range(size)]

    def _byte(self) -> int:
        self._at += 1
        return self._data[self._at - 1]

    def _varint(self) -> int:
        value = shift = 0
        while True:
            byte = self._byte()
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def _signed(self) -> int:
        value = self._varint()
        return (value >> 1) ^ -(value & 1)
