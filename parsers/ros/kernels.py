"""The compiled interpreter of message layouts (see `parsers.ros.layout`): payloads in, columns out.

Every read is checked against the end of its payload: the bytes come from an untrusted file.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel

# The rows and columns of a program; numba takes them in as constants. Their meaning: parsers.ros.layout.
PRIMITIVE, SEQUENCE, STRING, WSTRING, TIME, LOOP, END, SKIP = range(8)
OP, CODE, SIZE, COUNT, LIMIT, SLOT, JUMP = range(7)

_U64 = np.uint64


@kernel
def read_unsigned(data: ByteArray, pos: int, size: int, big: bool) -> np.uint64:
    """`size` bytes at `pos` as an unsigned integer; the caller has checked that they are there."""
    value = np.uint64(0)
    for k in range(size):
        at = pos + k if big else pos + size - 1 - k
        value = (value << np.uint64(8)) | np.uint64(data[at])
    return value


@kernel
def read_number(
    data: ByteArray, pos: int, code: int, big: bool, bits64: NDArray[np.uint64], bits32: NDArray[np.uint32]
) -> float:
    """A primitive as float64. bits64, bits32: one element each, for looking at bits as a float."""
    if code == 9:
        bits64[0] = read_unsigned(data, pos, 8, big)
        return float(bits64.view(np.float64)[0])
    if code == 8:
        bits32[0] = np.uint32(read_unsigned(data, pos, 4, big))
        return float(bits32.view(np.float32)[0])
    if code == 0:
        return float(data[pos])
    if code == 1:
        return float(np.int8(data[pos]))
    if code == 2:
        return float(read_unsigned(data, pos, 2, big))
    if code == 3:
        return float(np.int16(read_unsigned(data, pos, 2, big)))
    if code == 4:
        return float(read_unsigned(data, pos, 4, big))
    if code == 5:
        return float(np.int32(read_unsigned(data, pos, 4, big)))
    if code == 6:
        return float(read_unsigned(data, pos, 8, big))
    if code == 7:
        return float(np.int64(read_unsigned(data, pos, 8, big)))
    return np.nan


@kernel
def aligned(pos: int, base: int, size: int) -> int:
    """The next place at or after `pos` that is a multiple of `size` (at most 8) from `base`."""
    step = min(size, 8)
    return pos + (-(pos - base)) % step if step > 1 else pos


@kernel
def next_element(
    pos: int, end: int, pc: int, top: int, context: int, ops: IntArray, stack: IntArray
) -> tuple[int, int, int, int]:
    """At an END: (pos, pc, top, context) of the loop's next element, or of what follows it. pos -1: past the end."""
    begin = stack[top, 0]
    index, count, limit, exact = stack[top, 1], stack[top, 2], ops[begin, LIMIT], ops[begin, CODE]
    if index >= limit and exact > 0:
        # the rest of this array has no slots, and its size is known: step over it
        pos += (count - index) * exact
        index = count
        if pos > end:
            return -1, pc, top, context
    if index >= count:
        return pos, pc + 1, top - 1, stack[top, 3]
    above = stack[top, 3]
    stack[top, 1] = index + 1
    return pos, begin + 1, top, (above * limit + index if above >= 0 and index < limit else -1)


@kernel
def take_time(
    data: ByteArray,
    pos: int,
    row: int,
    cdr: bool,
    big: bool,
    is_signed: bool,
    is_stamp: bool,
    column: int,
    out: FloatArray,
    stamp_ns: IntArray,
) -> None:
    """Two 32-bit numbers, seconds and nanoseconds, into a column and the stamps (-1 and False: not wanted)."""
    first = np.int64(read_unsigned(data, pos, 4, big))
    second = np.int64(read_unsigned(data, pos + 4, 4, big))
    if is_signed:
        first = np.int64(np.int32(first))
        if not cdr:  # a ROS 1 duration has a sign in both of its parts
            second = np.int64(np.int32(second))
    if is_stamp:
        stamp_ns[row] = first * 1_000_000_000 + second
    if column >= 0:
        out[column, row] = first + second * 1e-9


@kernel
def decode_one(
    data: ByteArray,
    pos: int,
    end: int,
    row: int,
    cdr: bool,
    big: bool,
    wide: int,
    ops: IntArray,
    table: IntArray,
    out: FloatArray,
    stamp_ns: IntArray,
    stack: IntArray,
    bits64: NDArray[np.uint64],
    bits32: NDArray[np.uint32],
) -> int:
    """Run the program over one payload data[pos:end]; the place where it ended, or -1 where it does not fit.

    stack: (depth, 4) of place in the program, next index, elements, context of the loop around. The context is the
    index of the current element among those with slots, -1 outside them.
    """
    base = pos
    pc, top, context = 0, -1, 0
    while pc < ops.shape[0]:
        op, code, size, slot = ops[pc, OP], ops[pc, CODE], ops[pc, SIZE], ops[pc, SLOT]
        if op == END:
            pos, pc, top, context = next_element(pos, end, pc, top, context, ops, stack)
            if pos < 0:
                return -1
            continue
        count = ops[pc, COUNT]
        if cdr and op in (SEQUENCE, STRING, WSTRING, TIME, LOOP) and (op != LOOP or count < 0):
            pos = aligned(pos, base, 4)
        if op == TIME:
            if end - pos < 8:
                return -1
            column = table[slot + context] if slot >= 0 and context >= 0 else -1
            take_time(data, pos, row, cdr, big, code == 1, count == 1, column, out, stamp_ns)
            pos += 8
        elif op == SKIP:
            if end - pos < size:
                return -1
            pos += size
        else:
            if op in (SEQUENCE, STRING, WSTRING) or count < 0:
                if end - pos < 4:
                    return -1
                count = np.int64(read_unsigned(data, pos, 4, big))
                pos += 4
            if op == WSTRING:
                size = wide
            elif op == STRING:
                size = 1
            elif cdr and op != LOOP and size > 0 and count > 0:
                pos = aligned(pos, base, size)
            if size > 0 and count > (end - pos) // size:
                return -1
            if op == LOOP:
                if count == 0:
                    pc = ops[pc, JUMP]
                else:
                    top += 1
                    stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = pc, 0, count, context
                    pc = ops[pc, JUMP] - 1
            else:
                if slot >= 0 and context >= 0:
                    limit = ops[pc, LIMIT]
                    for k in range(min(count, limit)):
                        column = table[slot + context * limit + k]
                        if column >= 0:
                            out[column, row] = read_number(data, pos + k * size, code, big, bits64, bits32)
                pos += count * size
        pc += 1
    return pos


@kernel
def decode_all(
    data: ByteArray,
    offset: IntArray,
    length: IntArray,
    cdr: bool,
    wide: int,
    depth: int,
    ops: IntArray,
    table: IntArray,
    out: FloatArray,
    stamp_ns: IntArray,
    whole: NDArray[np.bool_],
) -> None:
    """Decode all payloads into out (columns, n), stamp_ns (n,) and whole (n,): False where one does not fit.

    CDR payloads begin with four bytes of encapsulation; only plain CDR is taken (00 00 big, 00 01 little endian).
    A payload that goes on after its message (three bytes of padding aside) is not of this type either.
    """
    stack = np.zeros((depth + 1, 4), np.int64)
    bits64 = np.zeros(1, np.uint64)
    bits32 = np.zeros(1, np.uint32)
    for row in range(offset.shape[0]):
        pos, size = offset[row], length[row]
        if pos < 0 or size < 0 or size > data.shape[0] or pos > data.shape[0] - size:
            continue
        end = pos + size
        big = False
        if cdr:
            if size < 4 or data[pos] != 0 or data[pos + 1] > 1:
                continue
            big = data[pos + 1] == 0
            pos += 4
        stop = decode_one(
            data, pos, end, row, cdr, big, wide, ops, table, out, stamp_ns, stack, bits64, bits32
        )
        rest = end - stop
        whole[row] = stop >= 0 and rest >= 0 and (rest <= 3 if cdr else rest == 0)
