"""The compiled walks over the records of a ROS 1 bag's chunk: listing what is in it, and decoding what is wanted."""

from __future__ import annotations

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel, load_u32
from parsers.ros.kernels import FILL, ROOM, STAMP_ROW, Program, Rows, Shapes
from parsers.ros.replay import decode_rows

OP_MESSAGE, OP_CONNECTION = 2, 7
OP_CHUNK_INFO = 6
_EQUALS, _C, _E, _O, _S, _T = 61, 99, 101, 111, 115, 116

SEEN, LAST_NS, NEXT, NEXT_NS, NEEDED, FULL, BAD = range(7)
TALLY = 7
"""What `decode_records` keeps: how many messages of any topic it passed and the receive time of the last of them;
where the record that it stopped at ends (CUT: its header is not whole, BROKEN: it is no record), its receive time
(-1: no message) and whether it is wanted; whether a topic had no row left; how many wanted messages did not fit
their type."""
CUT, BROKEN = -1, -2


@lean_kernel
def record_header(data: ByteArray, at: int, stop: int) -> tuple[int, int, int]:
    """(op, connection, stamp in ns) of a record's header data[at:stop], -1 for those it has not; op -1: it is broken."""
    op, connection, stamp = -1, -1, -1
    while at < stop:
        if stop - at < 4:
            return -1, -1, -1
        part = load_u32(data, at)
        at += 4
        if part < 1 or part > stop - at:
            return -1, -1, -1
        # "op=" and a byte, "conn=" and 4 bytes, "time=" and 8 bytes; no other field of a message is needed
        if part == 4 and data[at] == _O and data[at + 2] == _EQUALS:
            op = int(data[at + 3])
        elif part == 9 and data[at] == _C and data[at + 4] == _EQUALS:
            connection = load_u32(data, at + 5)
        elif part == 13 and data[at] == _T and data[at + 4] == _EQUALS:
            stamp = load_u32(data, at + 5) * 1_000_000_000 + load_u32(data, at + 9)
        at += part
    if op == OP_MESSAGE and (connection < 0 or stamp < 0):
        op = -1
    return op, connection, stamp


@kernel
def walk_records(
    data: ByteArray, bare: bool, conn: IntArray, time_ns: IntArray, offset: IntArray, length: IntArray
) -> tuple[int, int]:
    """Walk the records of a chunk; (how many were found, where the walk stopped).

    The walk stops before the first record that does not fit; at data's end where all do. Found are messages (their
    connection, receive time and payload) and connections (conn -1, the whole record). Outputs of no length: count only.
    bare: stop before the first record of another kind, too.
    """
    total = data.shape[0]
    room = conn.shape[0]
    pos, found = 0, 0
    while total - pos >= 8:
        size = load_u32(data, pos)
        if size > total - pos - 8:
            break
        body = pos + 4 + size
        op, connection, stamp = record_header(data, pos + 4, body)
        payload, start = load_u32(data, body), body + 4
        if op < 0 or payload > total - start:
            break
        if op == OP_MESSAGE:
            if found < room:
                conn[found], time_ns[found] = connection, stamp
                offset[found], length[found] = start, payload
            found += 1
        elif op == OP_CONNECTION:
            if found < room:
                conn[found], time_ns[found] = -1, 0
                offset[found], length[found] = pos, start + payload - pos
            found += 1
        elif bare:
            break
        pos = start + payload
    return found, pos


@kernel
def chunk_infos(data: ByteArray, pos: int, infos: IntArray) -> tuple[int, int]:
    """Take in records of chunks' contents one after the other: (how many there were, where the next record begins).

    infos: (most, 5) place of the chunk, first and last time in ns (-1: not given), where the pairs of connection and
    count begin in `data`, how many there are. It stops at the first record that is no such one, or is broken.
    """
    found, total = 0, data.shape[0]
    while found < infos.shape[0] and total - pos >= 8:
        size = load_u32(data, pos)
        if size > total - pos - 8:
            break
        at, body = pos + 4, pos + 4 + size
        op, place, count, first, last = -1, -1, -1, -1, -1
        while body - at >= 4:
            part = load_u32(data, at)
            at += 4
            if part < 1 or part > body - at:
                return found, pos
            key = data[at]
            if part == 4 and key == _O:  # op=
                op = int(data[at + 3])
            elif part == 18 and key == _C:  # chunk_pos=
                place = load_u32(data, at + 10) | (min(load_u32(data, at + 14), 0x7FFFFFFF) << 32)
            elif part == 19 and key == _S:  # start_time=
                first = load_u32(data, at + 11) * 1_000_000_000 + load_u32(data, at + 15)
            elif part == 17 and key == _E:  # end_time=
                last = load_u32(data, at + 9) * 1_000_000_000 + load_u32(data, at + 13)
            elif part == 10 and key == _C:  # count=
                count = load_u32(data, at + 6)
            at += part
        payload = load_u32(data, body)
        if (
            op != OP_CHUNK_INFO
            or at != body
            or place < 0
            or payload != count * 8
            or payload > total - body - 4
        ):
            break
        infos[found, 0], infos[found, 1], infos[found, 2] = place, first, last
        infos[found, 3], infos[found, 4] = body + 4, count
        found += 1
        pos = body + 4 + payload
    return found, pos


@lean_kernel
def place_of(ids: IntArray, connection: int) -> int:
    """Where a connection is in sorted ids, -1 where it is not."""
    low, high = 0, ids.shape[0]
    while low < high:
        middle = (low + high) >> 1
        if ids[middle] < connection:
            low = middle + 1
        else:
            high = middle
    return low if low < ids.shape[0] and ids[low] == connection else -1


@lean_kernel
def list_records(
    data: ByteArray,
    pos: int,
    total: int,
    ids: IntArray,
    topics: IntArray,
    place: IntArray,
    offset: IntArray,
    length: IntArray,
    receive: IntArray,
    tally: IntArray,
) -> int:
    """Give the wanted messages among the records data[pos:total] rows; the place where it stopped.

    See `decode_records`.
    """
    tally[NEXT], tally[NEXT_NS], tally[NEEDED], tally[FULL] = CUT, -1, 0, 0
    seen, latest = tally[SEEN], tally[LAST_NS]
    while total - pos >= 8:
        size = load_u32(data, pos)
        if size > total - pos - 8:
            break
        body = pos + 4 + size
        op, connection, stamp = record_header(data, pos + 4, body)
        if op < 0:
            tally[NEXT] = BROKEN
            break
        payload, start = load_u32(data, body), body + 4
        which = place_of(ids, connection) if op == OP_MESSAGE else -1
        if payload > total - start:
            tally[NEXT], tally[NEEDED] = start + payload, int(which >= 0)
            tally[NEXT_NS] = stamp if op == OP_MESSAGE else -1
            break
        if which >= 0:
            topic = topics[which]
            row = place[topic, FILL]
            if row >= place[topic, ROOM]:
                tally[FULL] = 1
                break
            place[topic, FILL] = row + 1
            row += place[topic, STAMP_ROW]
            offset[row], length[row], receive[row] = start, payload, stamp
        if op == OP_MESSAGE:
            seen, latest = seen + 1, stamp
        pos = start + payload
    tally[SEEN], tally[LAST_NS] = seen, latest
    return pos


@kernel
def decode_records(
    data: ByteArray,
    pos: int,
    total: int,
    ids: IntArray,
    topics: IntArray,
    program: Program,
    shapes: Shapes,
    rows: Rows,
    offset: IntArray,
    length: IntArray,
    receive: IntArray,
    tally: IntArray,
) -> int:
    """Walk the records data[pos:total] and decode the messages of connections `ids`; the place where it stopped.

    ids: sorted; topics: (ids,) which of the program's topics each is of. offset, length, receive: for each row of
    all topics, as `rows.stamp`; receive times in ns. tally: (TALLY,), see there. It stops before the first record
    that does not fit into data[:total], or for which there is no row.
    """
    place = rows.place
    begin = place[:, FILL].copy()
    pos = list_records(data, pos, total, ids, topics, place, offset, length, receive, tally)
    for topic in range(place.shape[0]):
        if place[topic, FILL] > begin[topic]:
            bad = decode_rows(
                data, offset, length, topic, begin[topic], place[topic, FILL], program, shapes, rows
            )
            tally[BAD] += bad
    return pos
