"""The compressed data blocks (DZ) of MF4: one function, so that a faster inflater needs one change."""

from __future__ import annotations

import io
import zlib

import deflate
import numpy as np

from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.inflate import inflate_all
from parsers.mf4.transpose import records_of

MAX_INFLATED = 256 << 20
"""Bytes of one block; writers keep to 4 MiB, a claim beyond this is damage and nothing is allocated for it."""
MAX_RATIO = 1100
"""Deflate makes at most 1032 bytes out of one; more is only possible for zstd and lz4, on data that is all alike."""
_DEFLATE, _ZSTD, _LZ4 = (0, 1), (2, 3), (4, 5)
TRANSPOSED = (1, 3, 5)
"""The methods whose bytes were transposed before."""


def _deflated(data: bytes, size: int) -> bytearray:
    try:
        return deflate.zlib_decompress(data, size)
    except deflate.DeflateError as error:
        raise LogError("a compressed block is damaged") from error


def _zstd(data: bytes, size: int) -> bytearray:
    # most files need neither this nor lz4: loaded when one does
    import zstandard

    try:
        with zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)) as reader:
            return bytearray(reader.read(size + 1))
    except zstandard.ZstdError as error:
        raise LogError(f"a compressed block is damaged ({error})") from error


def _lz4(data: bytes, size: int) -> bytearray:
    import lz4.frame

    try:
        return bytearray(lz4.frame.LZ4FrameDecompressor().decompress(data, size + 1))
    except (RuntimeError, EOFError) as error:
        raise LogError(f"a compressed block is damaged ({error})") from error


def inflate(data: bytes, method: int, size: int, columns: int) -> ByteArray:
    """Inflate one block to exactly `size` bytes; methods 1, 3 and 5 were transposed by `columns` bytes before.

    May be called from several threads. Raises LogError where the block is damaged.
    """
    if not 0 < size <= MAX_INFLATED or (method in _DEFLATE and size > MAX_RATIO * max(len(data), 1)):
        raise LogError(f"a compressed block of {len(data)} bytes cannot hold {size} bytes")
    # each asks for one byte more than claimed, or fails at it, so that a wrong claim is seen
    if method in _DEFLATE:
        raw = _deflated(data, size)
    elif method in _ZSTD:
        raw = _zstd(data, size)
    elif method in _LZ4:
        raw = _lz4(data, size)
    else:
        raise LogError(f"compression method {method} of an MF4 block is not known")
    if len(raw) != size:
        raise LogError(f"a compressed block holds {len(raw)} bytes, {size} expected")
    # of a bytearray, never of bytes: kernels are compiled for arrays that can be written to
    flat = np.frombuffer(raw, np.uint8)
    return records_of(flat, columns) if method in TRANSPOSED else flat


def inflate_into(data: ByteArray, method: int, columns: int, out: ByteArray, spare: ByteArray) -> None:
    """As `inflate`, to fill `out`. spare: room for as many bytes, where the method transposes.

    Kernels do it all for deflated blocks: a thread then asks for the interpreter's lock but a few times, and no fresh memory is
    touched.
    """
    if method in _DEFLATE:
        target = spare[: out.size] if method in TRANSPOSED else out
        begin, size, room = (np.array([number], np.int64) for number in (0, data.size, out.size))
        whole = inflate_all(data, begin, size, target, begin, room)
        if whole is not None and whole[0]:
            if method in TRANSPOSED:
                records_of(target, columns, out)
            return
    # what another method packed, or why it is damaged
    out[:] = inflate(data.tobytes(), method, out.size, columns)


def first_bytes(data: bytes, size: int) -> bytes:
    """What can be inflated of a deflated block that the file's end cut short; at most `size` bytes, perhaps none."""
    try:
        return zlib.decompressobj().decompress(data, min(size, MAX_INFLATED))
    except zlib.error:
        return b""
