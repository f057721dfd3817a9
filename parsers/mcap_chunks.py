"""MCAP chunks and stretches of bare messages: reading, unpacking and checking them."""

from __future__ import annotations

import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol, cast

import lz4.frame
import numpy as np
import zstandard

from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.mcap_records import (
    CHUNK,
    RECORD_HEAD,
    BadRecordError,
    ChunkHead,
    parse_chunk_head,
)

MAX_CHUNK_BYTES = 1 << 29
"""A chunk that says it unpacks to more is taken for damaged: recorders write chunks of 1-16 MiB."""

_HEAD_READ = 256
_SEARCH = 1 << 23
_NAME_AT = RECORD_HEAD + 28
_COMPRESSION_NAMES = re.compile(rb"\x04\x00\x00\x00zstd|\x03\x00\x00\x00lz4")


class DamagedError(Exception):
    """A chunk cannot be used; the text says why."""


@dataclass(frozen=True)
class ChunkSpan:
    """One chunk in the file. offset, length: of the whole record, the length cut at the end of the file.

    channels: ids of the channels with messages in it, None where that is not known without unpacking.
    whole: False where the file breaks off inside the chunk.
    """

    offset: int
    length: int
    start_ns: int = 0
    end_ns: int = 0
    channels: frozenset[int] | None = None
    whole: bool = True


@dataclass(frozen=True)
class LooseSpan:
    """A stretch of the data section with messages outside of chunks."""

    offset: int
    end: int


Span = ChunkSpan | LooseSpan


class _Lz4Stream(Protocol):
    def decompress(self, data: memoryview, max_length: int) -> bytearray: ...


class McapFile:
    """A file of known size, read at given places into writable buffers."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self.path = path
        self._file = file
        self.size = file.seek(0, 2)

    def array(self, offset: int, length: int) -> ByteArray:
        """Up to `length` bytes from `offset`, fewer at the end of the file."""
        length = max(0, min(length, self.size - offset))
        out = np.empty(length, dtype=np.uint8)
        try:
            self._file.seek(offset)
            got = self._file.readinto(out.data) if length else 0  # type: ignore[attr-defined]
        except OSError as error:
            raise LogError(
                f"cannot be read ({error.strerror})", path=self.path, place=f"byte {offset}"
            ) from error
        return out[:got]

    def bytes(self, offset: int, length: int) -> bytes:
        """As `array`, as bytes."""
        return self.array(offset, length).tobytes()


def _unpack_zstd(packed: ByteArray, size: int) -> ByteArray:
    out = np.empty(size, dtype=np.uint8)
    view = out.data
    done = 0
    try:
        with zstandard.ZstdDecompressor().stream_reader(packed.data, read_across_frames=True) as stream:
            while done < size:
                got = stream.readinto(view[done:])
                if got == 0:
                    break
                done += got
    except zstandard.ZstdError as error:
        if not done:
            raise DamagedError(f"it cannot be unpacked ({error})") from error
    return out[:done]


def _unpack_lz4(packed: ByteArray, size: int) -> ByteArray:
    stream = cast("_Lz4Stream", lz4.frame.LZ4FrameDecompressor(return_bytearray=True))
    try:
        unpacked = stream.decompress(packed.data, max_length=size)
    except (RuntimeError, EOFError) as error:
        raise DamagedError("it cannot be unpacked (lz4 finds an error)") from error
    return np.frombuffer(unpacked, dtype=np.uint8)


def _unpack(head: ChunkHead, packed: ByteArray) -> ByteArray:
    if head.compression == "":
        return packed
    if head.compression == "zstd":
        return _unpack_zstd(packed, head.uncompressed_size)
    if head.compression == "lz4":
        return _unpack_lz4(packed, head.uncompressed_size)
    raise DamagedError(f"its compression {head.compression[:20]!r} is not known (expected zstd, lz4 or none)")


def read_chunk_head(file: McapFile, offset: int) -> tuple[ChunkHead, int]:
    """The head of the chunk whose record begins at `offset`, and the length that the record says it has.

    Raises DamagedError where there is no chunk, or where its own sizes contradict each other.
    """
    raw = file.bytes(offset, RECORD_HEAD + _HEAD_READ)
    if len(raw) < RECORD_HEAD or raw[0] != CHUNK:
        raise DamagedError("there is no chunk record")
    content_length = int.from_bytes(raw[1:RECORD_HEAD], "little")
    try:
        head = parse_chunk_head(raw[RECORD_HEAD : RECORD_HEAD + content_length])
    except BadRecordError as error:
        raise DamagedError(str(error)) from error
    if head.records_length != content_length - head.records_at:
        raise DamagedError(f"a chunk of {content_length} bytes says that it holds {head.records_length}")
    if head.uncompressed_size > MAX_CHUNK_BYTES:
        raise DamagedError(
            f"it says that it unpacks to {head.uncompressed_size} bytes (expected at most {MAX_CHUNK_BYTES})"
        )
    return head, RECORD_HEAD + content_length


def find_chunk(file: McapFile, start: int, end: int) -> int | None:
    """The first place from `start` on where a whole compressed chunk begins, for going on behind damage.

    A chunk is known by the name of its compression and by sizes that agree.
    """
    at = start
    while at < end:
        raw = file.bytes(at, min(_SEARCH, end - at))
        for found in _COMPRESSION_NAMES.finditer(raw):
            place = at + found.start() - _NAME_AT
            if place < start:
                continue
            try:
                _, length = read_chunk_head(file, place)
            except DamagedError:
                continue
            if place + length <= end:
                return place
        at += _SEARCH - _NAME_AT - 8
    return None


def load_chunk(file: McapFile, span: ChunkSpan) -> ByteArray:
    """The records of a chunk, unpacked and checked: shape (n,) uint8, writable.

    Of a chunk that the end of the file cuts off, what can be unpacked. Raises DamagedError.
    """
    head, length = read_chunk_head(file, span.offset)
    if span.whole and length != span.length:
        raise DamagedError(f"its record is {length} bytes long, the index says {span.length}")
    packed = file.array(span.offset + RECORD_HEAD + head.records_at, head.records_length)
    if not span.whole:
        return _unpack(head, packed)
    if packed.size < head.records_length:
        raise DamagedError("the file ends inside it")
    records = _unpack(head, packed)
    if records.size != head.uncompressed_size:
        raise DamagedError(f"it unpacks to {records.size} bytes, not to {head.uncompressed_size} as it says")
    if head.crc and zlib.crc32(records.data) != head.crc:
        raise DamagedError("its checksum is wrong")
    return records
