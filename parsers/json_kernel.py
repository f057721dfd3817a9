"""The kernel that reads JSON payloads: checks the grammar and picks the wanted numbers out.

Source: RFC 8259; also taken are NaN and ±Infinity, which Python's json writes, raw newlines in strings, and zero
bytes behind the message. A malformed payload gives a row of NaN and is counted.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel, lean_kernel
from parsers.json_shape import (
    LEAF_AT,
    LEAF_CELL,
    LEAF_END,
    LEAF_STAMP,
    MAX_LEAVES,
    MAX_TEXT,
    is_null,
    leaf,
    learn,
    read_alike,
    string_end,
)

# columns of the node table
FIRST_KEY, END_KEY, FIRST_ITEM, ITEMS, COLUMN, STAMP, KNOWN = range(7)
# columns of the stack: node of an open object or list, whether it is a list, next element or the key to try first
_NODE, _IS_LIST, _NEXT = range(3)
STACK = 256
_PATIENCE, _PAUSE = 8, 64
"""After so many messages of other shapes one after the other, so many are read without looking at their shape."""
_QUOTE, _COMMA, _COLON = 34, 44, 58
_OPEN, _CLOSE, _OPEN_LIST, _CLOSE_LIST = 123, 125, 91, 93


@lean_kernel
def _blank(data: ByteArray, at: int, end: int) -> int:
    """The place of the next byte that is not blank."""
    while at < end and (data[at] == 32 or 9 <= data[at] <= 13):
        at += 1
    return at


@lean_kernel
def _is_nothing(data: ByteArray, at: int, end: int) -> bool:
    """Whether the value at a place is null or an empty object or list."""
    if at < end and (data[at] == _OPEN or data[at] == _OPEN_LIST):
        inside = _blank(data, at + 1, end)
        return inside < end and data[inside] == data[at] + 2
    return is_null(data, at, end)


@lean_kernel
def _find_key(
    data: ByteArray, at: int, size: int, keys: IntArray, names: ByteArray, first: int, end: int, hint: int
) -> int:
    """The key among keys[first:end] that is data[at : at + size], tried from `hint` on; -1 where there is none."""
    count = end - first
    for step in range(count):
        k = hint + step
        if k >= end:
            k -= count
        if keys[k, 1] == size:
            same = True
            for b in range(size):
                if data[at + b] != names[keys[k, 0] + b]:
                    same = False
                    break
            if same:
                return k
    return -1


@lean_kernel
def _behind_value(data: ByteArray, at: int, end: int, depth: int, stack: IntArray) -> tuple[int, int]:
    """Close what closes behind a value: the place behind the comma (-1: malformed) and the depth.

    At depth 0 the message is over, and the place is that of the next byte which is not blank.
    """
    while True:
        at = _blank(data, at, end)
        if depth == 0:
            return at, 0
        if at >= end:
            return -1, depth
        byte = data[at]
        at += 1
        if byte == _COMMA:
            return at, depth
        if byte != (_CLOSE_LIST if stack[depth - 1, _IS_LIST] else _CLOSE):
            return -1, depth
        depth -= 1


@lean_kernel
def _next_value(
    data: ByteArray,
    at: int,
    end: int,
    top: IntArray,
    nodes: IntArray,
    items: IntArray,
    keys: IntArray,
    names: ByteArray,
    unknown: IntArray,
) -> tuple[int, int]:
    """Behind an opening bracket or a comma: the place of the next value (-1: malformed) and its node (-1: not known).

    top: the row of the stack for the object or list that it is in.
    """
    at = _blank(data, at, end)
    above, node = top[_NODE], -1
    if top[_IS_LIST]:
        index = top[_NEXT]
        top[_NEXT] = index + 1
        if above >= 0 and index < nodes[above, ITEMS]:
            node = items[nodes[above, FIRST_ITEM] + index]
        return at, node
    if at >= end or data[at] != _QUOTE:
        return -1, -1
    first = at + 1
    at = string_end(data, first, end)
    if at < 0:
        return -1, -1
    size = at - first
    known = above < 0 or nodes[above, KNOWN] == 0
    if not known:
        begin, stop = nodes[above, FIRST_KEY], nodes[above, END_KEY]
        k = _find_key(data, first, size, keys, names, begin, stop, top[_NEXT])
        if k >= 0:
            known, node = True, keys[k, 2]
            top[_NEXT] = k + 1 if k + 1 < stop else begin
    at = _blank(data, at + 1, end)
    if at >= end or data[at] != _COLON:
        return -1, -1
    at = _blank(data, at + 1, end)
    if not known and not _is_nothing(data, at, end):
        unknown[0] += 1
        if unknown[0] == 1:
            unknown[1], unknown[2] = first, size
    return at, node


@lean_kernel
def _document(
    data: ByteArray,
    at: int,
    end: int,
    nodes: IntArray,
    items: IntArray,
    keys: IntArray,
    names: ByteArray,
    i: int,
    out: FloatArray,
    stamps: IntArray,
    slow: IntArray,
    used: int,
    stack: IntArray,
    leaves: IntArray,
    unknown: IntArray,
) -> tuple[bool, int, int]:
    """Read one payload; whether it is whole, how many rows of `slow` are used, and how many leaves it has.

    leaves: where the values stand, as many as there is room for.
    """
    depth, node, count = 0, 0, 0
    while True:
        at = _blank(data, at, end)
        if at >= end:
            return False, used, count
        byte = data[at]
        opened = byte in (_OPEN, _OPEN_LIST)
        if opened:
            if depth == stack.shape[0]:
                return False, used, count
            is_list = byte == _OPEN_LIST
            at = _blank(data, at + 1, end)
            if at < end and data[at] == byte + 2:
                opened = False
                at += 1
            else:
                stack[depth, _NODE], stack[depth, _IS_LIST] = node, is_list
                stack[depth, _NEXT] = 0 if is_list or node < 0 else nodes[node, FIRST_KEY]
                depth += 1
        else:
            cell = nodes[node, COLUMN] if node >= 0 else -1
            part = nodes[node, STAMP] if node >= 0 else -1
            begin = at
            at, used = leaf(data, at, end, cell, part, i, out, stamps, slow, used)
            if at < 0:
                return False, used, count
            if count < leaves.shape[0]:
                leaves[count, LEAF_AT], leaves[count, LEAF_END] = begin, at
                leaves[count, LEAF_CELL], leaves[count, LEAF_STAMP] = cell, part
            count += 1
        if not opened:
            at, depth = _behind_value(data, at, end, depth, stack)
            if at < 0 or depth == 0:
                return at == end, used, count
        at, node = _next_value(data, at, end, stack[depth - 1], nodes, items, keys, names, unknown)
        if at < 0:
            return False, used, count


@lean_kernel
def _trim(data: ByteArray, at: int, end: int) -> tuple[int, int]:
    """A payload without a byte order mark and without zero bytes at its end."""
    while end > at and data[end - 1] == 0:
        end -= 1
    if end - at >= 3 and data[at] == 0xEF and data[at + 1] == 0xBB and data[at + 2] == 0xBF:
        at += 3
    return at, end


@kernel
def read_documents(
    data: ByteArray,
    offset: IntArray,
    length: IntArray,
    nodes: IntArray,
    items: IntArray,
    keys: IntArray,
    names: ByteArray,
    out: FloatArray,
    stamps: IntArray,
    slow: IntArray,
    unknown: IntArray,
) -> tuple[int, int]:
    """Read payload i = data[offset[i] : offset[i] + length[i]] into out[:, i] and stamps[i, :].

    slow: rows (place, length, cell of `out` counted through) of numbers whose text must be read elsewhere; of two
    texts for one cell the last one holds. unknown: count of keys that no table has (with a value that is something),
    and place and length of the first. Returns how many payloads were malformed, and how many rows of `slow` are used.
    """
    stack = np.empty((STACK, 3), dtype=np.int64)
    leaves = np.empty((MAX_LEAVES, 4), dtype=np.int64)
    shape = np.empty((MAX_LEAVES + 1, 4), dtype=np.int64)
    text = np.empty(MAX_TEXT, dtype=np.uint8)
    bad, used, shape_size, misses, i = 0, 0, -1, 0, 0
    # what a shape has no value for stays as it is here
    out[:] = np.nan
    stamps[:] = -1
    while i < offset.size:
        if shape_size >= 0 and misses < _PATIENCE:
            alike = i
            i, used = read_alike(data, offset, length, i, shape, shape_size, text, out, stamps, slow, used)
            if i > alike:
                misses = 0
            if i == offset.size:
                break
            out[:, i] = np.nan
            stamps[i, :] = -1
        start, size = offset[i], length[i]
        before, new = used, unknown[0]
        whole = start >= 0 and size >= 0 and size <= data.size - start
        if whole:
            at, end = _trim(data, start, start + size)
            whole, used, count = _document(
                data, at, end, nodes, items, keys, names, i, out, stamps, slow, used, stack, leaves, unknown
            )
            misses = misses + 1 if misses < _PATIENCE + _PAUSE else 0
            # keys that are not known are counted by the long way only
            if whole and unknown[0] == new and misses <= _PATIENCE:
                shape_size = learn(data, start, start + size, leaves, count, shape, text)
        if not whole:
            bad += 1
            used = before
            out[:, i] = np.nan
            stamps[i, :] = -1
        i += 1
    return bad, used
