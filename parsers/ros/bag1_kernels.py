"""The compiled walk over the records inside an uncompressed chunk of a ROS 1 bag."""

from __future__ import annotations

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel

OP_MESSAGE, OP_CONNECTION = 2, 7
_EQUALS, _C, _O, _T = 61, 99, 111, 116


@kernel
def read_u32(data: ByteArray, pos: int) -> int:
    """Little-endian 32 bits; the caller has checked that they are there."""
    value = 0
    for k in range(4):
        value |= int(data[pos + k]) << (8 * k)
    return value


@kernel
def walk_records(
    data: ByteArray, conn: IntArray, time_ns: IntArray, offset: IntArray, length: IntArray
) -> tuple[int, int]:
    """Walk the records of a chunk; (how many were found, where the walk stopped).

    The walk stops before the first record that does not fit; at data's end where all do. Found are messages (their
    connection, receive time and payload) and connections (conn -1, the whole record). Outputs of no length: count only.
    """
    total = data.shape[0]
    room = conn.shape[0]
    pos, found = 0, 0
    while total - pos >= 8:
        size = read_u32(data, pos)
        at = pos + 4
        if size > total - at - 4:
            break
        stop = at + size
        op, connection, stamp = -1, -1, -1
        good = True
        while at < stop:
            if stop - at < 4:
                good = False
                break
            part = read_u32(data, at)
            at += 4
            if part < 1 or part > stop - at:
                good = False
                break
            # "op=" and a byte, "conn=" and 4 bytes, "time=" and 8 bytes; no other field of a message is needed
            if part == 4 and data[at] == _O and data[at + 2] == _EQUALS:
                op = int(data[at + 3])
            elif part == 9 and data[at] == _C and data[at + 4] == _EQUALS:
                connection = read_u32(data, at + 5)
            elif part == 13 and data[at] == _T and data[at + 4] == _EQUALS:
                stamp = read_u32(data, at + 5) * 1_000_000_000 + read_u32(data, at + 9)
            at += part
        if not good:
            break
        payload = read_u32(data, stop)
        start = stop + 4
        if payload > total - start:
            break
        if op == OP_MESSAGE:
            if connection < 0 or stamp < 0:
                break
            if found < room:
                conn[found], time_ns[found] = connection, stamp
                offset[found], length[found] = start, payload
            found += 1
        elif op == OP_CONNECTION:
            if found < room:
                conn[found], time_ns[found] = -1, 0
                offset[found], length[found] = pos, start + payload - pos
            found += 1
        elif op < 0:
            break
        pos = start + payload
    return found, pos
