"""Chunks of a ROS 1 bag: from the file to uncompressed bytes, and to the messages in them."""

from __future__ import annotations

import bz2
from collections.abc import Mapping
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.lz4_frames import Lz4Error
from parsers.ros.bag1_kernels import walk_records
from parsers.ros.bag1_records import Connection, Record, is_chunk, parse_connection, parse_fields, read_record
from parsers.ros.memory import Scratch

MAX_CHUNK = 1 << 30
"""Largest uncompressed chunk that is believed, in bytes; recorders make them of less than 1 MB."""
# the best that each compression can do, so that a declared size beyond it is known to be wrong before allocating
_BEST_RATIO = {"none": 1, "lz4": 256, "bz2": 40_000}


class ChunkError(Exception):
    """A chunk cannot be used; str() is the reason in words."""


@dataclass(frozen=True)
class ChunkRef:
    """A chunk of a bag. counts: connection -> messages, where known. end: where its data end at the latest.

    whole: False where the file breaks off inside it, or damage follows before its declared end. bare: these are
    records that lie in the file itself, not in a chunk; start and end are theirs.
    """

    start: int
    end: int
    counts: Mapping[int, int] | None
    first_ns: int | None = None
    last_ns: int | None = None
    whole: bool = True
    bare: bool = False


@dataclass(frozen=True)
class ChunkData:
    """A chunk's data in the file: where they are, how many bytes there are of them, how many they are uncompressed."""

    at: int
    available: int
    declared: int
    compression: str


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


def unpack(raw: memoryview | bytes, data: ChunkData, whole: bool, scratch: Scratch) -> ByteArray:
    """Uncompress a chunk's data; at most one byte more than declared. Raises ChunkError where they are damaged.

    That one byte makes the decompressors go on to the end, where they compare their checksums. The bytes are good as long as
    the scratch is not used for another chunk.
    """
    kind, size = data.compression, data.declared
    if kind == "none":
        return np.frombuffer(raw, dtype=np.uint8)
    unpacked: ByteArray = np.empty(0, dtype=np.uint8)
    try:
        if kind == "bz2":
            made = bz2.BZ2Decompressor().decompress(raw, max_length=size + 1)
            unpacked = np.frombuffer(made, dtype=np.uint8)
        else:
            room = scratch.room(size + 1)
            unpacked = room[: scratch.frames.unpack(raw, room)]
    except (OSError, ValueError, EOFError, MemoryError, Lz4Error) as error:
        if whole:
            raise ChunkError(f"its {kind} data are damaged ({error})") from error
    if len(unpacked) > size or (whole and size and not len(unpacked)):
        raise ChunkError(f"its {kind} data are damaged")
    # not to be written, as bytes are not, so that the kernels need to be compiled only once
    unpacked.flags.writeable = False
    return unpacked


def chunk_data(file: BinaryIO, ref: ChunkRef, file_size: int) -> ChunkData:
    """Where a chunk's data are. Raises ChunkError where its record cannot be believed."""
    if ref.bare:
        return ChunkData(ref.start, ref.end - ref.start, ref.end - ref.start, "none")
    record = read_record(file, ref.start, file_size)
    if not is_chunk(record) or record is None:
        raise ChunkError("its record is damaged")
    compression = record.fields["compression"].decode("ascii", "replace")
    if compression not in _BEST_RATIO:
        raise ChunkError(f"its compression {compression!r} is not one of none, bz2, lz4")
    declared = record.data_len if compression == "none" else record.u32("size") or 0
    if declared > MAX_CHUNK or declared > _BEST_RATIO[compression] * (record.data_len + 64):
        raise ChunkError(f"it declares {declared} bytes, which cannot be right")
    available = min(record.end, ref.end, file_size) - record.data_at
    return ChunkData(record.data_at, max(available, 0), declared, compression)


def load_chunk(file: BinaryIO, ref: ChunkRef, file_size: int) -> Walk:
    """Read, uncompress and walk one chunk. Raises ChunkError where nothing of it can be used."""
    where = chunk_data(file, ref, file_size)
    file.seek(where.at)
    return walk_data(unpack(file.read(where.available), where, ref.whole, Scratch()), where.declared)


def walk_data(data: ByteArray, declared: int = 0, *, bare: bool = False) -> Walk:
    """List the records in a chunk's data; with `bare`, only up to the first that is no message and no connection."""
    none = np.zeros(0, dtype=np.int64)
    count, _ = walk_records(data, bare, none, none, none, none)
    conn, time_ns, offset, length = np.zeros((4, count), dtype=np.int64)
    _, stop = walk_records(data, bare, conn, time_ns, offset, length)
    return Walk(data, conn, time_ns, offset, length, stop, declared)
