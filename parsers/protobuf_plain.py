"""Kernels for the everyday protobuf message: plain numbers, in the order of their field numbers.

Two steps: messages of numbers of a fixed size have the same layout again and again, so that all tags are compared at
once; where they have not, the next field is compared with the one that is expected.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import lean_kernel, load_u32, load_u64
from parsers.protobuf_tables import (
    ACTION,
    CELL,
    KIND,
    STEP_OVER,
    TAG_SIZE,
    TAKE,
    TAKE_DOUBLE,
    WIRE,
    Output,
    Tables,
)
from parsers.protobuf_wire import FIXED32, FIXED64, FLOAT, number, raw, signed, skip

_AHEAD = 16
"""So many absent fields are stepped over before the next one is looked up."""
MAX_LAYOUT = 256
# columns of a layout: place of the tag and of the value in the message, column (-1: not wanted), and whether a float
_TAG_AT, _VALUE_AT, _CELL, _IS_FLOAT = range(4)


class Layout(NamedTuple):
    """Where the fields of a message are: places (a row a field), and their tags with the bytes that these cover."""

    places: IntArray
    tags: NDArray[np.uint64]
    masks: NDArray[np.uint64]


@lean_kernel
def plain(
    data: ByteArray,
    at: int,
    end: int,
    e: int,
    node: int,
    i: int,
    t: Tables,
    out: Output,
    word: NDArray[np.uint64],
    half: NDArray[np.uint32],
) -> tuple[int, int]:
    """Read fields for as long as they are the expected ones and plain; the place and the entry to go on with."""
    stop = t.nodes[node, 1]
    room = data.size - 8
    while at < end and at <= room:
        head = load_u64(data, at)
        first, last = e, min(stop, e + _AHEAD)
        while e < last and head & t.masks[e] != t.tags[e]:
            e += 1
        if e >= last:
            return at, first
        action, begin = t.entries[e, ACTION], at + t.entries[e, TAG_SIZE]
        if action == TAKE_DOUBLE:
            if begin + 8 > end:
                return at, e
            out.bits[t.entries[e, CELL], i] = load_u64(data, begin)
            begin += 8
        elif action == TAKE:
            value, begin = raw(data, begin, end, t.entries[e, WIRE])
            if begin < 0:
                return at, e
            out.columns[t.entries[e, CELL], i] = number(t.entries[e, KIND], value, word, half)
        elif action == STEP_OVER and begin <= end:
            begin = skip(data, begin, end, signed(head & np.uint64(7)))
            if begin < 0:
                return at, e
        else:
            return at, e
        at = begin
        e += 1
    return at, e


@lean_kernel
def learn(data: ByteArray, start: int, end: int, t: Tables, layout: Layout) -> int:
    """The layout of the message data[start:end]: how many fields it has, 0 where not all are plain and of fixed size."""
    at, e, count, stop = start, 0, 0, t.nodes[0, 1]
    while at < end and end + 8 <= data.size:
        head = load_u64(data, at)
        while e < stop and head & t.masks[e] != t.tags[e]:
            e += 1
        if e == stop or count == layout.tags.size:
            return 0
        action, wire = t.entries[e, ACTION], t.entries[e, WIRE]
        is_float = t.entries[e, KIND] == FLOAT
        fixed = wire in (FIXED32, FIXED64) and wire == signed(head & np.uint64(7))
        if not (action == TAKE_DOUBLE or (action == TAKE and is_float) or (action == STEP_OVER and fixed)):
            return 0
        layout.places[count, _TAG_AT] = at - start
        at += t.entries[e, TAG_SIZE]
        layout.places[count, _VALUE_AT] = at - start
        layout.places[count, _CELL] = t.entries[e, CELL] if action != STEP_OVER else -1
        layout.places[count, _IS_FLOAT] = is_float
        layout.tags[count], layout.masks[count] = t.tags[e], t.masks[e]
        at += 8 if wire == FIXED64 else 4
        e += 1
        count += 1
    return count if at == end else 0


@lean_kernel
def read_alike(
    data: ByteArray,
    offset: IntArray,
    length: IntArray,
    i: int,
    size: int,
    fields: int,
    layout: Layout,
    template: FloatArray,
    out: Output,
    half: NDArray[np.uint32],
) -> int:
    """Read messages from the i-th on for as long as they have this layout and size; returns the first that has not."""
    floats = half.view(np.float32)
    places = layout.places
    taken = 0
    for k in range(fields):
        taken += places[k, _CELL] >= 0
    while i < offset.size:
        start = offset[i]
        if length[i] != size or start < 0 or start > data.size - 8 - size:
            return i
        other = np.uint64(0)
        for k in range(fields):
            other |= (load_u64(data, start + places[k, _TAG_AT]) & layout.masks[k]) ^ layout.tags[k]
        if other != np.uint64(0):
            return i
        if taken < template.size:
            for c in range(template.size):
                out.columns[c, i] = template[c]
        for k in range(fields):
            cell, at = places[k, _CELL], start + places[k, _VALUE_AT]
            if cell >= 0 and places[k, _IS_FLOAT]:
                half[0] = load_u32(data, at)
                out.columns[cell, i] = floats[0]
            elif cell >= 0:
                out.bits[cell, i] = load_u64(data, at)
        i += 1
    return i
