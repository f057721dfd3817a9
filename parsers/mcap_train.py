"""Chunks of an MCAP file read, unpacked, checked and walked by one call of a kernel.

A chunk by itself takes a quarter of a millisecond, between some ten calls that each come back for the interpreter's lock: two
cores then wait for each other. What is not as recorders write it (other compressions, damage, a chunk's record that is odd)
is left to the slower way, chunk by chunk.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.inflate import crc32_address
from parsers.jit import kernel, lean_kernel, load_u32, load_u64
from parsers.jit_foreign import address_of_byte, call_3, call_5, pread_address, read_at
from parsers.lz4_frames import unpack_frame
from parsers.mcap_chunks import MAX_CHUNK_BYTES, ChunkSpan, McapFile, Scratch
from parsers.mcap_pick import LEAST, Picker, Slots, pick, signed
from parsers.mcap_records import CHUNK, RECORD_HEAD, WALK_CUT, WALK_INVALID

DONE, ENOUGH, NO_ROOM, ODD, BROKEN = range(5)
"""Why the kernel stopped: all chunks are done; the buffer holds enough records to be decoded; it is too small (NEEDED says what
is needed); the chunk is for the slower way; the walk over its records broke off."""
NEXT, USED, COUNT, SHORT, WHY, NEEDED, AT, SIZE = range(8)
"""The state: the chunk to go on with; bytes of records and picked messages so far; message records too short; why it stopped;
bytes of records that there must be room for; where in the broken chunk the walk stopped, and its size."""
_PARTS = 8
STATE = 10
MAX_PACKED = 1 << 24
"""Longer chunks are read by themselves."""
_HEAD = RECORD_HEAD + 48
"""Bytes of a chunk before its records, with a name of compression of up to eight."""
_NAME = RECORD_HEAD + 32
_NONE, _ZSTD, _LZ4, _OTHER = range(4)
_ZSTD_TEXT, _LZ4_TEXT = (int.from_bytes(name, "little") for name in (b"zstd", b"lz4"))


@lean_kernel
def _compression(packed: ByteArray) -> int:
    length, text = load_u32(packed, _NAME - 4), load_u32(packed, _NAME)
    if length == 0:
        return _NONE
    if length == 4 and text == _ZSTD_TEXT:
        return _ZSTD
    return _LZ4 if length == 3 and text & 0xFFFFFF == _LZ4_TEXT else _OTHER


@kernel
def take_chunks(
    pread: int,
    file: int,
    starts: IntArray,
    lengths: IntArray,
    packed: ByteArray,
    room: ByteArray,
    zstd: int,
    zstd_context: int,
    lz4_reset: int,
    lz4_decompress: int,
    lz4_context: int,
    crc32: int,
    slot_of: Slots,
    picked: IntArray,
    enough: int,
    state: IntArray,
) -> None:
    """Collect the wanted messages of the chunks from state[NEXT] on, until one of them is not to be done here.

    pread, file: see `parsers.jit_foreign`. starts, lengths: (chunks,) where in the file each chunk's record is; one with a
    length of 0 is for the slower way. packed: for a chunk as it lies in the file. room: for records, of which there are
    state[USED] bytes already. zstd, zstd_context, crc32: addresses, 0 where there are none; lz4_…: `lz4_frames.Addresses`.
    slot_of, picked: see `parsers.mcap_pick`. enough: bytes of records at which to stop. state: (STATE,), see above.
    """
    while state[NEXT] < starts.size:
        state[WHY] = ODD
        start, length = starts[state[NEXT]], lengths[state[NEXT]]
        if length < _HEAD or length > packed.size:
            return
        if read_at(pread, file, start, _HEAD, packed, 0) < _HEAD or packed[0] != CHUNK:
            return
        kind = _compression(packed)
        if kind == _OTHER or (kind == _ZSTD and zstd == 0) or (kind == _LZ4 and lz4_decompress == 0):
            return
        content, size = signed(load_u64(packed, 1)), signed(load_u64(packed, RECORD_HEAD + 16))
        crc, name = load_u32(packed, RECORD_HEAD + 24), load_u32(packed, _NAME - 4)
        held, body = signed(load_u64(packed, _NAME + name)), _NAME + name + 8
        if content != length - RECORD_HEAD or held != length - body or not 0 <= size <= MAX_CHUNK_BYTES:
            return
        used = state[USED]
        if room.size - used < size or picked.shape[1] - state[COUNT] < size // LEAST:
            state[WHY], state[NEEDED] = NO_ROOM, size
            return
        if kind == _NONE:
            got = read_at(pread, file, start + body, held, room, used) if held == size else -1
        elif read_at(pread, file, start + body, held, packed, 0) < held:
            return
        elif kind == _ZSTD:
            # an error is a number just below 2**64
            place, source = address_of_byte(room, used), address_of_byte(packed, 0)
            got = call_5(zstd, zstd_context, place, size, source, held)
        else:
            got = unpack_frame(
                packed, 0, held, room, used, lz4_reset, lz4_decompress, lz4_context, state, _PARTS
            )
        if got != size:
            return
        # a checksum has 32 bits: what is above them may be anything
        if crc and (crc32 == 0 or call_3(crc32, 0, address_of_byte(room, used), size) & 0xFFFFFFFF != crc):
            return
        count, at, why, short = pick(room, used, used + size, slot_of, picked, state[COUNT])
        state[NEXT] += 1
        state[USED], state[COUNT], state[SHORT] = used + size, count, state[SHORT] + short
        if why in (WALK_CUT, WALK_INVALID):
            state[AT], state[SIZE], state[WHY] = at - used, size, BROKEN
            return
        if state[USED] >= enough:
            state[WHY] = ENOUGH
            return
    state[WHY] = DONE


class Train:
    """Some chunks on their way through `take_chunks`; of one thread."""

    def __init__(self, file: McapFile, spans: Sequence[ChunkSpan], plain: Sequence[bool]) -> None:
        """plain: which chunks are whole, and read whole."""
        self._file, self._pread = file.descriptor, pread_address()
        ready = self._pread != 0 and self._file >= 0
        self._starts = np.array([span.offset for span in spans], np.int64)
        lengths = [span.length * (ready and each) for span, each in zip(spans, plain, strict=True)]
        self._lengths = np.array(lengths, np.int64)
        self._state = np.zeros(STATE, np.int64)
        self._longest = int(min(self._lengths.max(), MAX_PACKED))

    @property
    def chunk(self) -> int:
        """The chunk to go on with."""
        return int(self._state[NEXT])

    def skip(self) -> None:
        """Leave the next chunk out."""
        self._state[NEXT] += 1

    @property
    def short(self) -> int:
        """Message records too short for their own head, so far."""
        return int(self._state[SHORT])

    @property
    def at(self) -> int:
        """Where in a broken chunk the walk stopped."""
        return int(self._state[AT])

    @property
    def size(self) -> int:
        """Bytes of a broken chunk."""
        return int(self._state[SIZE])

    def run(self, scratch: Scratch, picker: Picker, slot_of: Slots, enough: int) -> int:
        """Go on from the next chunk; why it stopped: DONE, ENOUGH, ODD (the next chunk is), BROKEN (the one before was)."""
        state, lz4 = self._state, scratch.lz4.addresses
        state[USED], state[COUNT] = scratch.used, picker.count
        while True:
            take_chunks(
                self._pread,
                self._file,
                self._starts,
                self._lengths,
                scratch.packed(self._longest),
                scratch.records,
                scratch.context.decompress,
                scratch.context.context,
                lz4.reset,
                lz4.decompress,
                lz4.context,
                crc32_address(),
                slot_of,
                picker.picked,
                enough,
                state,
            )
            scratch.used, picker.count = int(state[USED]), int(state[COUNT])
            if state[WHY] != NO_ROOM:
                return int(state[WHY])
            scratch.room(int(state[NEEDED]))
            picker.make_room(int(state[NEEDED]))
