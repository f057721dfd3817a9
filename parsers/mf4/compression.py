"""The compressed data blocks (DZ) of MF4: one function, so that a faster inflater needs one change."""

from __future__ import annotations

import io
import zlib

import lz4.frame
import numpy as np
import zstandard

from parsers.errors import LogError

MAX_INFLATED = 256 << 20
"""Bytes of one block; writers keep to 4 MiB, a claim beyond this is damage and nothing is allocated for it."""
MAX_RATIO = 1100
"""Deflate makes at most 1032 bytes out of one; more is only possible for zstd and lz4, on data that is all alike."""
_DEFLATE, _ZSTD, _LZ4 = (0, 1), (2, 3), (4, 5)


def _inflate(data: bytes, method: int, size: int) -> bytes:
    """At most size + 1 bytes, so that a wrong claim is seen."""
    if method in _DEFLATE:
        return zlib.decompressobj().decompress(data, size + 1)
    if method in _ZSTD:
        with zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)) as reader:
            return reader.read(size + 1)
    if method in _LZ4:
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, size + 1))
    raise LogError(f"compression method {method} of an MF4 block is not known")


def inflate(data: bytes, method: int, size: int, columns: int) -> bytes:
    """Inflate one block to exactly `size` bytes; methods 1, 3 and 5 were transposed by `columns` bytes before.

    Raises LogError where the block is damaged.
    """
    if not 0 < size <= MAX_INFLATED or (method in _DEFLATE and size > MAX_RATIO * max(len(data), 1)):
        raise LogError(f"a compressed block of {len(data)} bytes cannot hold {size} bytes")
    try:
        raw = _inflate(data, method, size)
    except (zlib.error, zstandard.ZstdError, RuntimeError, EOFError) as error:
        raise LogError(f"a compressed block is damaged ({error})") from error
    if len(raw) != size:
        raise LogError(f"a compressed block holds {len(raw)} bytes, {size} expected")
    if method % 2 == 0 or columns < 2:
        return raw
    lines = size // columns
    body = np.frombuffer(raw, np.uint8, lines * columns).reshape(columns, lines)
    return body.T.tobytes() + raw[lines * columns :]
