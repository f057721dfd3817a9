"""One chunk of an MCAP file read, unpacked and checked inside a kernel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.inflate import crc32_address
from parsers.jit import kernel, lean_kernel, load_u32, load_u64
from parsers.jit_foreign import address_of_byte, call_3, call_5, pread_address, read_at
from parsers.lz4_frames import unpack_frame
from parsers.mcap_chunks import MAX_CHUNK_BYTES, ChunkSpan, McapFile, Scratch
from parsers.mcap_pick import signed
from parsers.mcap_records import CHUNK, RECORD_HEAD

DONE, NO_ROOM, ODD, BROKEN, ENOUGH, NO_ROW = range(6)
"""Why a kernel over chunks stopped: all are done; the buffer is too small (NEEDED says what is needed); the chunk is for the
slower way; the walk over its records broke off; there are enough records to be decoded; a topic has too few rows left."""
NEXT, WHY, NEEDED, SHORT, AT, SIZE, USED, COUNT, SHORT_HERE = range(9)
"""The state of such a kernel: the chunk to go on with; why it stopped; bytes of records that there must be room for; message
records too short so far; where in a broken chunk the walk stopped, and the chunk's size; bytes of records and picked messages
so far; message records of the chunk that are too short. The rest is for the calls of the library."""
_PARTS = 9
STATE = 11
MAX_PACKED = 1 << 24
"""Longer chunks are read by themselves."""
_HEAD = RECORD_HEAD + 48
"""Bytes of a chunk before its records, with a name of compression of up to eight."""
_NAME = RECORD_HEAD + 32
_NONE, _ZSTD, _LZ4, _OTHER = range(4)
_ZSTD_TEXT, _LZ4_TEXT = (int.from_bytes(name, "little") for name in (b"zstd", b"lz4"))


class Chunks(NamedTuple):
    """Some chunks of a file, for kernels. pread, file: see `parsers.jit_foreign`. starts, lengths: (chunks,) where in the file
    each one's record is; one with a length of 0 is for the slower way."""

    pread: int
    file: int
    starts: IntArray
    lengths: IntArray


class Tools(NamedTuple):
    """What unpacks them. packed: room for a chunk as it lies in the file. zstd, zstd_context, crc32: addresses, 0 where there
    are none; lz4_…: `lz4_frames.Addresses`."""

    packed: ByteArray
    zstd: int
    zstd_context: int
    lz4_reset: int
    lz4_decompress: int
    lz4_context: int
    crc32: int


def chunks_of(file: McapFile, spans: Sequence[ChunkSpan], plain: Sequence[bool]) -> Chunks:
    """plain: which of them are whole, and to be read whole."""
    pread, number = pread_address(), file.descriptor
    ready = pread != 0 and number >= 0
    lengths = [span.length * (ready and each) for span, each in zip(spans, plain, strict=True)]
    return Chunks(
        pread, number, np.array([span.offset for span in spans], np.int64), np.array(lengths, np.int64)
    )


def tools_of(scratch: Scratch, chunks: Chunks) -> Tools:
    """Those of a thread; good as long as its scratch is."""
    lz4, zstd = scratch.lz4.addresses, scratch.context
    packed = scratch.packed(int(min(chunks.lengths.max(), MAX_PACKED)))
    return Tools(
        packed, zstd.decompress, zstd.context, lz4.reset, lz4.decompress, lz4.context, crc32_address()
    )


@lean_kernel
def _compression(packed: ByteArray) -> int:
    length, text = load_u32(packed, _NAME - 4), load_u32(packed, _NAME)
    if length == 0:
        return _NONE
    if length == 4 and text == _ZSTD_TEXT:
        return _ZSTD
    return _LZ4 if length == 3 and text & 0xFFFFFF == _LZ4_TEXT else _OTHER


@kernel
def unpack_chunk(
    chunks: Chunks, tools: Tools, number: int, room: ByteArray, used: int, state: IntArray
) -> int:
    """How many bytes of records of a chunk came to room[used:]; -1 where it is ODD or there is NO_ROOM, as the state says.

    state: (STATE,), see above.
    """
    state[WHY] = ODD
    packed, start, length = tools.packed, chunks.starts[number], chunks.lengths[number]
    if length < _HEAD or length > packed.size:
        return -1
    pread, file = chunks.pread, chunks.file
    if read_at(pread, file, start, _HEAD, packed, 0) < _HEAD or packed[0] != CHUNK:
        return -1
    kind = _compression(packed)
    if kind == _OTHER or (kind == _ZSTD and tools.zstd == 0) or (kind == _LZ4 and tools.lz4_decompress == 0):
        return -1
    content, size = signed(load_u64(packed, 1)), signed(load_u64(packed, RECORD_HEAD + 16))
    crc, name = load_u32(packed, RECORD_HEAD + 24), load_u32(packed, _NAME - 4)
    held, body = signed(load_u64(packed, _NAME + name)), _NAME + name + 8
    if content != length - RECORD_HEAD or held != length - body or not 0 <= size <= MAX_CHUNK_BYTES:
        return -1
    if room.size - used < size:
        state[WHY], state[NEEDED] = NO_ROOM, size
        return -1
    if kind == _NONE:
        got = read_at(pread, file, start + body, held, room, used) if held == size else -1
    elif read_at(pread, file, start + body, held, packed, 0) < held:
        return -1
    elif kind == _ZSTD:
        # an error is a number just below 2**64
        place, source = address_of_byte(room, used), address_of_byte(packed, 0)
        got = call_5(tools.zstd, tools.zstd_context, place, size, source, held)
    else:
        got = unpack_frame(
            packed, 0, held, room, used, tools.lz4_reset, tools.lz4_decompress, tools.lz4_context, state, _PARTS
        )  # fmt: skip
    if got != size:
        return -1
    # a checksum has 32 bits: what is above them may be anything
    if crc and (
        tools.crc32 == 0 or call_3(tools.crc32, 0, address_of_byte(room, used), size) & 0xFFFFFFFF != crc
    ):
        return -1
    return int(size)
