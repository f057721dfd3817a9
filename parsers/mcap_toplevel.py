"""The top level of an MCAP file without an index: its records, window by window."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray
from parsers.mcap_chunks import MAX_CHUNK_BYTES, McapFile
from parsers.mcap_records import (
    CHANNEL,
    CHUNK,
    MESSAGE,
    MESSAGE_HEAD,
    RECORD_HEAD,
    SCHEMA,
    WALK_CUT,
    WALK_DATA_END,
    WALK_INVALID,
    Records,
    Walker,
)

FIRST_WINDOW, LAST_WINDOW = 1 << 16, 1 << 23
"""Small at first and after a chunk, because only the next record's head may be needed; then growing."""


@dataclass(frozen=True)
class Window:
    """Records at the top level of the file, in a buffer of their own. base: file offset of data[0].

    A chunk larger than the window comes alone, as `chunk`: (offset, length) of its record, which was not read.
    """

    base: int
    data: ByteArray
    records: Records
    chunk: tuple[int, int] | None = None


_NOTHING = np.empty(0, dtype=np.int64)
_NO_RECORDS = Records(np.empty(0, dtype=np.uint8), _NOTHING, _NOTHING)


class TopLevel:
    """Walks over the top level of a file from `start` to `end`; large records are stepped over, not read.

    at: where it stopped. broken: why it stopped before the end ("" where it did not). cut: whether that is because
    a record reaches beyond the end; cut_chunk: whether it is a chunk. ended: it met the end of the data section.
    """

    def __init__(self, file: McapFile, start: int, end: int) -> None:
        self._file, self.end = file, min(end, file.size)
        self.at = start
        self.broken = ""
        self.cut = False
        self.cut_chunk = False
        self.ended = False

    def windows(self, keep: frozenset[int] | None = None) -> Iterator[Window]:
        """Yield windows. keep: channel ids whose messages are read however large they are (None: all)."""
        walker = Walker()
        size = FIRST_WINDOW
        while self.at < self.end and not self.ended and not self.broken:
            base = self.at
            data = self._file.array(base, min(size, self.end - base))
            if not data.size:
                self.broken = "the file became shorter"
                return
            for records in walker.walk(data):
                if records.opcode.size:
                    yield Window(base, data, records)
            self.at = base + walker.at
            self.ended = walker.state == WALK_DATA_END
            size = min(2 * size, LAST_WINDOW)
            if walker.state == WALK_INVALID:
                self.broken = "there is no MCAP record"
            elif walker.state == WALK_CUT:
                head = self._file.bytes(self.at, RECORD_HEAD + MESSAGE_HEAD)
                length = RECORD_HEAD + int.from_bytes(head[1:RECORD_HEAD], "little")
                if len(head) < RECORD_HEAD or length > self.end - self.at:
                    self.broken, self.cut = "a record says that it is longer than what is left", True
                    self.cut_chunk = len(head) > 0 and head[0] == CHUNK
                elif length > size:
                    yield from self._large(head, length, keep)
                    size = FIRST_WINDOW

    def _large(self, head: bytes, length: int, keep: frozenset[int] | None) -> Iterator[Window]:
        """Step over a record that is larger than a window, or read it where it is needed."""
        at, self.at = self.at, self.at + length
        opcode = head[0]
        if opcode == CHUNK:
            yield Window(at, np.empty(0, dtype=np.uint8), _NO_RECORDS, (at, length))
            return
        if opcode == MESSAGE:
            channel = int.from_bytes(head[RECORD_HEAD : RECORD_HEAD + 2], "little")
            needed = keep is None or channel in keep
        else:
            needed = opcode in (SCHEMA, CHANNEL)
        if needed and length <= MAX_CHUNK_BYTES:
            data = self._file.array(at, length)
            walker = Walker()
            for records in walker.walk(data):
                yield Window(at, data, records)
