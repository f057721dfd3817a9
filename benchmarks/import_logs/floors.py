"""What no reader of a format can do without: reading the bytes, unpacking the containers, finding the lines."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

_BLOCK = 1 << 20


def _files(path: Path) -> list[Path]:
    return sorted(p for p in path.iterdir() if p.is_file()) if path.is_dir() else [path]


def read_file(path: Path) -> int:
    """Read the file into one buffer, block by block."""
    buffer = bytearray(_BLOCK)
    total = 0
    for file in _files(path):
        with file.open("rb", buffering=0) as stream:
            while n := stream.readinto(buffer):
                total += n
    return total


def count_lines(path: Path) -> int:
    """Read the file and count its line feeds."""
    with path.open("rb", buffering=0) as stream:
        return sum(block.count(b"\n") for block in iter(lambda: stream.read(_BLOCK), b""))


def inflate_blf(path: Path) -> int:
    """Inflate the containers with libdeflate."""
    from deflate import zlib_decompress

    total = 0
    with path.open("rb") as stream:
        stream.seek(144)
        while len(head := stream.read(32)) == 32:
            size, plain = struct.unpack_from("<I", head, 8)[0], struct.unpack_from("<I", head, 24)[0]
            total += len(zlib_decompress(stream.read(size - 32), plain))
            stream.seek(size % 4, 1)
    return total


def inflate_mf4(path: Path) -> int:
    """Inflate the DZ blocks with libdeflate."""
    from deflate import zlib_decompress

    data = path.read_bytes()
    total, at = 0, data.find(b"##DZ")
    while at >= 0:
        plain, packed = struct.unpack_from("<QQ", data, at + 32)
        total += len(zlib_decompress(data[at + 48 : at + 48 + packed], plain))
        at = data.find(b"##DZ", at + 48 + packed)
    return total


def _bag_chunks(path: Path) -> Iterator[bytes]:
    """The data of a ROS 1 bag's chunk records."""
    with path.open("rb") as stream:
        stream.readline()
        while len(head := stream.read(4)) == 4:
            header = stream.read(struct.unpack("<I", head)[0])
            size = struct.unpack("<I", stream.read(4))[0]
            if b"op=\x05" in header:
                yield stream.read(size)
            else:
                stream.seek(size, 1)


def unpack_bag(path: Path) -> int:
    """Unpack a ROS 1 bag's lz4 chunks."""
    import lz4.frame

    return sum(len(lz4.frame.decompress(chunk)) for chunk in _bag_chunks(path))


def unpack_mcap(path: Path) -> int:
    """Unpack an MCAP file's zstd chunks."""
    import zstandard
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader

    unpacker, total = zstandard.ZstdDecompressor(), 0
    with path.open("rb") as stream:
        for record in StreamReader(stream, emit_chunks=True).records:
            if isinstance(record, Chunk):
                total += len(unpacker.decompress(record.data, record.uncompressed_size))
    return total
