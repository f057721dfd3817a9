"""Payloads to columns: where a message has a shape that was met before, its numbers are taken from where they were.

The size of the payload and every count in it (of texts and sequences) decide where everything is. So a message that
agrees in these with an earlier one is copied without interpreting it; others go through `kernels.learn` first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel, lean_kernel, load_u16, load_u32, load_u64
from parsers.ros.kernels import (
    BIG,
    CELL,
    COLUMNS,
    COUNTS,
    ENCAPSULATION,
    HOW,
    MARKS,
    PLACE,
    ROOM,
    SHELF,
    SIGNED_TIME,
    SIZE_OF,
    STAMP,
    STAMP_CODE,
    STAMP_ROW,
    TURN,
    UNSIGNED_TIME,
    WAYS,
    Program,
    Rows,
    Shapes,
    learn,
    swapped,
)

FLOAT32, FLOAT64, NO_NUMBER = 8, 9, 10
_SIGN32 = 1 << 31
# a kernel's whole numbers are of one of two kinds; for the rest of Python both are int
_U64 = cast("Callable[[int], int]", np.uint64)
_I64 = cast("Callable[[int], int]", np.int64)


@lean_kernel
def swapped64(value: int) -> int:
    """The other byte order of 64 bits, uint64."""
    low, high = _I64(value & _U64(0xFFFFFFFF)), _I64(value >> _U64(32))
    return (_U64(swapped(low)) << _U64(32)) | _U64(swapped(high))


@lean_kernel
def signed32(value: int) -> int:
    """32 bits as a number with a sign."""
    return (value ^ _SIGN32) - _SIGN32


@lean_kernel
def widened(value: int) -> int:
    """The bits of a float32 as those of the float64 of the same value, as uint64."""
    sign, exponent, fraction = value >> 31, (value >> 23) & 0xFF, value & 0x7FFFFF
    if exponent == 0xFF:
        exponent = 0x7FF
    elif exponent > 0:
        exponent += 1023 - 127
    elif fraction > 0:  # too small for float32's usual form, not for float64's
        exponent = 1023 - 126
        while fraction < 0x800000:
            fraction <<= 1
            exponent -= 1
        fraction &= 0x7FFFFF
    return (_U64(sign) << _U64(63)) | _U64((exponent << 52) | (fraction << 29))


@lean_kernel
def take_bits(data: ByteArray, at: int, code: int) -> int:
    """A number's bytes as uint64, in the machine's order. Only the number's own bytes are touched."""
    big = code >= BIG
    code &= BIG - 1
    if code <= 1 or code == NO_NUMBER:
        return _U64(data[at])
    if code <= 3:
        half = load_u16(data, at)
        return _U64(((half & 0xFF) << 8) | (half >> 8) if big else half)
    if code <= 5 or code == FLOAT32:
        word = load_u32(data, at)
        return _U64(swapped(word) if big else word)
    value = load_u64(data, at)
    return swapped64(value) if big else value


@lean_kernel
def split_time(value: int, code: int) -> tuple[int, int]:
    """Seconds and nanoseconds of a time's eight bytes as they are in the payload (uint64)."""
    first, second = _I64(value & _U64(0xFFFFFFFF)), _I64(value >> _U64(32))
    if code >= BIG:
        first, second = swapped(first), swapped(second)
        code -= BIG
    if code != UNSIGNED_TIME:
        first = signed32(first)
    if code == SIGNED_TIME:
        second = signed32(second)
    return first, second


@lean_kernel
def number(value: int, code: int) -> float:
    """A whole number's bits, in the machine's order, as float64."""
    code &= BIG - 1
    if code == 1:
        return float((_I64(value) ^ 0x80) - 0x80)
    if code == 3:
        return float((_I64(value) ^ 0x8000) - 0x8000)
    if code == 5:
        return float(signed32(_I64(value)))
    if code == 7:
        return float(_I64(value))
    return float(value) if code != NO_NUMBER else np.nan


@lean_kernel
def fits(data: ByteArray, start: int, size: int, row: int, cdr: bool, heads: IntArray) -> bool:
    """Whether a payload has the shape remembered in `row`."""
    if heads[row, SIZE_OF] != size:
        return False
    # a remembered CDR payload has its four bytes of encapsulation
    same = not cdr or load_u16(data, start) == heads[row, ENCAPSULATION] << 8
    at, last = MARKS, MARKS + 2 * heads[row, COUNTS]
    while same and at < last:
        same = load_u32(data, start + heads[row, at]) == heads[row, at + 1]
        at += 2
    return same


@lean_kernel
def recall(data: ByteArray, start: int, size: int, row: int, cdr: bool, heads: IntArray) -> int:
    """Which of the shapes remembered from `row` on the payload has, -1 for none of them."""
    for way in range(WAYS):
        if fits(data, start, size, row + way, cdr, heads):
            return way
    return -1


@lean_kernel
def blank(cell: int, step: int, wanted: int, cells: FloatArray) -> None:
    """No numbers for a message."""
    for _ in range(wanted):
        cells[cell] = np.nan
        cell += step


@lean_kernel
def copy_numbers(
    data: ByteArray,
    start: int,
    cell: int,
    step: int,
    shelf: int,
    wanted: int,
    places: IntArray,
    cells: FloatArray,
    bits: NDArray[np.uint64],
) -> None:
    """Copy the wanted numbers of a payload of known shape to cells[cell], cells[cell + step], …"""
    for column in range(shelf, shelf + wanted):
        at, code = start + places[column, PLACE], places[column, HOW]
        if at < start:
            cells[cell] = np.nan
        elif code == FLOAT64:
            bits[cell] = load_u64(data, at)
        elif code & (BIG - 1) >= UNSIGNED_TIME:
            first, second = split_time(load_u64(data, at), code)
            cells[cell] = first + second * 1e-9
        else:
            value = take_bits(data, at, code)
            kind = code & (BIG - 1)
            if kind == FLOAT64:
                bits[cell] = value
            elif kind == FLOAT32:
                bits[cell] = widened(_I64(value))
            else:
                cells[cell] = number(value, code)
        cell += step


@kernel
def decode_rows(
    data: ByteArray,
    offset: IntArray,
    length: IntArray,
    topic: int,
    begin: int,
    end: int,
    program: Program,
    shapes: Shapes,
    rows: Rows,
) -> int:
    """Decode the payloads of a topic's rows [begin, end); how many of them do not fit their type.

    offset, length: where the payloads are in `data`, one for each row of all topics, as `rows.stamp`. Rows that do
    not fit are NaN, their stamp 0.
    """
    spec, ops, table, cdr, wide = program
    heads, places, stack = shapes
    cells, bits, stamp, place = rows
    wanted, total, base = spec[topic, COLUMNS], data.shape[0], topic * WAYS
    first, room = place[topic, STAMP_ROW], place[topic, ROOM]
    way, bad = heads[base, TURN], 0
    for i in range(first + begin, first + end):
        start, size, cell = offset[i], length[i], place[topic, CELL] + i - first
        stamp[i] = 0
        if start < 0 or size < 0 or size > total or start > total - size:
            blank(cell, room, wanted, cells)
            bad += 1
            continue
        if not fits(data, start, size, base + way, cdr, heads):
            last, way = way, recall(data, start, size, base, cdr, heads)
            if way < 0:
                way = (last + 1) % WAYS
                if not learn(
                    data, start, size, topic, way, cdr, wide, spec, ops, table, heads, places, stack
                ):
                    blank(cell, room, wanted, cells)
                    bad += 1
                    continue
        shelf = spec[topic, SHELF] * WAYS + way * wanted
        copy_numbers(data, start, cell, room, shelf, wanted, places, cells, bits)
        at = heads[base + way, STAMP]
        if at >= 0:
            seconds, rest = split_time(load_u64(data, start + at), heads[base + way, STAMP_CODE])
            stamp[i] = seconds * 1_000_000_000 + rest
    heads[base, TURN] = way
    return bad
