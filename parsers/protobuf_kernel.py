"""The kernel that reads protobuf payloads: a table says what to do with each field number.

Source: the protobuf encoding, https://protobuf.dev/programming-guides/encoding. Every read is checked against the
end of the message it is in; a payload that breaks the encoding gives a row of NaN and is counted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel

# columns of the entry table
(
    NUMBER,
    KIND,
    WIRE,
    FIRST_ELEMENT,
    ELEMENTS,
    LIST,
    ONEOF,
    COLUMN_FIRST,
    COLUMN_END,
    NODE_FIRST,
    NODE_END,
    LIST_FIRST,
    LIST_END,
) = range(13)
STACK = 24
_VARINT, _FIXED64, _BYTES, _GROUP, _GROUP_END, _FIXED32 = 0, 1, 2, 3, 4, 5
_DOUBLE, _FLOAT, _UINT64, _INT32, _FIXED64_KIND, _FIXED32_KIND, _BOOL = 1, 2, 4, 5, 6, 7, 8
_MESSAGE, _UINT32, _ENUM, _SFIXED32, _SINT32, _SINT64 = 11, 13, 14, 15, 17, 18


@kernel
def _int(value: np.uint64) -> int:
    """The same bits as int64 (numba's int() would keep it unsigned, and unsigned + signed would be a float)."""
    return np.int64(value)  # type: ignore[return-value]


@kernel
def _varint(data: ByteArray, at: int, end: int) -> tuple[np.uint64, int]:
    """A varint and the place behind it; place -1 where it is cut off or longer than 10 bytes."""
    value = np.uint64(0)
    for k in range(10):
        if at + k >= end:
            return value, -1
        byte = np.uint64(data[at + k])
        value |= (byte & np.uint64(0x7F)) << np.uint64(7 * k)
        if byte < np.uint64(0x80):
            return value, at + k + 1
    return value, -1


@kernel
def _fixed(data: ByteArray, at: int, end: int, size: int) -> tuple[np.uint64, int]:
    """A little-endian number of 4 or 8 bytes and the place behind it, -1 where it is cut off."""
    value = np.uint64(0)
    if at + size > end:
        return value, -1
    for k in range(size):
        value |= np.uint64(data[at + k]) << np.uint64(8 * k)
    return value, at + size


@kernel
def _raw(data: ByteArray, at: int, end: int, wire: int) -> tuple[np.uint64, int]:
    """A number of the given wire type and the place behind it, -1 where it is cut off."""
    if wire == _VARINT:
        return _varint(data, at, end)
    return _fixed(data, at, end, 8 if wire == _FIXED64 else 4)


@kernel
def _whole(kind: int, bits: np.uint64) -> int:
    """The integer that the bits mean for an integer kind (uint64 above 2^63 wraps)."""
    if kind in (_SINT32, _SINT64):
        if kind == _SINT32:
            bits &= np.uint64(0xFFFFFFFF)
        return _int(bits >> np.uint64(1)) ^ -_int(bits & np.uint64(1))
    if kind in (_INT32, _ENUM, _SFIXED32):
        low = _int(bits & np.uint64(0xFFFFFFFF))
        return low - (1 << 32) if low >= (1 << 31) else low
    if kind in (_UINT32, _FIXED32_KIND):
        return _int(bits & np.uint64(0xFFFFFFFF))
    if kind == _BOOL:
        return 1 if bits != np.uint64(0) else 0
    return _int(bits)


@kernel
def _number(kind: int, bits: np.uint64, word: NDArray[np.uint64], half: NDArray[np.uint32]) -> float:
    """The number that the bits mean. word, half: one element of scratch each, to look at bits as floats."""
    if kind == _DOUBLE:
        word[0] = bits
        return word.view(np.float64)[0]  # type: ignore[no-any-return]
    if kind == _FLOAT:
        half[0] = np.uint32(bits & np.uint64(0xFFFFFFFF))
        return np.float64(half.view(np.float32)[0])
    if kind in (_UINT64, _FIXED64_KIND):
        return np.float64(bits)
    return np.float64(_whole(kind, bits))


@kernel
def _skip(data: ByteArray, at: int, end: int, wire: int) -> int:
    """The place behind a field of no interest, -1 where the payload is malformed. Groups are skipped whole."""
    depth = 0
    while True:
        if wire == _VARINT:
            _, at = _varint(data, at, end)
        elif wire in (_FIXED64, _FIXED32):
            at += 8 if wire == _FIXED64 else 4
        elif wire == _BYTES:
            size, at = _varint(data, at, end)
            if at < 0 or size > np.uint64(end - at):
                return -1
            at += _int(size)
        elif wire == _GROUP:
            depth += 1
        elif wire == _GROUP_END and depth > 0:
            depth -= 1
        else:
            return -1
        if at < 0 or at > end:
            return -1
        if depth == 0:
            return at
        tag, at = _varint(data, at, end)
        if at < 0 or tag < np.uint64(8):
            return -1
        wire = _int(tag & np.uint64(7))


@kernel
def _find(entries: IntArray, first: int, end: int, number: int, hint: int) -> int:
    """The entry of a field number among entries[first:end] (sorted), -1 where there is none."""
    if first <= hint < end and entries[hint, NUMBER] == number:
        return hint
    low, high = first, end
    while low < high:
        middle = (low + high) // 2
        if entries[middle, NUMBER] < number:
            low = middle + 1
        else:
            high = middle
    if low < end and entries[low, NUMBER] == number:
        return low
    return -1


@kernel
def _clear_oneof(
    entries: IntArray, e: int, oneofs: IntArray, row: FloatArray, seen: ByteArray, counts: IntArray
) -> None:
    """A member of a oneof is set: all others are absent again."""
    one = oneofs[entries[e, ONEOF]]
    for c in range(one[0], one[1]):
        if c < entries[e, COLUMN_FIRST] or c >= entries[e, COLUMN_END]:
            row[c] = np.nan
    for n in range(one[2], one[3]):
        if n < entries[e, NODE_FIRST] or n >= entries[e, NODE_END]:
            seen[n] = 0
    for k in range(one[4], one[5]):
        if k < entries[e, LIST_FIRST] or k >= entries[e, LIST_END]:
            counts[k] = 0


@kernel
def _enter(nodes: IntArray, node: int, defaults: FloatArray, row: FloatArray, seen: ByteArray) -> None:
    """A message is there: its absent fields have their defaults, unless it was there already (then it is merged)."""
    if seen[node] == 0:
        seen[node] = 1
        for k in range(nodes[node, 2], nodes[node, 3]):
            row[np.int64(defaults[k, 0])] = defaults[k, 1]


@kernel
def _element(entries: IntArray, e: int, counts: IntArray) -> int:
    """Which element a value is (its place in the element table), -1 where it is beyond those of interest."""
    k = 0
    which = entries[e, LIST]
    if which >= 0:
        k = counts[which]
        counts[which] += 1
    return entries[e, FIRST_ELEMENT] + k if k < entries[e, ELEMENTS] else -1


@kernel
def _payload(
    data: ByteArray,
    at: int,
    stop: int,
    entries: IntArray,
    nodes: IntArray,
    oneofs: IntArray,
    elements: IntArray,
    defaults: FloatArray,
    row: FloatArray,
    stamp: IntArray,
    seen: ByteArray,
    counts: IntArray,
    stack: IntArray,
    word: NDArray[np.uint64],
    half: NDArray[np.uint32],
) -> bool:
    """Read one payload into `row` and `stamp`; False where it is malformed."""
    node, end, depth, hint = 0, stop, 0, 0
    _enter(nodes, 0, defaults, row, seen)
    while True:
        if at == end:
            if depth == 0:
                return True
            depth -= 1
            node, end = stack[depth, 0], stack[depth, 1]
            continue
        tag, at = _varint(data, at, end)
        if at < 0 or tag < np.uint64(8) or tag > np.uint64(0xFFFFFFFF):
            return False
        wire, number = _int(tag & np.uint64(7)), _int(tag >> np.uint64(3))
        e = _find(entries, nodes[node, 0], nodes[node, 1], number, hint)
        hint = e + 1
        packed = e >= 0 and wire == _BYTES and entries[e, LIST] >= 0 and entries[e, WIRE] != _BYTES
        if e < 0 or (wire != entries[e, WIRE] and not packed):
            at = _skip(data, at, end, wire)
            if at < 0:
                return False
            continue
        if entries[e, ONEOF] >= 0:
            _clear_oneof(entries, e, oneofs, row, seen, counts)
        kind = entries[e, KIND]
        close = end
        if wire == _BYTES:
            size, at = _varint(data, at, end)
            if at < 0 or size > np.uint64(end - at):
                return False
            close = at + _int(size)
            if not packed:
                place = _element(entries, e, counts) if kind == _MESSAGE else -1
                if place < 0 or elements[place, 0] < 0 or depth >= stack.shape[0]:
                    at = close
                    continue
                stack[depth, 0], stack[depth, 1] = node, end
                depth += 1
                node, end = elements[place, 0], close
                hint = nodes[node, 0]
                _enter(nodes, node, defaults, row, seen)
                continue
        while True:
            if packed and at >= close:
                break
            bits, at = _raw(data, at, close, entries[e, WIRE])
            if at < 0:
                return False
            place = _element(entries, e, counts)
            if place >= 0:
                if elements[place, 0] >= 0:
                    row[elements[place, 0]] = _number(kind, bits, word, half)
                if elements[place, 1] >= 0:
                    stamp[elements[place, 1]] = _whole(kind, bits)
            if not packed:
                break


@kernel
def decode_payloads(
    data: ByteArray,
    offset: IntArray,
    length: IntArray,
    entries: IntArray,
    nodes: IntArray,
    oneofs: IntArray,
    elements: IntArray,
    defaults: FloatArray,
    lists: int,
    out: FloatArray,
    stamps: IntArray,
) -> int:
    """Read payload i = data[offset[i] : offset[i] + length[i]] into out[:, i] and stamps[i, :] (seconds, nanoseconds).

    Returns how many were malformed; their columns are NaN and their stamps 0.
    """
    columns = out.shape[0]
    row = np.empty(columns, dtype=np.float64)
    stamp = np.zeros(2, dtype=np.int64)
    seen = np.zeros(nodes.shape[0], dtype=np.uint8)
    counts = np.zeros(lists, dtype=np.int64)
    stack = np.zeros((STACK, 2), dtype=np.int64)
    word = np.zeros(1, dtype=np.uint64)
    half = np.zeros(1, dtype=np.uint32)
    bad = 0
    for i in range(offset.size):
        row[:] = np.nan
        stamp[:] = 0
        seen[:] = 0
        counts[:] = 0
        start, size = offset[i], length[i]
        good = start >= 0 and size >= 0 and size <= data.size - start
        if good:
            good = _payload(
                data, start, start + size, entries, nodes, oneofs, elements, defaults, row, stamp, seen,
                counts, stack, word, half,
            )  # fmt: skip
        if not good:
            row[:] = np.nan
            stamp[:] = 0
            bad += 1
        for c in range(columns):
            out[c, i] = row[c]
        stamps[i, 0], stamps[i, 1] = stamp[0], stamp[1]
    return bad
