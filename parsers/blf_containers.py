"""The outside of a BLF file: its header, and the containers with their compressed content, one at a time."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

from parsers.blf_objects import LOG_CONTAINER
from parsers.errors import LogError

_HEADER = struct.Struct("<4sL8BQQLL8H8H")
_OBJECT = struct.Struct("<4sHHLL")
_CONTAINER = struct.Struct("<H6xL4x")
HEAD_SIZE = _OBJECT.size + _CONTAINER.size
MAX_CONTAINER = 64 << 20
"""Bytes. Writers make containers of 128 KiB to a few MiB; a larger size is damage, never allocated."""
RAW_BLOCK = 1 << 20
_MARK = b"LOBJ\x10\x00\x01\x00"
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


@dataclass(frozen=True)
class Block:
    """A piece of the file. kind: "container" (inflated content), "raw" (objects outside a container),
    "damaged" or "cut" (`data` then holds what of it is readable). position, size: bytes in the file."""

    kind: str
    position: int
    size: int
    data: bytes


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


def inflate(data: bytes, limit: int) -> tuple[bytes, bool]:
    """Inflate a zlib stream to at most `limit` bytes: the bytes, and whether the stream came to its proper end."""
    stream = zlib.decompressobj()
    try:
        content = stream.decompress(data, limit)
    except zlib.error:
        return b"", False
    return content, stream.eof


def _content(method: int, payload: bytes) -> tuple[bytes, bool]:
    if method == STORED:
        return payload, True
    if method == ZLIB:
        return inflate(payload, MAX_CONTAINER)
    return b"", False


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


def _container(file: BinaryIO, at: int, size: int, total: int) -> Block:
    """The container at a place, whose header has been checked."""
    file.seek(at + _OBJECT.size)
    body = file.read(min(size, total - at) - _OBJECT.size)
    method, _ = _CONTAINER.unpack_from(body)
    content, whole = _content(method, body[_CONTAINER.size :])
    if at + size > total:
        return Block("cut", at, total - at, content)
    return Block("container" if whole else "damaged", at, size, content if whole else b"")


def blocks(path: Path, header: BlfHeader) -> Iterator[Block]:
    """The file's blocks in order; each step moves on by at least 16 bytes, so that no file loops for ever."""
    total = os.path.getsize(path)
    position = header.size
    with path.open("rb") as file:
        while position + _OBJECT.size <= total:
            file.seek(position)
            near = file.read(HEAD_SIZE + 8)
            shift = near.find(b"LOBJ", 0, 12)
            if shift < 0:
                after = _search(file, position, total)
                if any(near):
                    yield Block("damaged" if after < total else "cut", position, after - position, b"")
                position = after
                continue
            at = position + shift
            if at + _OBJECT.size > total:
                break
            _, head, _, size, kind = _OBJECT.unpack_from(near, shift)
            if kind != LOG_CONTAINER:
                position = _search(file, at + _OBJECT.size, total)
                for piece in range(at, position, RAW_BLOCK):
                    file.seek(piece)
                    size = min(RAW_BLOCK, position - piece)
                    yield Block("raw", piece, size, file.read(size))
                continue
            fits = head == _OBJECT.size and HEAD_SIZE <= size <= MAX_CONTAINER
            if not fits or at + size > total:
                after = _search(file, at + _OBJECT.size, total)
                if not fits or after < total or at + HEAD_SIZE > total:
                    yield Block("damaged" if after < total else "cut", at, after - at, b"")
                    position = after
                    continue
            yield _container(file, at, size, total)
            position = at + size
        if 0 < total - position < _OBJECT.size:
            file.seek(position)
            if any(file.read()):
                yield Block("cut", position, total - position, b"")
