"""The kernel that reads protobuf payloads: a table says what to do with each field number.

Messages of one type hold nearly the same fields in the same order, so the next field is first compared with the one
that is expected; only where that fails is it looked up. A payload that breaks the encoding gives a row of NaN and is
counted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel
from parsers.protobuf_plain import MAX_LAYOUT, Layout, learn, plain, read_alike
from parsers.protobuf_tables import (
    ACTION,
    COLUMN_END,
    COLUMN_FIRST,
    ELEMENTS,
    FIRST_ELEMENT,
    KIND,
    LIST,
    LIST_END,
    LIST_FIRST,
    NODE_END,
    NODE_FIRST,
    NUMBER,
    ONEOF,
    STEP_OVER,
    WIRE,
    Output,
    Tables,
)
from parsers.protobuf_wire import (
    BYTES,
    MESSAGE,
    number,
    raw,
    signed,
    skip,
    varint,
    whole,
)

STACK = 24
_PATIENCE, _PAUSE = 8, 64
"""After so many messages of other layouts one after the other, so many are read without looking at their layout."""


class Scratch(NamedTuple):
    """What belongs to one message while it is read: nodes seen, elements counted, open messages; and one element each
    to look at bits as floats."""

    seen: ByteArray
    counts: IntArray
    stack: IntArray
    word: NDArray[np.uint64]
    half: NDArray[np.uint32]


@lean_kernel
def _find(entries: IntArray, first: int, end: int, field: int, hint: int) -> int:
    """The entry of a field number among entries[first:end] (sorted), -1 where there is none."""
    if first <= hint < end and entries[hint, NUMBER] == field:
        return hint
    low, high = first, end
    while low < high:
        middle = (low + high) // 2
        if entries[middle, NUMBER] < field:
            low = middle + 1
        else:
            high = middle
    if low < end and entries[low, NUMBER] == field:
        return low
    return -1


@lean_kernel
def _clear_oneof(e: int, i: int, t: Tables, out: Output, s: Scratch) -> None:
    """A member of a oneof is set: all others are absent again."""
    one, entry = t.oneofs[t.entries[e, ONEOF]], t.entries[e]
    for c in range(one[0], one[1]):
        if c < entry[COLUMN_FIRST] or c >= entry[COLUMN_END]:
            out.columns[c, i] = np.nan
    for n in range(one[2], one[3]):
        if n < entry[NODE_FIRST] or n >= entry[NODE_END]:
            s.seen[n] = 0
    for k in range(one[4], one[5]):
        if k < entry[LIST_FIRST] or k >= entry[LIST_END]:
            s.counts[k] = 0


@lean_kernel
def _enter(node: int, i: int, t: Tables, out: Output, s: Scratch) -> None:
    """A message is there: its absent fields have their defaults, unless it was there already (then it is merged)."""
    if s.seen[node] == 0:
        s.seen[node] = 1
        for k in range(t.nodes[node, 2], t.nodes[node, 3]):
            out.columns[np.int64(t.defaults[k, 0]), i] = t.defaults[k, 1]


@lean_kernel
def _element(e: int, t: Tables, s: Scratch) -> int:
    """Which element a value is (its place in the element table), -1 where it is beyond those of interest."""
    k = 0
    which = t.entries[e, LIST]
    if which >= 0:
        k = s.counts[which]
        s.counts[which] += 1
    return t.entries[e, FIRST_ELEMENT] + k if k < t.entries[e, ELEMENTS] else -1


@lean_kernel
def _values(
    data: ByteArray, at: int, end: int, e: int, packed: bool, i: int, t: Tables, out: Output, s: Scratch
) -> int:
    """Take one number, or the packed ones that fill data[at:end]; the place behind, -1 where it is malformed."""
    kind, wire = t.entries[e, KIND], t.entries[e, WIRE]
    while at < end or not packed:
        bits, at = raw(data, at, end, wire)
        if at < 0:
            return -1
        place = _element(e, t, s)
        if place >= 0:
            cell, slot = t.elements[place, 0], t.elements[place, 1]
            if cell >= 0:
                out.columns[cell, i] = number(kind, bits, s.word, s.half)
            if slot >= 0:
                out.stamps[i, slot] = whole(kind, bits)
        if not packed:
            break
    return at


@lean_kernel
def _field(
    data: ByteArray, at: int, end: int, node: int, hint: int, i: int, t: Tables, out: Output, s: Scratch
) -> tuple[int, int, int, int]:
    """Read any one field: the place behind it (-1: malformed), the entry to expect next, and node and end of a message.

    Where the node is not -1 the field is a message of interest, and the place is where its content begins.
    """
    tag, at = varint(data, at, end)
    if at < 0 or tag < np.uint64(8) or tag > np.uint64(0xFFFFFFFF):
        return -1, hint, -1, -1
    wire, field = signed(tag & np.uint64(7)), signed(tag >> np.uint64(3))
    e = _find(t.entries, t.nodes[node, 0], t.nodes[node, 1], field, hint)
    if e < 0:
        return skip(data, at, end, wire), hint, -1, -1
    own = t.entries[e, WIRE]
    packed = wire == BYTES and t.entries[e, LIST] >= 0 and own != BYTES
    if t.entries[e, ACTION] == STEP_OVER or (wire != own and not packed):
        return skip(data, at, end, wire), e + 1, -1, -1
    if t.entries[e, ONEOF] >= 0:
        _clear_oneof(e, i, t, out, s)
    close = end
    if wire == BYTES:
        size, at = varint(data, at, end)
        if at < 0 or size > np.uint64(end - at):
            return -1, hint, -1, -1
        close = at + signed(size)
    if wire != BYTES or packed:
        return _values(data, at, close, e, packed, i, t, out, s), e + 1, -1, -1
    place = _element(e, t, s) if t.entries[e, KIND] == MESSAGE else -1
    if place < 0 or t.elements[place, 0] < 0:
        return close, e + 1, -1, -1
    return at, e + 1, t.elements[place, 0], close


@lean_kernel
def _payload(
    data: ByteArray, at: int, stop: int, i: int, t: Tables, out: Output, s: Scratch
) -> tuple[bool, bool]:
    """Read one payload data[at:stop] into row i: whether it is whole, and whether it has nothing but plain fields."""
    for c in range(t.template.size):
        out.columns[c, i] = t.template[c]
    for n in range(s.seen.size):
        s.seen[n] = n == 0
    for k in range(s.counts.size):
        s.counts[k] = 0
    node, end, depth, hint, is_plain = 0, stop, 0, 0, True
    while True:
        at, hint = plain(data, at, end, hint, node, i, t, out, s.word, s.half)
        if at == end:
            if depth == 0:
                return True, is_plain
            depth -= 1
            node, end, hint = s.stack[depth, 0], s.stack[depth, 1], s.stack[depth, 2]
            continue
        is_plain = False
        at, hint, inner, close = _field(data, at, end, node, hint, i, t, out, s)
        if at < 0:
            return False, False
        if inner >= 0 and depth == s.stack.shape[0]:
            at = close
        elif inner >= 0:
            s.stack[depth, 0], s.stack[depth, 1], s.stack[depth, 2] = node, end, hint
            depth += 1
            node, end, hint = inner, close, t.nodes[inner, 0]
            _enter(node, i, t, out, s)


@kernel
def decode_payloads(data: ByteArray, offset: IntArray, length: IntArray, t: Tables, out: Output) -> int:
    """Read payload i = data[offset[i] : offset[i] + length[i]] into row i of the output.

    Returns how many were malformed; their columns are NaN and their stamps 0.
    """
    s = Scratch(
        np.zeros(t.nodes.shape[0], dtype=np.uint8),
        np.zeros(t.lists, dtype=np.int64),
        np.zeros((STACK, 3), dtype=np.int64),
        np.zeros(1, dtype=np.uint64),
        np.zeros(1, dtype=np.uint32),
    )
    layout = Layout(
        np.empty((MAX_LAYOUT, 4), dtype=np.int64),
        np.empty(MAX_LAYOUT, np.uint64),
        np.empty(MAX_LAYOUT, np.uint64),
    )
    fields, layout_size, misses, bad, i = 0, 0, 0, 0, 0
    out.stamps[:] = 0
    while i < offset.size:
        if fields > 0 and misses < _PATIENCE:
            first = i
            i = read_alike(data, offset, length, i, layout_size, fields, layout, t.template, out, s.half)
            misses = 0 if i > first else misses
            if i == offset.size:
                break
        misses = misses + 1 if misses < _PATIENCE + _PAUSE else 0
        start, size = offset[i], length[i]
        good, is_plain = start >= 0 and size >= 0 and size <= data.size - start, False
        if good:
            good, is_plain = _payload(data, start, start + size, i, t, out, s)
        if is_plain and misses <= _PATIENCE:
            fields, layout_size = learn(data, start, start + size, t, layout), size
        if not good:
            out.columns[:, i] = np.nan
            out.stamps[i, :] = 0
            bad += 1
        i += 1
    return bad
