"""A line's layout, taken down after a format's kernel has read the line (see `parsers.can.layouts`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.can.layouts import (
    BASE_NS,
    DOT,
    FIELDS,
    HEAD,
    HEAD_WORDS,
    ID_FILL,
    ID_FLAG,
    ID_MASK,
    ID_MOST,
    ID_STOP,
    N_WORDS,
    NEXT,
    NINTH,
    NUMBER_MASK,
    NUMBER_STOP,
    ON_BUS,
    PART_MASK,
    PART_NS,
    PART_SHIFT,
    SIZE,
    SIZE_AT,
    UNIT_NS,
    WHOLE_MASK,
    WORDS,
    ZEROS,
    Layouts,
)
from parsers.can.linebook import (
    BUS,
    COUNT_AT,
    COUNT_END,
    CURRENT,
    DATA_AT,
    ID,
    ID_AT,
    ID_END,
    LAYOUTS,
    NUMBER_AT,
    NUMBER_END,
    OLDEST,
    STAMP,
    STAMP_AT,
    STAMP_END,
    Book,
)
from parsers.can.words import BEHIND, FRONT
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, load_u64

_ALL = np.uint64(0xFFFFFFFFFFFFFFFF)


@kernel
def last_bytes(count: int) -> np.uint64:
    """A mask of the last `count` of eight characters, 1 to 8."""
    return _ALL << np.uint64(8 * (8 - count))


@kernel
def digits_value(text: ByteArray, at: int, end: int) -> int:
    """The number in [at, end); -1 where there is none or another character among its digits."""
    value = 0 if at < end else -1
    for i in range(at, end):
        if text[i] < 48 or text[i] > 57:
            return -1
        value = value * 10 + text[i] - 48
    return value


@kernel
def learn_stamp(
    text: ByteArray,
    begin: int,
    unit_ns: int,
    found: IntArray,
    field: IntArray,
    word: NDArray[np.uint64],
    free: ByteArray,
) -> bool:
    """Where a stamp's digits stand. At most eight before the point differ from line to line, the others are fixed."""
    dot = found[STAMP_AT]
    end = found[STAMP_END]
    while dot < end and 48 <= text[dot] <= 57:
        dot += 1
    size = dot - found[STAMP_AT]
    parts = max(end - dot - 1, 0)
    if size < 1 or size > 12 or parts > 9 or unit_ns % 10**parts != 0:
        return False
    varied = min(size, 8)
    fixed = 0 if size == varied else digits_value(text, found[STAMP_AT], dot - varied)
    # the format's kernel must have no reason to refuse a stamp for its size
    if (fixed + 1) * 100_000_000 > 9_000_000_000_000_000_000 // unit_ns:
        return False
    first_parts = min(parts, 8)
    stamp = digits_value(text, dot - varied, dot) * unit_ns
    field[DOT] = dot - begin
    field[UNIT_NS] = unit_ns
    word[WHOLE_MASK] = last_bytes(varied)
    free[dot - varied - begin : dot - begin] = 1
    if parts > 0:
        part = digits_value(text, dot + 1, end)
        if part < 0:
            return False
        field[PART_NS] = unit_ns // 10**first_parts
        field[NINTH] = end - 1 - begin if parts == 9 else 0
        word[PART_MASK] = last_bytes(first_parts)
        word[PART_SHIFT] = np.uint64(8 * (8 - first_parts))
        free[dot + 1 - begin : end - begin] = 1
        stamp += part * (unit_ns // 10**parts)
    field[BASE_NS] = found[STAMP] - stamp
    return True


@kernel
def learn_id(begin: int, found: IntArray, field: IntArray, word: NDArray[np.uint64], free: ByteArray) -> bool:
    """Where the identifier's digits stand."""
    size = found[ID_END] - found[ID_AT]
    if size < 1 or size > 8:
        return False
    field[ID_STOP] = found[ID_END] - begin
    field[ID_FLAG] = found[ID] & 0x80000000
    field[ID_MOST] = 0x1FFFFFFF if field[ID_FLAG] != 0 else 0x7FF
    word[ID_MASK] = last_bytes(size)
    word[ID_FILL] = ZEROS & ~word[ID_MASK]
    free[found[ID_AT] - begin : found[ID_END] - begin] = 1
    return True


@kernel
def learn_number(
    text: ByteArray, begin: int, found: IntArray, field: IntArray, word: NDArray[np.uint64], free: ByteArray
) -> None:
    """Where the line's number stands, if it has one: of it only matters that it is one."""
    field[NUMBER_STOP] = 8
    size = min(found[NUMBER_END] - found[NUMBER_AT], 8)
    if size >= 1 and digits_value(text, found[NUMBER_END] - size, found[NUMBER_END]) >= 0:
        field[NUMBER_STOP] = found[NUMBER_END] - begin
        word[NUMBER_MASK] = last_bytes(size)
        free[found[NUMBER_END] - size - begin : found[NUMBER_END] - begin] = 1


@kernel
def learn_size(
    text: ByteArray, begin: int, count: int, found: IntArray, field: IntArray, free: ByteArray
) -> bool:
    """How the payload's length is known: by its end, by one digit, or it is the layout's."""
    if found[COUNT_AT] == 0:
        field[SIZE] = -found[COUNT_END]
        return True
    field[SIZE] = count
    if found[COUNT_END] - found[COUNT_AT] == 1 and count <= 8 and text[found[COUNT_AT]] == 48 + count:
        field[SIZE_AT] = found[COUNT_AT] - begin
        free[found[COUNT_AT] - begin] = 1
    return count > 0


@kernel
def keep(field: IntArray, word: NDArray[np.uint64], book: Book, layouts: Layouts) -> None:
    """Put a layout that is new in the place of the oldest."""
    state = book.state
    most = layouts.fields.shape[0]
    for k in range(state[LAYOUTS]):
        same = True
        for i in range(FIELDS):
            same = same and (i == NEXT or layouts.fields[k, i] == field[i])
        for i in range(WORDS):
            same = same and layouts.words[k, i] == word[i]
        if same:
            state[CURRENT] = k
            return
    k = state[OLDEST]
    state[OLDEST] = k + 1 if k + 1 < most else 0
    state[LAYOUTS] = min(state[LAYOUTS] + 1, most)
    state[CURRENT] = k
    layouts.fields[k] = field
    layouts.words[k] = word


@kernel
def learn(
    text: ByteArray,
    begin: int,
    stop: int,
    count: int,
    unit_ns: int,
    found: IntArray,
    book: Book,
    layouts: Layouts,
) -> None:
    """Take down the layout of the line that begins at `begin` and is a frame, if it is of a kind that can be.

    found: as the format's kernel filled it, places in the whole text. COUNT_AT is 0 where the payload says by its own
    end how long it is; COUNT_END is then the most bytes it may have. count: its bytes. unit_ns: a stamp's unit.
    """
    head = found[DATA_AT] - begin
    if layouts.fields.shape[0] == 0 or begin < FRONT or stop + BEHIND > text.size:
        return
    if head < 1 or head > 8 * HEAD_WORDS:
        return
    field = np.zeros(FIELDS, dtype=np.int64)
    word = np.zeros(WORDS, dtype=np.uint64)
    free = np.zeros(8 * HEAD_WORDS, dtype=np.uint8)
    if not learn_stamp(text, begin, unit_ns, found, field, word, free):
        return
    if not learn_id(begin, found, field, word, free) or not learn_size(
        text, begin, count, found, field, free
    ):
        return
    learn_number(text, begin, found, field, word, free)
    field[HEAD] = head
    field[N_WORDS] = (head + 7) // 8
    field[ON_BUS] = found[BUS]
    for i in range(head):
        if free[i] == 0:
            word[i // 8] |= np.uint64(0xFF) << np.uint64(8 * (i % 8))
    for i in range(HEAD_WORDS):
        word[HEAD_WORDS + i] = load_u64(text, begin + 8 * i) & word[i]
    keep(field, word, book, layouts)
