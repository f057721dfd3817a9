"""Messages of a ROS 2 bag that were compressed one by one (rosbag2's "message" mode)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.jit import kernel, load_u16, load_u32, load_u64
from parsers.jit_foreign import address_of_byte, call_5
from parsers.ros.bag2_rows import Rows
from parsers.zstd_frames import ZstdContext

ZSTD_MARK = 0xFD2FB528
"""The first four bytes of a zstd frame as a little-endian number."""
MAX_MESSAGE = 1 << 27
BATCH_BYTES = 1 << 25
_PLAIN, _UNKNOWN = -2, -1


class ZstdPlace(NamedTuple):
    """Addresses of libzstd's ZSTD_decompressDCtx and of its context."""

    decompress: int
    context: int


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


@kernel
def _unpack_all(
    data: ByteArray,
    places: IntArray,
    sizes: IntArray,
    zstd: ZstdPlace,
    room: ByteArray,
    good: NDArray[np.bool_],
) -> int:
    """Unpack frames at places (n, 2: offset, length), each of the size that its header says, one behind the other; the bytes used.

    What does not come to its size is not good, and takes no room.
    """
    used = 0
    for i in range(len(sizes)):
        source, place = address_of_byte(data, places[i, 0]), address_of_byte(room, used)
        # an error is a number just below 2**64
        got = call_5(zstd.decompress, zstd.context, place, sizes[i], source, places[i, 1])
        good[i] = got == sizes[i]
        used += sizes[i] if good[i] else 0
    return used


def unpack_at(rows: Rows, at: IntArray, sizes: IntArray) -> tuple[ByteArray, IntArray, NDArray[np.bool_]]:
    """Unpack the frames at rows `at`, of `sizes` each: bytes of the whole ones joined, their lengths, and which were whole."""
    places = np.stack([rows.offset[at], rows.length[at]], axis=1)
    good = np.ones(len(at), dtype=np.bool_)
    library = ZstdContext()
    if not library.decompress:
        return _one_by_one(rows.data, places, good)
    # an address of a byte behind the last is never written to, but is asked for
    room = np.empty(int(sizes.sum()) + 1, dtype=np.uint8)
    place = ZstdPlace(library.decompress, library.context)
    used = _unpack_all(rows.data, places, np.ascontiguousarray(sizes), place, room, good)
    return room[:used], sizes[good], good


def _one_by_one(
    data: ByteArray, places: IntArray, good: NDArray[np.bool_]
) -> tuple[ByteArray, IntArray, NDArray[np.bool_]]:
    """As `unpack_at`, through the interpreter: for a build of the package `zstandard` that keeps its library to itself."""
    import zstandard

    unpacker = zstandard.ZstdDecompressor(max_window_size=MAX_MESSAGE)
    parts: list[bytes] = []
    for i, (start, size) in enumerate(places.tolist()):
        try:
            parts.append(unpacker.decompress(data[start : start + size].tobytes()))
        except zstandard.ZstdError:
            good[i] = False
    found = np.fromiter(map(len, parts), dtype=np.int64, count=len(parts))
    return np.frombuffer(b"".join(parts), dtype=np.uint8), found, good
