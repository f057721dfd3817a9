"""The shape of a JSON message: the text between its values, which the next message usually has as well.

Where it does, there is nothing to parse but the values: the text is compared eight bytes at a time.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel, lean_kernel, load_u64
from parsers.json_number import MINUS, NINE, SLACK, ZERO, number, quick_number

MAX_LEAVES, MAX_TEXT = 4096, 1 << 16
"""A message with more values, or more text between them, has no shape."""
# columns of the table of leaves: where a value stands, its column (-1: not wanted) and its part of the stamp
LEAF_AT, LEAF_END, LEAF_CELL, LEAF_STAMP = range(4)
# columns of the shape: place and length of the text before a value, column and stamp part of the value
_TEXT_AT, _TEXT_SIZE, _CELL, _STAMP = range(4)
_QUOTE, _BACKSLASH = 34, 92
_TRUE = np.frombuffer(b"true", dtype=np.uint8)
_FALSE = np.frombuffer(b"false", dtype=np.uint8)
_NULL = np.frombuffer(b"null", dtype=np.uint8)
_NAN = np.frombuffer(b"NaN", dtype=np.uint8)
_INFINITY = np.frombuffer(b"Infinity", dtype=np.uint8)


@lean_kernel
def string_end(data: ByteArray, at: int, end: int) -> int:
    """The place of the closing quote of a string whose content begins at `at`, -1 where there is none."""
    while at < end:
        if data[at] == _QUOTE:
            return at
        at += 2 if data[at] == _BACKSLASH else 1
    return -1


@lean_kernel
def is_word(data: ByteArray, at: int, end: int, word: ByteArray) -> bool:
    """Whether a word stands at a place."""
    if end - at < word.size:
        return False
    same = True
    for k in range(word.size):
        same = same and data[at + k] == word[k]
    return same


@lean_kernel
def is_null(data: ByteArray, at: int, end: int) -> bool:
    """Whether null stands at a place."""
    return is_word(data, at, end, _NULL)


@lean_kernel
def _word(data: ByteArray, at: int, end: int) -> tuple[int, float]:
    """A word that is a value: the place behind it (-1: none) and its number."""
    if is_word(data, at, end, _TRUE):
        return at + 4, 1.0
    if is_word(data, at, end, _FALSE):
        return at + 5, 0.0
    if is_word(data, at, end, _NULL):
        return at + 4, np.nan
    if is_word(data, at, end, _NAN):
        return at + 3, np.nan
    if is_word(data, at, end, _INFINITY):
        return at + 8, np.inf
    if data[at] == MINUS and is_word(data, at + 1, end, _INFINITY):
        return at + 9, -np.inf
    return -1, np.nan


@lean_kernel
def leaf(
    data: ByteArray,
    at: int,
    end: int,
    cell: int,
    part: int,
    i: int,
    out: FloatArray,
    stamps: IntArray,
    slow: IntArray,
    used: int,
) -> tuple[int, int]:
    """Read a value that is no object or list into out[cell, i] and stamps[i, part], where they are wanted (not -1).

    data[at] is there. Returns the place behind it (-1: malformed), and how many rows of `slow` are used: numbers that
    are left to be read from their text.
    """
    if data[at] == _QUOTE:
        if cell >= 0:
            out[cell, i] = np.nan
        return string_end(data, at + 1, end) + 1 or -1, used
    exact, whole = 1, -1
    if ZERO <= data[at] <= NINE or (data[at] == MINUS and at + 1 < end and data[at + 1] <= NINE):
        stop, value, exact, whole = number(data, at, end)
    else:
        stop, value = _word(data, at, end)
    if stop < 0:
        return -1, used
    if part >= 0:
        stamps[i, part] = whole
    if cell >= 0:
        out[cell, i] = value
        if exact == 0:
            if used >= slow.shape[0]:
                return -1, used
            slow[used, 0], slow[used, 1], slow[used, 2] = at, stop - at, cell * out.shape[1] + i
            used += 1
    return stop, used


@lean_kernel
def _same(data: ByteArray, at: int, text: ByteArray, start: int, size: int) -> bool:
    """Whether data[at : at + size] is text[start : start + size]; both have 8 bytes behind that."""
    k = 0
    while k + 8 <= size:
        if load_u64(data, at + k) != load_u64(text, start + k):
            return False
        k += 8
    if k == size:
        return True
    differing = load_u64(data, at + k) ^ load_u64(text, start + k)
    return bool(differing << np.uint64(64 - 8 * (size - k)) == np.uint64(0))


@kernel
def learn(
    data: ByteArray, start: int, end: int, leaves: IntArray, count: int, shape: IntArray, text: ByteArray
) -> int:
    """Take the shape of the message data[start:end] with `count` leaves over; returns how many it has, -1: none."""
    if count > leaves.shape[0]:
        return -1
    place, at = 0, start
    for k in range(count + 1):
        stop = leaves[k, LEAF_AT] if k < count else end
        size = stop - at
        if place + size + 8 > text.size:
            return -1
        text[place : place + size] = data[at:stop]
        shape[k, _TEXT_AT], shape[k, _TEXT_SIZE] = place, size
        place += size
        if k < count:
            shape[k, _CELL], shape[k, _STAMP] = leaves[k, LEAF_CELL], leaves[k, LEAF_STAMP]
            at = leaves[k, LEAF_END]
    return count


@kernel
def read_alike(
    data: ByteArray,
    offset: IntArray,
    length: IntArray,
    i: int,
    shape: IntArray,
    count: int,
    text: ByteArray,
    out: FloatArray,
    stamps: IntArray,
    slow: IntArray,
    used: int,
) -> tuple[int, int]:
    """Read messages from the i-th on for as long as they have this shape.

    Returns the first one that has not, and how many rows of `slow` are used. What the shape has no value for is
    left as it is; of the message where it stops anything may be overwritten.
    """
    last = shape[count, _TEXT_SIZE]
    while i < offset.size:
        at, before = offset[i], used
        end = at + length[i]
        if at < 0 or end < at or end + SLACK + 8 > data.size:
            return i, used
        for k in range(count):
            size = shape[k, _TEXT_SIZE]
            if at + size >= end or not _same(data, at, text, shape[k, _TEXT_AT], size):
                return i, before
            at += size
            cell, part = shape[k, _CELL], shape[k, _STAMP]
            stop, value, whole = -1, np.nan, -1
            if data[at] <= NINE and data[at] != _QUOTE:
                stop, value, whole = quick_number(data, at)
            if stop < 0:
                at, used = leaf(data, at, end, cell, part, i, out, stamps, slow, used)
                if at < 0:
                    return i, before
                continue
            if cell >= 0:
                out[cell, i] = value
            if part >= 0:
                stamps[i, part] = whole
            at = stop
        if at + last != end or not _same(data, at, text, shape[count, _TEXT_AT], last):
            return i, before
        i += 1
    return i, used
