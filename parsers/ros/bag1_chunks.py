"""Chunks of a ROS 1 bag: from the file to uncompressed bytes, and to the messages in them."""

from __future__ import annotations

import bz2
from collections.abc import Mapping
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.ros.bag1_kernels import walk_records
from parsers.ros.bag1_records import Connection, Record, is_chunk, parse_connection, parse_fields, read_record

MAX_CHUNK = 1 << 30
"""Largest uncompressed chunk that is believed, in bytes; recorders make them of less than 1 MB."""
# the best that each compression can do, so that a declared size beyond it is known to be wrong before allocating
_BEST_RATIO = {"none": 1, "lz4": 256, "bz2": 40_000}


class ChunkError(Exception):
    """A chunk cannot be used; str() is the reason in words."""


@dataclass(frozen=True)
class ChunkRef:
    """A chunk of a bag. counts: connection -> messages, where known. end: where its data end at the latest.

    whole: False where the file breaks off inside it, or damage follows before its declared end.
    """

    start: int
    end: int
    counts: Mapping[int, int] | None
    first_ns: int | None = None
    last_ns: int | None = None
    whole: bool = True


@dataclass(frozen=True)
class Walk:
    """Records found in a chunk: connection, receive time, payload's place and length, shape (n,) each.

    stop: where the walk ended; less than the data's size where a record is broken.
    """

    data: ByteArray
    conn: IntArray
    time_ns: IntArray
    offset: IntArray
    length: IntArray
    stop: int
    declared: int

    @property
    def complete(self) -> bool:
        """Whether all that the chunk declares was there."""
        return self.stop == self.declared

    def connections(self) -> list[Connection]:
        """The connection records inside the chunk."""
        found: list[Connection] = []
        for row in np.flatnonzero(self.conn < 0):
            start = int(self.offset[row])
            raw = self.data[start : start + int(self.length[row])].tobytes()
            header = int.from_bytes(raw[:4], "little")
            fields = parse_fields(raw[4 : 4 + header])
            if fields is None:
                continue
            record = Record(start, 7, fields, 0, 0)
            connection = parse_connection(record, raw[8 + header :])
            if connection is not None:
                found.append(connection)
        return found


def _unpack(raw: bytes, compression: str, size: int, whole: bool) -> bytes:
    """Uncompress a chunk's data; at most one byte more than declared. Raises ChunkError.

    That one byte makes the decompressors go on to the end, where they compare their checksums.
    """
    if compression == "none":
        return raw
    try:
        if compression == "bz2":
            return bz2.BZ2Decompressor().decompress(raw, max_length=size + 1)
        import lz4.frame

        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(raw, max_length=size + 1))
    except (OSError, ValueError, EOFError, RuntimeError, MemoryError) as error:
        if not whole:
            return b""
        raise ChunkError(f"its {compression} data are damaged ({error})") from error


def load_chunk(file: BinaryIO, ref: ChunkRef, file_size: int) -> Walk:
    """Read, uncompress and walk one chunk. Raises ChunkError where nothing of it can be used."""
    record = read_record(file, ref.start, file_size)
    if not is_chunk(record) or record is None:
        raise ChunkError("its record is damaged")
    compression = record.fields["compression"].decode("ascii", "replace")
    declared = record.u32("size") or 0
    if compression not in _BEST_RATIO:
        raise ChunkError(f"its compression {compression!r} is not one of none, bz2, lz4")
    available = min(record.end, ref.end, file_size) - record.data_at
    if compression == "none":
        declared = record.data_len
    if declared > MAX_CHUNK or declared > _BEST_RATIO[compression] * (record.data_len + 64):
        raise ChunkError(f"it declares {declared} bytes, which cannot be right")
    file.seek(record.data_at)
    raw = file.read(available)
    unpacked = _unpack(raw, compression, declared, ref.whole)
    if len(unpacked) > declared or (ref.whole and declared and not unpacked):
        raise ChunkError(f"its {compression} data are damaged")
    data = np.frombuffer(unpacked, dtype=np.uint8)
    none = np.zeros(0, dtype=np.int64)
    count, _ = walk_records(data, none, none, none, none)
    conn, time_ns, offset, length = np.zeros((4, count), dtype=np.int64)
    _, stop = walk_records(data, conn, time_ns, offset, length)
    return Walk(data, conn, time_ns, offset, length, stop, declared)
