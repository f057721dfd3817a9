"""Messages of a ROS 2 bag that were compressed one by one (rosbag2's "message" mode)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.ros.bag2_database import Rows

ZSTD_MAGIC = 0xFD2FB528
MAX_MESSAGE = 1 << 27
BATCH_BYTES = 1 << 25


def _magics(rows: Rows) -> IntArray:
    """The first four bytes of each payload as a number, 0 for shorter ones."""
    long = rows.length >= 4
    first = np.where(long, rows.offset, 0)[:, None] + np.arange(4)
    quads = rows.data[np.minimum(first, max(0, len(rows.data) - 1))].astype(np.int64)
    return np.where(long, quads @ np.array([1, 1 << 8, 1 << 16, 1 << 24]), 0)


def unpack_messages(rows: Rows, log: ImportLog) -> Iterator[Rows]:
    """The same messages uncompressed; as they are where they are not compressed (plain CDR never looks like zstd).

    Sizes are taken from the frames' headers and checked before anything is unpacked.
    """
    if not len(rows.data):
        yield rows
        return
    packed = _magics(rows) == ZSTD_MAGIC
    if not packed.any():
        yield rows
        return
    import zstandard

    blobs = np.split(rows.data, rows.offset[1:])
    chosen = [blobs[i].tobytes() for i in np.flatnonzero(packed)]
    sizes = np.fromiter(map(zstandard.frame_content_size, chosen), dtype=np.int64, count=len(chosen))
    kept = np.flatnonzero((sizes > 0) & (sizes <= MAX_MESSAGE))
    log.reject("compressed message of unknown or impossible size", len(chosen) - len(kept))
    log.reject("message that is not compressed, in a compressed bag", int((~packed).sum()))
    which = np.flatnonzero(packed)[kept]
    part = np.cumsum(sizes[kept]) // BATCH_BYTES
    for number in np.unique(part):
        members = np.flatnonzero(part == number)
        data, length, good = _unpack([chosen[i] for i in kept[members]])
        log.reject("compressed message that is damaged", int((~good).sum()))
        at = which[members][good]
        yield Rows(rows.topic_id[at], rows.time_ns[at], np.cumsum(length) - length, length, data)


def _unpack(frames: list[bytes]) -> tuple[ByteArray, IntArray, np.ndarray[tuple[int], np.dtype[np.bool_]]]:
    """Unpack frames: joined bytes, length of each, and which of them were whole."""
    import zstandard

    unpacker = zstandard.ZstdDecompressor(max_window_size=MAX_MESSAGE)
    good = np.ones(len(frames), dtype=np.bool_)
    try:
        parts = list(map(unpacker.decompress, frames))
    except zstandard.ZstdError:
        parts = []  # one of them is damaged: only then they are looked at one by one
        for i, frame in enumerate(frames):
            try:
                parts.append(unpacker.decompress(frame))
            except zstandard.ZstdError:
                good[i] = False
    length = np.fromiter(map(len, parts), dtype=np.int64, count=len(parts))
    return np.frombuffer(b"".join(parts), dtype=np.uint8), length, good
