"""The quick way through a text log: a line that is written as one before it is read by place, eight characters at once.

Lines of a log differ in their digits only. Once a format's kernel has read a line, all that is no digit of its stamp,
identifier, line number or payload is a layout; what it would make of a line in which all of that is the same, and
whose digits are digits, is known. Any other line goes the long way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parsers.can.linebook import CLOCK, CURRENT, DAMAGED, FRAMES, LAYOUTS, LINE, USED, Book, Rows
from parsers.can.words import (
    BEHIND,
    FRONT,
    compact_bytes,
    decimal,
    feed_after,
    hexadecimal,
    not_decimal,
    not_hexadecimal,
    spaced_bytes,
)
from parsers.channels import ByteArray, IntArray
from parsers.jit import lean_kernel, load_u64

MOST_LAYOUTS = 32
HEAD_WORDS = 12
"""A line's beginning up to its payload takes at most so many words of eight characters, or has no layout."""

# places in a row of `Layouts.fields`; characters are counted from the line's first
N_WORDS, HEAD, DOT, UNIT_NS, PART_NS, NINTH, BASE_NS = 0, 1, 2, 3, 4, 5, 6
ID_STOP, ID_MOST, ID_FLAG, NUMBER_STOP, SIZE_AT, SIZE, ON_BUS, NEXT = 7, 8, 9, 10, 11, 12, 13, 14
FIELDS = 15
# places in a row of `Layouts.words`, behind the masks and the values of the line's beginning
WHOLE_MASK, PART_SHIFT, PART_MASK, ID_MASK, ID_FILL, NUMBER_MASK = range(2 * HEAD_WORDS, 2 * HEAD_WORDS + 6)
WORDS = 2 * HEAD_WORDS + 6

ZEROS = np.uint64(0x3030303030303030)
_NONE = np.uint64(0)


class Layouts(NamedTuple):
    """The layouts met in a piece of a file, and the table of `parsers.can.words.hex_pairs`.

    fields: (most, FIELDS). words: (most, WORDS).
    A layout's SIZE_AT is the place of its size's digit, 0 where all of its lines have the same SIZE; SIZE is below 0
    where the payload says by its own end how long it is: minus the most bytes.
    """

    fields: NDArray[np.int64]
    words: NDArray[np.uint64]
    pairs: NDArray[np.int16]


def no_layouts(pairs: NDArray[np.int16], most: int = MOST_LAYOUTS) -> Layouts:
    """Room for `most` layouts, none of them met yet; with 0 every line goes the long way."""
    return Layouts(np.zeros((most, FIELDS), dtype=np.int64), np.zeros((most, WORDS), dtype=np.uint64), pairs)


@lean_kernel
def same_head(text: ByteArray, begin: int, word: NDArray[np.uint64], n_words: int) -> bool:
    """Whether all fixed characters of a line's beginning are the layout's."""
    for i in range(n_words):  # noqa: SIM110 (a kernel knows no generators)
        if (load_u64(text, begin + 8 * i) & word[i]) != word[HEAD_WORDS + i]:
            return False
    return True


@lean_kernel
def read_payload(
    text: ByteArray, begin: int, field: IntArray, pairs: NDArray[np.int16], data: ByteArray, into: int
) -> int:
    """The payload's number of bytes, now in data[into:]; -1 where it is not written in the layout."""
    size = field[SIZE]
    at = begin + field[HEAD]
    if size < 0:
        return compact_bytes(text, at, -size, pairs, data, into)
    if field[SIZE_AT] > 0:
        size = text[begin + field[SIZE_AT]] - 48
        if size < 1 or size > 8:
            return -1
    return size if spaced_bytes(text, at, size, pairs, data, into) else -1


@lean_kernel
def text_size(field: IntArray, size: int) -> int:
    """How many characters a payload of so many bytes takes."""
    return 2 * size if field[SIZE] < 0 else 3 * size - 1


@lean_kernel
def ninth_digit(text: ByteArray, begin: int, at: int) -> int:
    """The ninth digit behind a stamp's point, 0 where stamps have fewer (`at` is 0), -1 where it is no digit."""
    digit = text[begin + at] - 48 if at > 0 else 0
    return digit if 0 <= digit <= 9 else -1


@lean_kernel
def lines_of(
    text: ByteArray, begin: int, stop: int, k: int, summed: bool, book: Book, rows: Rows, layouts: Layouts
) -> int:
    """Read lines as long as they are written in layout k; where the first one begins that is not."""
    state, field, word = book.state, layouts.fields[k], layouts.words[k]
    time_ns, can_id, bus, length, offset, data = rows
    n_words, head, dot, number_stop, id_stop = (
        field[N_WORDS],
        field[HEAD],
        field[DOT],
        field[NUMBER_STOP],
        field[ID_STOP],
    )
    whole_mask, part_mask, part_shift = word[WHOLE_MASK], word[PART_MASK], word[PART_SHIFT]
    number_mask, id_mask, id_fill = word[NUMBER_MASK], word[ID_MASK], word[ID_FILL]
    base_ns, unit_ns, part_ns, ninth_at = field[BASE_NS], field[UNIT_NS], field[PART_NS], field[NINTH]
    id_most, id_flag, on_bus = field[ID_MOST], field[ID_FLAG], field[ON_BUS]
    n, used, clock = state[FRAMES], state[USED], state[CLOCK]
    before = n
    while begin + head < stop and n < time_ns.size and same_head(text, begin, word, n_words):
        whole = (load_u64(text, begin + dot - 8) ^ ZEROS) & whole_mask
        part = ((load_u64(text, begin + dot + 1) ^ ZEROS) << part_shift) & part_mask
        number = (load_u64(text, begin + number_stop - 8) ^ ZEROS) & number_mask
        digits = (load_u64(text, begin + id_stop - 8) & id_mask) | id_fill
        wrong = not_decimal(whole) | not_decimal(part) | not_decimal(number) | not_hexadecimal(digits)
        found_id = hexadecimal(digits)
        ninth = ninth_digit(text, begin, ninth_at)
        if wrong != _NONE or found_id > id_most or ninth < 0:
            break
        stamp = base_ns + decimal(whole) * unit_ns + decimal(part) * part_ns + ninth
        size = read_payload(text, begin, field, layouts.pairs, data, used)
        feed = feed_after(text, begin + head + text_size(field, size), stop) if size >= 0 else -1
        if feed < 0:
            break
        if summed:
            clock += stamp
            stamp = clock
        time_ns[n] = stamp
        can_id[n] = found_id | id_flag
        bus[n] = on_bus
        length[n] = size
        offset[n] = used
        used += size
        n += 1
        begin = feed + 1
    state[LINE] += n - before
    state[FRAMES] = n
    state[USED] = used
    state[CLOCK] = clock
    return begin


@lean_kernel
def known_lines(
    text: ByteArray, begin: int, stop: int, summed: bool, book: Book, rows: Rows, layouts: Layouts
) -> int:
    """Read lines as long as they are written in layouts that are known; where the first one begins that is not.

    The line after a malformed one is always left to the format's kernel, which records the time that was lost.
    """
    state = book.state
    met = state[LAYOUTS]
    if state[DAMAGED] != 0 or met == 0 or begin < FRONT or stop + BEHIND > text.size:
        return begin
    fields = layouts.fields
    k = state[CURRENT]
    last = -1
    misses = 0
    while misses < met and begin < stop:
        after = lines_of(text, begin, stop, k, summed, book, rows, layouts)
        if after > begin:
            if last >= 0:
                fields[last, NEXT] = k
            begin = after
            last = k
            misses = 0
            k = fields[k, NEXT]
        else:
            misses += 1
            k = k + 1 if k + 1 < met else 0
    state[CURRENT] = last if last >= 0 else state[CURRENT]
    return begin
