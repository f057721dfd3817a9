"""The compiled interpreter of message layouts (see `parsers.ros.layout`): where in a payload the wanted numbers are.

Every read is checked against the end of its payload: the bytes come from an untrusted file. What is found is kept as
a shape (see `Shapes`), since most messages of a topic have the very same one; `parsers.ros.replay` uses it again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import lean_kernel, load_u32

# The rows and columns of a program; numba takes them in as constants. Their meaning: parsers.ros.layout.
PRIMITIVE, SEQUENCE, STRING, WSTRING, TIME, LOOP, END, SKIP = range(8)
OP, CODE, SIZE, COUNT, LIMIT, SLOT, JUMP = range(7)

FIRST, LAST, COLUMNS, SHELF = range(4)
"""Columns of a specification: the program's first operation, the one after its last, how many numbers are wanted,
and the first of their places among those of all topics."""

UNSIGNED_TIME, SIGNED_SECONDS, SIGNED_TIME = 11, 12, 13
"""Codes of times, beyond those of primitives: no part has a sign, the seconds have, both parts have."""
BIG = 32
"""Added to a code: the number is big-endian."""

CDR2_BIG, CDR2_LITTLE = 6, 7
"""Encapsulations of plain CDR of the second version, beside 0 and 1 of the first."""
CDR_ALIGNMENT, CDR2_ALIGNMENT = 8, 4

WAYS = 4
"""How many shapes of one topic's messages are remembered."""
MAX_COUNTS = 48
"""A shape with more counts than this is used once and not remembered."""
SIZE_OF, COUNTS, STAMP, STAMP_CODE, ENCAPSULATION, TURN = range(6)
MARKS = 6
HEAD = MARKS + 2 * MAX_COUNTS
PLACE, HOW = 0, 1

CELL, ROOM, STAMP_ROW, FILL = range(4)
"""Columns of `Rows.place`."""


class Program(NamedTuple):
    """The programs of some topics, one after the other. spec: (topics, 4); ops, table: see `layout.specialise`.

    cdr: CDR payloads begin with four bytes of encapsulation; only plain CDR is taken (00 00 big, 00 01 little endian; 00 06
    and 00 07 in its second version).
    wide: bytes of a wide character.
    """

    spec: IntArray
    ops: IntArray
    table: IntArray
    cdr: bool
    wide: int


class Shapes(NamedTuple):
    """Shapes of messages: what was met, WAYS of each topic, in rows topic * WAYS + way.

    heads: (rows, HEAD) size of the payload (-1: none is remembered), how many counts there are, place and code of the
    stamp (place -1: none), the encapsulation, which way fitted last (in the topic's first row); from MARKS on place
    and raw value of each count: they decide where everything is. places: (WAYS * all wanted numbers, 2) place and code
    of each number, place -1: the message has no such element. stack: (depth, 4), the open loops: place in the program,
    next index, elements, context of the loop around. The context is the index of the current element among those with
    slots, -1 outside them.
    """

    heads: IntArray
    places: IntArray
    stack: IntArray


class Rows(NamedTuple):
    """Where decoded messages go: room for some rows of each topic.

    cells: flat float64, `bits` the same memory as uint64. stamp: int64 ns. place: (topics, 4) a topic's first cell;
    its columns follow each other, with room for so many rows; its first row in `stamp`; how many rows are filled.
    """

    cells: FloatArray
    bits: NDArray[np.uint64]
    stamp: IntArray
    place: IntArray


# Kernels that are called for every message take arrays, not these tuples: numba counts references for each array that
# it takes out of a tuple, and that costs more than decoding a message.


@lean_kernel
def swapped(value: int) -> int:
    """The other byte order of 32 bits."""
    return (value >> 24) | ((value >> 8) & 0xFF00) | ((value << 8) & 0xFF0000) | ((value & 0xFF) << 24)


@lean_kernel
def aligned(pos: int, base: int, size: int, most: int) -> int:
    """The next place at or after `pos` that is a multiple of `size` (at most `most`, a power of two) from `base`."""
    step = min(size, most)
    return pos + (-(pos - base) & (step - 1)) if step > 1 else pos


@lean_kernel
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


@lean_kernel
def take_count(data: ByteArray, start: int, pos: int, big: bool, row: int, heads: IntArray) -> int:
    """The count at `pos`, which the caller has checked to be there; it becomes a mark of the shape."""
    raw = load_u32(data, pos)
    known = heads[row, COUNTS]
    if known < MAX_COUNTS:
        heads[row, MARKS + 2 * known] = pos - start
        heads[row, MARKS + 2 * known + 1] = raw
    heads[row, COUNTS] = known + 1
    return swapped(raw) if big else raw


@lean_kernel
def note_places(
    place: int, count: int, size: int, code: int, first: int, shelf: int, table: IntArray, places: IntArray
) -> None:
    """Write down where the wanted ones among `count` numbers are. first: the slot of the first of them."""
    for k in range(count):
        column = table[first + k]
        if column >= 0:
            places[shelf + column, PLACE] = place + k * size
            places[shelf + column, HOW] = code


@lean_kernel
def note_time(
    place: int, is_signed: bool, is_stamp: bool, big: bool, cdr: bool, row: int, heads: IntArray
) -> int:
    """The code of a time (two 32-bit numbers, seconds and nanoseconds); the message's stamp is written down."""
    code = UNSIGNED_TIME
    if is_signed:  # a ROS 1 duration has a sign in both of its parts
        code = SIGNED_SECONDS if cdr else SIGNED_TIME
    if big:
        code += BIG
    if is_stamp:
        heads[row, STAMP] = place
        heads[row, STAMP_CODE] = code
    return code


@lean_kernel
def run_program(
    data: ByteArray,
    start: int,
    end: int,
    cdr: bool,
    big: bool,
    most: int,
    wide: int,
    pc: int,
    last: int,
    row: int,
    shelf: int,
    ops: IntArray,
    table: IntArray,
    heads: IntArray,
    places: IntArray,
    stack: IntArray,
) -> int:
    """Run the program ops[pc:last] over data[start:end]; the place where it ended, or -1 where it does not fit.

    most: the widest alignment, 8 bytes in CDR, 4 in its second version, which also writes the size of a list's bytes
    before a list of anything but numbers.
    """
    base = start + 4 if cdr else start
    pos, top, context = base, -1, 0
    while pc < last and pos >= 0:
        op, size, count, slot = ops[pc, OP], ops[pc, SIZE], ops[pc, COUNT], ops[pc, SLOT]
        if op == END:
            pos, pc, top, context = next_element(pos, end, pc, top, context, ops, stack)
            continue
        counted = op in (SEQUENCE, STRING, WSTRING) or (op == LOOP and count < 0)
        if cdr and (counted or op == TIME):
            pos = aligned(pos, base, 4, most)
        if cdr and op == LOOP and most == CDR2_ALIGNMENT:
            pos = aligned(pos, base, 4, most) + 4
        code, limit = ops[pc, CODE] + (BIG if big else 0), ops[pc, LIMIT]
        if op == TIME:
            code = note_time(pos - start, ops[pc, CODE] == 1, count == 1, big, cdr, row, heads)
            count, size, limit = 1, 8, 1
        elif counted:
            if end - pos < 4:
                return -1
            count = take_count(data, start, pos, big, row, heads)
            pos += 4
        if op == WSTRING:
            size = wide
        elif cdr and op in (PRIMITIVE, SEQUENCE) and count > 0:
            pos = aligned(pos, base, size, most)
        # no product of a count and a size comes near 2**63
        if size > 0 and count * size > end - pos:
            return -1
        if op != LOOP:
            if slot >= 0 and context >= 0:
                first = slot + context * limit
                note_places(pos - start, min(count, limit), size, code, first, shelf, table, places)
            pos += count * size
        elif count == 0:
            pc = ops[pc, JUMP]
        else:
            top += 1
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = pc, 0, count, context
            pc = ops[pc, JUMP] - 1
        pc += 1
    return pos


@lean_kernel
def learn(
    data: ByteArray,
    start: int,
    size: int,
    topic: int,
    way: int,
    cdr: bool,
    wide: int,
    spec: IntArray,
    ops: IntArray,
    table: IntArray,
    heads: IntArray,
    places: IntArray,
    stack: IntArray,
) -> bool:
    """Make the payload's shape the topic's `way`-th; False where the payload does not fit its type.

    A payload that goes on after its message (three bytes of padding aside in CDR) is not of this type either.
    """
    row, wanted = topic * WAYS + way, spec[topic, COLUMNS]
    shelf = spec[topic, SHELF] * WAYS + way * wanted
    heads[row, SIZE_OF], heads[row, COUNTS], heads[row, STAMP] = -1, 0, -1
    for column in range(wanted):
        places[shelf + column, PLACE] = -1
    big, most = False, CDR_ALIGNMENT
    if cdr:
        if size < 4 or data[start] != 0:
            return False
        kind = int(data[start + 1])
        if kind > 1 and kind != CDR2_BIG and kind != CDR2_LITTLE:
            return False
        big = kind & 1 == 0
        most = CDR2_ALIGNMENT if kind > 1 else CDR_ALIGNMENT
        heads[row, ENCAPSULATION] = kind
    end, pc, last = start + size, spec[topic, FIRST], spec[topic, LAST]
    stop = run_program(
        data, start, end, cdr, big, most, wide, pc, last, row, shelf, ops, table, heads, places, stack
    )
    rest = end - stop
    if stop < 0 or rest < 0 or rest > (3 if cdr else 0):
        return False
    if heads[row, COUNTS] <= MAX_COUNTS:
        heads[row, SIZE_OF] = size
    return True
