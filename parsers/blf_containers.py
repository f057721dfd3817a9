"""The outside of a BLF file: its header, and containers one at a time where they are not as usual.

`parsers.blf_groups` reads what is as usual, which is nearly all, many containers at a time.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

import deflate

from parsers.blf_objects import LOG_CONTAINER
from parsers.blf_walk import Block, Bytes, block_of
from parsers.errors import LogError

_HEADER = struct.Struct("<4sL8BQQLL8H8H")
_OBJECT = struct.Struct("<4sHHLL")
_CONTAINER = struct.Struct("<H6xL4x")
OBJECT_SIZE = _OBJECT.size
HEAD_SIZE = _OBJECT.size + _CONTAINER.size
MAX_CONTAINER = 64 << 20
"""Bytes. Writers make containers of 128 KiB to a few MiB; a larger size is damage, never allocated."""
RAW_BLOCK = 1 << 20
_MARK = b"LOBJ\x10\x00\x01\x00"
_MOST_PER_BYTE = 1040
"""Bytes that one byte of a deflated stream can stand for."""
STORED, ZLIB = 0, 2


@dataclass(frozen=True)
class BlfHeader:
    """What a BLF file's statistics block says. objects 0 and file_size 0: never finalised.

    size: bytes before the first object. start_ns: the measurement's start since 1970, None where not set.
    """

    size: int
    file_size: int
    objects: int
    start_ns: int | None


def _system_time_ns(fields: tuple[int, ...]) -> int | None:
    """A Windows SYSTEMTIME (year, month, weekday, day, hour, minute, second, ms), read as UTC."""
    year, month, _, day, hour, minute, second, milli = fields
    try:
        moment = datetime(year, month, day, hour, minute, second, tzinfo=UTC)
    except ValueError:
        return None
    seconds = int(moment.timestamp())
    return seconds * 1_000_000_000 + milli * 1_000_000 if seconds > 0 and milli < 1000 else None


def read_header(path: Path) -> BlfHeader:
    """Read the statistics block. Raises LogError where the file is too short to have one."""
    with path.open("rb") as file:
        head = file.read(_HEADER.size)
    if len(head) < _HEADER.size or head[:4] != b"LOGG":
        raise LogError(
            f"a BLF file begins with a header of {_HEADER.size} bytes, found {len(head)} bytes",
            path=path,
            place="byte 0",
            hint="check that the recording was copied whole",
        )
    fields = _HEADER.unpack(head)
    size = int(fields[1])
    if not _HEADER.size <= size <= 65536:
        size = 144
    return BlfHeader(size, int(fields[10]), int(fields[12]), _system_time_ns(fields[14:22]))


@dataclass(frozen=True)
class Container:
    """A container whose header can be true. at, size: bytes in the file. method, claimed: of its content."""

    at: int
    size: int
    method: int
    claimed: int


def container_at(buffer: bytes | bytearray, place: int, position: int) -> Container | None:
    """The container whose header of HEAD_SIZE bytes stands at buffer[place], which is `position` in the file."""
    mark, head, _, size, kind = _OBJECT.unpack_from(buffer, place)
    if (
        mark != b"LOBJ"
        or kind != LOG_CONTAINER
        or head != OBJECT_SIZE
        or not HEAD_SIZE <= size <= MAX_CONTAINER
    ):
        return None
    method, claimed = _CONTAINER.unpack_from(buffer, place + OBJECT_SIZE)
    return Container(position, size, method, claimed)


def inflate(data: Bytes, limit: int) -> tuple[bytes, bool]:
    """Inflate a zlib stream to at most `limit` bytes: the bytes, and whether the stream came to its proper end."""
    stream = zlib.decompressobj()
    try:
        content = stream.decompress(data, limit)
    except zlib.error:
        return b"", False
    return content, stream.eof


def can_hold(size: int, claimed: int) -> bool:
    """Whether a deflated container of `size` bytes may hold what it claims."""
    return 0 < claimed <= min(MAX_CONTAINER, _MOST_PER_BYTE * size)


def content_of(method: int, claimed: int, payload: Bytes) -> tuple[Bytes, bool]:
    """What a container holds, and whether it is whole."""
    if method == STORED:
        return payload, True
    if method != ZLIB:
        return b"", False
    if can_hold(len(payload), claimed):
        try:
            return deflate.zlib_decompress(payload, claimed), True
        except deflate.DeflateError:
            # a size that is not true, a stream that breaks off or is damaged: zlib can tell
            pass
    return inflate(payload, MAX_CONTAINER)


def _search(file: BinaryIO, position: int, total: int) -> int:
    """The next container's place at or after a position, or `total`."""
    while position < total:
        file.seek(position)
        block = file.read(RAW_BLOCK)
        at = block.find(_MARK)
        while at >= 0:
            if int.from_bytes(block[at + 12 : at + 16], "little") == LOG_CONTAINER:
                return position + at
            at = block.find(_MARK, at + 4)
        if len(block) < RAW_BLOCK:
            break
        # a mark and its type may lie across two blocks
        position += len(block) - 15
    return total


def _whole_or_cut(file: BinaryIO, found: Container, total: int) -> Block:
    """The content of a container, of which the end may be beyond the file's."""
    file.seek(found.at + HEAD_SIZE)
    payload = file.read(min(found.size, total - found.at) - HEAD_SIZE)
    content, whole = content_of(found.method, found.claimed, payload)
    if found.at + found.size > total:
        return block_of("cut", found.at, total - found.at, content)
    return block_of("container" if whole else "damaged", found.at, found.size, content if whole else b"")


def odd_blocks(file: BinaryIO, position: int, total: int) -> Iterator[Block]:
    """The blocks from a position on up to where the next container may be: one container, or what is none.

    At least OBJECT_SIZE bytes are left there. The blocks' sizes add up to more than nothing, and to where reading goes on.
    """
    file.seek(position)
    near = file.read(HEAD_SIZE + 8)
    shift = near.find(b"LOBJ", 0, 12)
    if shift < 0:
        after = _search(file, position, total)
        kind = "damaged" if after < total else "cut"
        yield block_of(kind if any(near) else "padding", position, after - position)
        return
    at = position + shift
    if at + OBJECT_SIZE > total:
        yield block_of("cut", position, total - position)
        return
    if _OBJECT.unpack_from(near, shift)[4] != LOG_CONTAINER:
        after = _search(file, at + OBJECT_SIZE, total)
        for piece in range(at, after, RAW_BLOCK):
            file.seek(piece)
            size = min(RAW_BLOCK, after - piece)
            yield block_of("raw", piece, size, file.read(size))
        return
    found = container_at(near, shift, at) if at + HEAD_SIZE <= total else None
    if found is None or at + found.size > total:
        after = _search(file, at + OBJECT_SIZE, total)
        if found is None or after < total:
            yield block_of("damaged" if after < total else "cut", at, after - at)
            return
    yield _whole_or_cut(file, found, total)
