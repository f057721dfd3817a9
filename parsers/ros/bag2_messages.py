"""Messages of a ROS 2 bag that were compressed one by one (rosbag2's "message" mode)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.jit import kernel, load_u16, load_u32, load_u64
from parsers.ros.bag2_rows import Rows

ZSTD_MARK = 0xFD2FB528
"""The first four bytes of a zstd frame as a little-endian number."""
MAX_MESSAGE = 1 << 27
BATCH_BYTES = 1 << 25
_PLAIN, _UNKNOWN = -2, -1


@kernel
def frame_size(data: ByteArray, at: int, length: int) -> int:
    """The size of what a zstd frame of `length` bytes holds, as its header says; else _UNKNOWN, or _PLAIN for no frame."""
    if length < 4 or load_u32(data, at) != ZSTD_MARK:
        return _PLAIN
    if length < 18:  # the longest header: so short a frame is read as if zeros followed
        short = np.zeros(32, np.uint8)
        short[:length] = data[at : at + length]
        return frame_size_of(short, 0)
    return frame_size_of(data, at)


@kernel
def frame_size_of(data: ByteArray, at: int) -> int:
    """The same, where 18 bytes from `at` on may be read."""
    about = int(np.int64(data[at + 4]))
    single, code = (about >> 5) & 1, about >> 6
    field = at + 5 + (1 - single) + (0, 1, 2, 4)[about & 3]
    if code == 0:
        return int(np.int64(data[field])) if single else _UNKNOWN
    if code == 1:
        return load_u16(data, field) + 256
    if code == 2:
        return load_u32(data, field)
    size = load_u64(data, field)
    return int(np.int64(size)) if size < np.uint64(1 << 62) else _UNKNOWN


@kernel
def frame_sizes(data: ByteArray, offset: IntArray, length: IntArray, out: IntArray) -> int:
    """`frame_size` of all payloads; how many of them are zstd frames. Payloads are inside of `data`."""
    frames = 0
    for i in range(offset.shape[0]):
        out[i] = frame_size(data, offset[i], length[i])
        frames += out[i] != _PLAIN
    return frames


def unpack_messages(rows: Rows, log: ImportLog) -> Iterator[Rows]:
    """The same messages uncompressed; as they are where they are not compressed (plain CDR never looks like zstd).

    Sizes are taken from the frames' headers and checked before anything is unpacked.
    """
    sizes = np.empty(len(rows.offset), dtype=np.int64)
    data = rows.data.view()
    data.flags.writeable = False  # whatever it was, so that the kernel is compiled once
    packed = frame_sizes(data, rows.offset, rows.length, sizes)
    if not packed:
        yield rows
        return
    log.reject("message that is not compressed, in a compressed bag", len(sizes) - packed)
    which = np.flatnonzero((sizes > 0) & (sizes <= MAX_MESSAGE))
    log.reject("compressed message of unknown or impossible size", packed - len(which))
    part = np.cumsum(sizes[which]) // BATCH_BYTES
    for number in np.unique(part):
        at = which[part == number]
        unpacked, length, good = unpack_at(rows, at, sizes[at])
        log.reject("compressed message that is damaged", int((~good).sum()))
        at = at[good]
        yield Rows(rows.topic_id[at], rows.time_ns[at], np.cumsum(length) - length, length, unpacked)


def unpack_at(rows: Rows, at: IntArray, sizes: IntArray) -> tuple[ByteArray, IntArray, NDArray[np.bool_]]:
    """Unpack the frames at rows `at`, of `sizes` each: bytes of the whole ones joined, their lengths, and which were whole."""
    import zstandard

    unpacker = zstandard.ZstdDecompressor(max_window_size=MAX_MESSAGE)
    offset, length = rows.offset[at], rows.length[at]
    good = np.ones(len(at), dtype=np.bool_)
    joined = _unpack_at_once(unpacker, rows.data, np.stack([offset, length], axis=1), sizes)
    if joined is not None:
        return joined, sizes, good
    parts: list[bytes] = []
    for i, (start, size) in enumerate(zip(offset.tolist(), length.tolist(), strict=True)):
        try:
            parts.append(unpacker.decompress(rows.data[start : start + size].tobytes()))
        except zstandard.ZstdError:
            good[i] = False
    found = np.fromiter(map(len, parts), dtype=np.int64, count=len(parts))
    return np.frombuffer(b"".join(parts), dtype=np.uint8), found, good


def _unpack_at_once(unpacker: Any, data: ByteArray, places: IntArray, sizes: IntArray) -> ByteArray | None:
    """The frames at places (n, 2: offset, length) joined; None where one is damaged, or this build cannot take many."""
    import zstandard

    if "multi_decompress_to_buffer" not in zstandard.backend_features:
        return None
    frames = zstandard.BufferWithSegments(data.data, places.astype(np.uint64).tobytes())
    sizes_64 = sizes.astype(np.uint64).tobytes()
    try:
        whole: Any = unpacker.multi_decompress_to_buffer(frames, decompressed_sizes=sizes_64, threads=1)
    except zstandard.ZstdError:
        return None
    return np.frombuffer(b"".join(map(whole.__getitem__, range(len(places)))), dtype=np.uint8)
