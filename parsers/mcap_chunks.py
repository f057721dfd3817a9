"""MCAP chunks and stretches of bare messages: reading, unpacking and checking them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from io import RawIOBase
from pathlib import Path

import deflate
import numpy as np
import zstandard

from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.lz4_frames import FrameUnpacker, Lz4Error
from parsers.mcap_records import (
    CHUNK,
    RECORD_HEAD,
    BadRecordError,
    ChunkHead,
    parse_chunk_head,
)
from parsers.shared_file import SharedFile
from parsers.zstd_frames import ZstdContext

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


class McapFile:
    """A file of known size, read at given places into writable buffers; threads may share it."""

    def __init__(self, path: Path, file: RawIOBase) -> None:
        self.path = path
        self.size = file.seek(0, 2)
        self._shared = SharedFile(file)

    @property
    def descriptor(self) -> int:
        """The number by which the system knows the file; -1 for one that is not on this machine's disks."""
        return self._shared.number

    def array(self, offset: int, length: int) -> ByteArray:
        """Up to `length` bytes from `offset`, fewer at the end of the file."""
        out = np.empty(max(0, min(length, self.size - offset)), dtype=np.uint8)
        return out[: self.fill(offset, out)]

    def fill(self, offset: int, out: ByteArray) -> int:
        """Read from `offset` until `out` is full; returns how many bytes there were."""
        try:
            return self._shared.fill(offset, out)
        except OSError as error:
            raise LogError(
                f"cannot be read ({error.strerror})", path=self.path, place=f"byte {offset}"
            ) from error

    def bytes(self, offset: int, length: int) -> bytes:
        """As `array`, as bytes."""
        return self.array(offset, length).tobytes()


class Scratch:
    """Memory of one thread that chunk after chunk is read and unpacked into: fresh memory costs more than the work.

    records: the unpacked records of some chunks behind one another, the first `used` bytes count. zstd, lz4, context: for the state of the decompression, the last for kernels.
    """

    def __init__(self) -> None:
        self.used = 0
        self.records: ByteArray = np.empty(0, dtype=np.uint8)
        self.zstd = zstandard.ZstdDecompressor()
        self.lz4 = FrameUnpacker()
        self.context = ZstdContext()
        self._packed: ByteArray = np.empty(0, dtype=np.uint8)

    def packed(self, size: int) -> ByteArray:
        """`size` bytes for a chunk as it stands in the file; the ones before are gone."""
        if self._packed.size < size:
            self._packed = np.empty(size + size // 4, dtype=np.uint8)
        return self._packed[:size]

    def room(self, size: int) -> ByteArray:
        """`size` bytes behind the records; whoever fills them adds to `used`."""
        if self.records.size - self.used < size:
            larger = np.empty(self.used + size + size // 4, dtype=np.uint8)
            larger[: self.used] = self.records[: self.used]
            self.records = larger
        return self.records[self.used : self.used + size]


def _unpack_zstd(zstd: zstandard.ZstdDecompressor, packed: ByteArray, out: ByteArray) -> int:
    done = 0
    try:
        with zstd.stream_reader(packed.data, read_across_frames=True) as stream:
            while done < out.size:
                got = stream.readinto(out.data[done:])
                if got == 0:
                    break
                done += got
    except zstandard.ZstdError as error:
        if not done:
            raise DamagedError(f"it cannot be unpacked ({error})") from error
    return done


def _unpack_lz4(frames: FrameUnpacker, packed: ByteArray, out: ByteArray) -> int:
    try:
        return frames.unpack(packed, out)
    except Lz4Error as error:
        raise DamagedError(f"it cannot be unpacked ({error})") from error


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
    if max(head.uncompressed_size, head.records_length) > MAX_CHUNK_BYTES:
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


def _fetch(file: McapFile, offset: int, head: ChunkHead, scratch: Scratch) -> tuple[int, bool]:
    """Read a chunk's records, unpacked, to scratch.room: how many bytes, and whether the file had all of them."""
    at = offset + RECORD_HEAD + head.records_at
    size = max(0, min(head.records_length, file.size - at))
    if head.compression == "":
        got = file.fill(at, scratch.room(size))
        return got, got == head.records_length
    packed = scratch.packed(size)
    packed = packed[: file.fill(at, packed)]
    room = scratch.room(head.uncompressed_size)
    if head.compression == "zstd":
        return _unpack_zstd(scratch.zstd, packed, room), packed.size == head.records_length
    if head.compression == "lz4":
        return _unpack_lz4(scratch.lz4, packed, room), packed.size == head.records_length
    raise DamagedError(f"its compression {head.compression[:20]!r} is not known (expected zstd, lz4 or none)")


def load_chunk(file: McapFile, span: ChunkSpan, scratch: Scratch) -> int:
    """Add the records of a chunk, unpacked and checked, to the scratch; returns how many bytes they are.

    Of a chunk that the end of the file cuts off, what can be unpacked. Raises DamagedError (and adds nothing).
    """
    head, length = read_chunk_head(file, span.offset)
    if span.whole and length != span.length:
        raise DamagedError(f"its record is {length} bytes long, the index says {span.length}")
    got, all_there = _fetch(file, span.offset, head, scratch)
    if span.whole:
        if not all_there:
            raise DamagedError("the file ends inside it")
        if got != head.uncompressed_size:
            raise DamagedError(f"it unpacks to {got} bytes, not to {head.uncompressed_size} as it says")
        if head.crc and deflate.crc32(scratch.room(got).data) != head.crc:
            raise DamagedError("its checksum is wrong")
    scratch.used += got
    return got
