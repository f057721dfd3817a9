"""Chunks of a ROS 1 bag that lie one behind the other, read and decoded by one call of a kernel.

A chunk by itself is a tenth of a millisecond of work between calls that each come back for the interpreter's lock: two
cores then wait for each other longer than they work. What is not as recorders write it (other compressions, damage, a chunk's
record that is odd) is left to the slower way, chunk by chunk.
"""

from __future__ import annotations

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel, load_u32
from parsers.jit_foreign import read_at
from parsers.lz4_frames import unpack_frame
from parsers.ros.bag1_kernels import FULL, SEEN, decode_records
from parsers.ros.kernels import Program, Rows, Shapes

DONE, NO_ROW, NO_ROOM, ODD, DAMAGED = range(5)
"""Why `decode_chunks` stopped: all chunks are done; a topic has no row left; the room for an unpacked chunk is too small (STOP
says what it takes); the chunk is for the slower way; it is damaged behind the messages that were decoded."""
CHUNK, AT, STOP, BEFORE, WHY = range(5)
STATE = 8
"""Size of the state: the chunk, where in it to go on (-1: at its beginning) and where it stops, what was SEEN before it, WHY.
The rest is for the calls of the library."""
_PARTS = 6
_OP_CHUNK, _NONE, _LZ4 = 5, 4, 3
_MAX_RATIO, _MAX_CHUNK = 256, 1 << 30
_EQUALS = 61


@lean_kernel
def _is_text(data: ByteArray, at: int, first: int, second: int, third: int) -> bool:
    return bool(data[at] == first and data[at + 1] == second and data[at + 2] == third)


@lean_kernel
def _chunk_record(data: ByteArray, at: int, limit: int) -> tuple[int, int, int, int]:
    """Of the chunk's record at `at`: (kind, where its data begin, their size, their size unpacked); kind 0: it is odd."""
    if limit - at < 8:
        return 0, 0, 0, 0
    size = load_u32(data, at)
    if size > limit - at - 8:
        return 0, 0, 0, 0
    here, body = at + 4, at + 4 + size
    op, kind, declared = -1, 0, -1
    while here < body:
        if body - here < 4:
            return 0, 0, 0, 0
        part = load_u32(data, here)
        here += 4
        if part < 4 or part > body - here:
            return 0, 0, 0, 0
        # op=, size=, compression=none or lz4
        named = part >= 12 + _LZ4 and _is_text(data, here, 99, 111, 109) and data[here + 11] == _EQUALS
        if part == 4 and _is_text(data, here, 111, 112, _EQUALS):
            op = int(data[here + 3])
        elif part == 9 and _is_text(data, here, 115, 105, 122) and data[here + 4] == _EQUALS:
            declared = load_u32(data, here + 5)
        elif part == 12 + _NONE and named and _is_text(data, here + 13, 111, 110, 101):
            kind = _NONE
        elif part == 12 + _LZ4 and named and _is_text(data, here + 12, 108, 122, 52):
            kind = _LZ4
        here += part
    held = load_u32(data, body)
    if kind == _NONE:
        declared = held
    fits = op == _OP_CHUNK and 0 <= declared <= _MAX_CHUNK and held <= limit - body - 4
    if not fits or declared > _MAX_RATIO * (held + 64):
        return 0, 0, 0, 0
    return kind, body + 4, held, declared


@lean_kernel
def _unpacked(
    kind: int,
    begin: int,
    held: int,
    declared: int,
    data: ByteArray,
    room: ByteArray,
    reset: int,
    decompress: int,
    context: int,
    state: IntArray,
) -> bool:
    """Set where a chunk's records begin and stop, in `room` where it had to be unpacked; False where that is not to be done here."""
    if kind == _NONE:
        state[AT], state[STOP] = begin, begin + held
        return True
    if kind == 0 or decompress == 0:
        return False
    if room.size <= declared:
        state[STOP], state[WHY] = declared + 1, NO_ROOM
        return False
    if unpack_frame(data, begin, held, room, 0, reset, decompress, context, state, _PARTS) != declared:
        return False
    state[AT], state[STOP] = 0, declared
    return True


@kernel
def decode_chunks(
    pread: int,
    file: int,
    starts: IntArray,
    data: ByteArray,
    room: ByteArray,
    reset: int,
    decompress: int,
    context: int,
    ids: IntArray,
    topics: IntArray,
    program: Program,
    shapes: Shapes,
    rows: Rows,
    offset: IntArray,
    length: IntArray,
    receive: IntArray,
    tally: IntArray,
    state: IntArray,
) -> None:
    """Decode the chunks from state[CHUNK] on, until one of them is not to be done here.

    pread, file: see `parsers.jit_foreign`. starts: (chunks + 1,) where in the file each chunk's record begins, and the end of
    the last. data: for the longest of them as it lies in the file. room: for one chunk unpacked and a byte more. reset,
    decompress, context: `lz4_frames.Addresses`, 0 where there are none. The rest as of
    `parsers.ros.bag1_kernels.decode_records`. state: (STATE,), see above.
    """
    while state[CHUNK] < starts.size - 1:
        number = state[CHUNK]
        size = starts[number + 1] - starts[number]
        if state[AT] < 0:
            state[BEFORE], state[WHY] = tally[SEEN], ODD
            if size > data.size or read_at(pread, file, starts[number], size, data, 0) < size:
                return
        kind, begin, held, declared = _chunk_record(data, 0, size)
        if state[AT] < 0 and not _unpacked(
            kind, begin, held, declared, data, room, reset, decompress, context, state
        ):
            return
        at, stop = state[AT], state[STOP]
        if kind == _LZ4:
            at = decode_records(
                room, at, stop, ids, topics, program, shapes, rows, offset, length, receive, tally
            )
        else:
            at = decode_records(
                data, at, stop, ids, topics, program, shapes, rows, offset, length, receive, tally
            )
        if tally[FULL]:
            state[AT], state[WHY] = at, NO_ROW
            return
        if at != stop:
            state[WHY] = DAMAGED
            return
        state[CHUNK], state[AT] = number + 1, -1
    state[WHY] = DONE
