"""The kernel that reads JSON payloads: checks the grammar and picks the wanted numbers out.

Source: RFC 8259; also taken are NaN and ±Infinity, which Python's json writes, raw newlines in strings, and zero
bytes behind the message. A malformed payload gives a row of NaN and is counted.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel

# columns of the node table
FIRST_KEY, END_KEY, FIRST_ITEM, ITEMS, COLUMN, STAMP, KNOWN = range(7)
STACK = 256
_QUOTE, _BACKSLASH, _COMMA, _COLON = 34, 92, 44, 58
_MINUS, _PLUS, _DOT, _ZERO, _NINE = 45, 43, 46, 48, 57
_OPEN, _CLOSE, _OPEN_LIST, _CLOSE_LIST = 123, 125, 91, 93
_EXACT = 1 << 53
_POWERS = np.array([10.0**k for k in range(23)])
_TRUE = np.frombuffer(b"true", dtype=np.uint8)
_FALSE = np.frombuffer(b"false", dtype=np.uint8)
_NULL = np.frombuffer(b"null", dtype=np.uint8)
_NAN = np.frombuffer(b"NaN", dtype=np.uint8)
_INFINITY = np.frombuffer(b"Infinity", dtype=np.uint8)


@kernel
def _blank(data: ByteArray, at: int, end: int) -> int:
    """The place of the next byte that is not blank."""
    while at < end and (data[at] == 32 or 9 <= data[at] <= 13):
        at += 1
    return at


@kernel
def _string_end(data: ByteArray, at: int, end: int) -> int:
    """The place of the closing quote of a string whose content begins at `at`, -1 where there is none."""
    while at < end:
        if data[at] == _QUOTE:
            return at
        at += 2 if data[at] == _BACKSLASH else 1
    return -1


@kernel
def _is_word(data: ByteArray, at: int, end: int, word: ByteArray) -> bool:
    if end - at < word.size:
        return False
    same = True
    for k in range(word.size):
        same = same and data[at + k] == word[k]
    return same


@kernel
def _is_nothing(data: ByteArray, at: int, end: int) -> bool:
    """Whether the value at a place is null or an empty object or list."""
    if at < end and (data[at] == _OPEN or data[at] == _OPEN_LIST):
        inside = _blank(data, at + 1, end)
        return inside < end and data[inside] == data[at] + 2
    return _is_word(data, at, end, _NULL)


@kernel
def _digits(data: ByteArray, at: int, end: int) -> int:
    while at < end and _ZERO <= data[at] <= _NINE:
        at += 1
    return at


@kernel
def _digit(data: ByteArray, at: int) -> int:
    return np.int64(data[at]) - _ZERO  # type: ignore[return-value]


@kernel
def _number(data: ByteArray, at: int, end: int) -> tuple[int, float, int, int]:
    """A number: the place behind it (-1: none), its value, whether the value is exact, and as an integer.

    exact 1: the value is the nearest float64. 0: only the text tells (many digits or a large exponent).
    The integer is -1 where the number has a fraction, an exponent, or more than 18 digits.
    """
    negative = at < end and data[at] == _MINUS
    if negative:
        at += 1
    first = at
    at = _digits(data, at, end)
    if at == first or (data[first] == _ZERO and at - first > 1):
        return -1, np.nan, 0, -1
    mantissa, used, scale = 0, 0, 0
    for k in range(first, at):
        if used < 18:
            mantissa = mantissa * 10 + _digit(data, k)
        used += 1 if mantissa > 0 else 0
    whole = mantissa if at - first <= 18 else -1
    if at < end and data[at] == _DOT:
        first = at + 1
        at = _digits(data, first, end)
        if at == first:
            return -1, np.nan, 0, -1
        for k in range(first, at):
            if used < 18:
                mantissa = mantissa * 10 + _digit(data, k)
            used += 1 if mantissa > 0 else 0
        scale, whole = first - at, -1
    if at < end and (data[at] == 101 or data[at] == 69):
        at += 1
        minus = at < end and data[at] == _MINUS
        if at < end and (data[at] == _MINUS or data[at] == _PLUS):
            at += 1
        first = at
        at = _digits(data, at, end)
        if at == first:
            return -1, np.nan, 0, -1
        power = 0
        for k in range(first, min(at, first + 6)):
            power = power * 10 + _digit(data, k)
        scale, whole = scale - power if minus else scale + power, -1
        if at - first > 6:
            scale = 1 << 30
    if negative:
        whole = -1
    if used > 18 or mantissa > _EXACT or scale > 22 or scale < -22:
        return at, np.nan, 0, whole
    # both factors are exact in float64, so that the one rounding gives the nearest value (Clinger)
    value = mantissa * _POWERS[scale] if scale >= 0 else mantissa / _POWERS[-scale]
    if negative:
        value = -value
    return at, value, 1, whole


@kernel
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


@kernel
def _scalar(
    data: ByteArray,
    at: int,
    end: int,
    cell: int,
    stamp_at: int,
    row: FloatArray,
    stamp: IntArray,
    slow: IntArray,
    slow_count: int,
    shift: int,
) -> tuple[int, int]:
    """Read a value that is no string, object or list; returns the place behind it (-1: malformed) and how many
    numbers were left to be read from their text. cell: column of the row, -1 where it is not wanted."""
    value, exact = np.nan, 1
    whole, stop = -1, -1
    first = data[at]
    if _ZERO <= first <= _NINE or first == _MINUS:
        if first == _MINUS and _is_word(data, at + 1, end, _INFINITY):
            value, stop = -np.inf, at + 9
        else:
            stop, value, exact, whole = _number(data, at, end)
    elif _is_word(data, at, end, _TRUE):
        value, stop = 1.0, at + 4
    elif _is_word(data, at, end, _FALSE):
        value, stop = 0.0, at + 5
    elif _is_word(data, at, end, _NULL):
        stop = at + 4
    elif _is_word(data, at, end, _NAN):
        stop = at + 3
    elif _is_word(data, at, end, _INFINITY):
        value, stop = np.inf, at + 8
    if stop < 0:
        return -1, slow_count
    if stamp_at >= 0:
        stamp[stamp_at] = whole
    if cell >= 0:
        row[cell] = value
        if exact == 0:
            if slow_count >= slow.shape[0]:
                return -1, slow_count
            slow[slow_count, 0], slow[slow_count, 1] = at, stop - at
            slow[slow_count, 2] = cell + shift
            slow_count += 1
    return stop, slow_count


@kernel
def _document(
    data: ByteArray,
    at: int,
    end: int,
    nodes: IntArray,
    items: IntArray,
    keys: IntArray,
    names: ByteArray,
    row: FloatArray,
    stamp: IntArray,
    slow: IntArray,
    slow_count: int,
    shift: int,
    stack: IntArray,
    unknown: IntArray,
) -> tuple[bool, int]:
    """Read one payload; returns whether it is whole, and the count of numbers left to be read from their text.

    stack: per open object or list its node, whether it is a list, and the next element or the key to try first.
    """
    while end > at and data[end - 1] == 0:
        end -= 1
    if end - at >= 3 and data[at] == 0xEF and data[at + 1] == 0xBB and data[at + 2] == 0xBF:
        at += 3
    depth, node, value_next = 0, 0, True
    while True:
        at = _blank(data, at, end)
        if not value_next and depth == 0:
            return at == end, slow_count
        if at >= end:
            return False, slow_count
        byte = data[at]
        if value_next:
            value_next = False
            if byte in (_OPEN, _OPEN_LIST):
                if depth == stack.shape[0]:
                    return False, slow_count
                stack[depth, 0], stack[depth, 1] = node, 1 if byte == _OPEN_LIST else 0
                stack[depth, 2] = 0 if byte == _OPEN_LIST or node < 0 else nodes[node, FIRST_KEY]
                depth += 1
                inside = _blank(data, at + 1, end)
                if inside < end and data[inside] == byte + 2:
                    at, depth = inside + 1, depth - 1
                    continue
            elif byte == _QUOTE:
                at = _string_end(data, at + 1, end) + 1
                if at == 0:
                    return False, slow_count
                if node >= 0 and nodes[node, COLUMN] >= 0:
                    row[nodes[node, COLUMN]] = np.nan
                continue
            else:
                cell = nodes[node, COLUMN] if node >= 0 else -1
                stamp_at = nodes[node, STAMP] if node >= 0 else -1
                at, slow_count = _scalar(data, at, end, cell, stamp_at, row, stamp, slow, slow_count, shift)
                if at < 0:
                    return False, slow_count
                continue
        elif byte == (_CLOSE_LIST if stack[depth - 1, 1] else _CLOSE):
            depth -= 1
            at += 1
            continue
        elif byte != _COMMA:
            return False, slow_count
        # behind an opening bracket or a comma: the next element, or the next key and its value
        at = _blank(data, at + 1, end)
        value_next = True
        above = stack[depth - 1, 0]
        if stack[depth - 1, 1]:
            index = stack[depth - 1, 2]
            stack[depth - 1, 2] = index + 1
            node = -1
            if above >= 0 and index < nodes[above, ITEMS]:
                node = items[nodes[above, FIRST_ITEM] + index]
            continue
        if at >= end or data[at] != _QUOTE:
            return False, slow_count
        first = at + 1
        at = _string_end(data, first, end)
        if at < 0:
            return False, slow_count
        node = -1
        if above >= 0 and nodes[above, KNOWN]:
            begin, stop = nodes[above, FIRST_KEY], nodes[above, END_KEY]
            k = _find_key(data, first, at - first, keys, names, begin, stop, stack[depth - 1, 2])
            if k >= 0:
                node = keys[k, 2]
                stack[depth - 1, 2] = k + 1 if k + 1 < stop else begin
            new, size = k < 0, at - first
        else:
            new, size = False, 0
        at = _blank(data, at + 1, end)
        if at >= end or data[at] != _COLON:
            return False, slow_count
        at = _blank(data, at + 1, end)
        if new and not _is_nothing(data, at, end):
            unknown[0] += 1
            if unknown[0] == 1:
                unknown[1], unknown[2] = first, size


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
    """Read payload i = data[offset[i] : offset[i] + length[i]] into out[i, :] and stamps[i, :].

    slow: rows (place, length, cell of `out` counted through) of numbers whose text must be read elsewhere; of two
    texts for one cell the last one holds. unknown: count of keys that no table has (with a value that is something),
    and place and length of the first. Returns how many payloads were malformed, and how many rows of `slow` are used.
    """
    columns = out.shape[1]
    stack = np.zeros((STACK, 3), dtype=np.int64)
    bad, slow_count = 0, 0
    for i in range(offset.size):
        start, size = offset[i], length[i]
        before = slow_count
        whole = start >= 0 and size >= 0 and size <= data.size - start
        out[i, :] = np.nan
        stamps[i, :] = -1
        if whole:
            whole, slow_count = _document(
                data, start, start + size, nodes, items, keys, names, out[i], stamps[i], slow, slow_count,
                i * columns, stack, unknown,
            )  # fmt: skip
        if not whole:
            bad += 1
            slow_count = before
            out[i, :] = np.nan
            stamps[i, :] = -1
    return bad, slow_count
