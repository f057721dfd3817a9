"""BLF files for the tests: objects and containers built byte by byte, and their frames read back."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

from frame_rows import Frame, rows_of

from parsers.blf_containers import read_header
from parsers.blf_frames import BlfFrames
from parsers.importer import ImportLog, no_progress

START = 1_700_000_000


def frames_of(path: Path) -> tuple[list[Frame], ImportLog]:
    """All frames as (time_ns, id, bus, payload), and the log book."""
    log = ImportLog()
    frames = BlfFrames(path, read_header(path), log, no_progress).frames(counting=True)
    return rows_of(frames), log


def header_bytes(
    *, objects: int = 1, file_size: int = 0, start: tuple[int, ...] = (2023, 11, 2, 14, 22, 13, 20, 250)
) -> bytes:
    head = struct.pack(
        "<4sL8BQQLL8H8H", b"LOGG", 144, 0, 0, 0, 0, 0, 0, 0, 0, file_size, 0, objects, 0, *start, *([0] * 8)
    )
    return head.ljust(144, b"\0")


def obj(
    kind: int, body: bytes, ticks: int, *, flags: int = 2, version: int = 1, size: int | None = None
) -> bytes:
    extra = struct.pack("<LHHQ", flags, 0, 0, ticks)
    if version == 2:
        extra = struct.pack("<LBxHQ8x", flags, 0, 0, ticks)
    total = 16 + len(extra) + len(body)
    head = struct.pack("<4sHHLL", b"LOBJ", 16 + len(extra), version, total if size is None else size, kind)
    return head + extra + body + b"\0" * (total % 4)


def container(content: bytes, method: int = 2, size: int | None = None) -> bytes:
    packed = zlib.compress(content) if method == 2 else content
    total = 32 + len(packed)
    head = struct.pack(
        "<4sHHLLH6xL4x", b"LOBJ", 16, 1, total if size is None else size, 10, method, len(content)
    )
    return head + packed + b"\0" * (total % 4)


def classic(channel: int, ident: int, data: bytes, *, flags: int = 0, dlc: int | None = None) -> bytes:
    return struct.pack("<HBBL8s", channel, flags, len(data) if dlc is None else dlc, ident, data)


NUMBERED = [obj(1, classic(1, k, bytes([k])), k * 1000) for k in range(40)]
FD_BODY = struct.Struct("<HBBLLBBB5x")


def fd(channel: int, ident: int, data: bytes, *, valid: int | None = None) -> bytes:
    """The body of a CAN_FD_MESSAGE with as much of its data as is given."""
    return FD_BODY.pack(channel, 0, 15, ident, 0, 0, 1, len(data) if valid is None else valid) + data


def write_containers(path: Path, content: bytes, size: int) -> Path:
    parts = (content[at : at + size] for at in range(0, len(content), size))
    path.write_bytes(header_bytes(start=(0,) * 8) + b"".join(map(container, parts)))
    return path
