"""Kernels that read table text eight bytes at a time: numbers as loggers write them, and the end of a cell.

Places are addresses, loaded without a check: the text must hold a line feed at or before its end, and `PADDING` bytes must lie behind that.
Sources: Lamport 1975, "Multiple byte processing with full-word instructions"; Lemire 2021, as in `table_numbers`.
"""

from __future__ import annotations

import math

import numpy as np

from parsers.jit import kernel, lean_kernel
from parsers.table_bytes import bit_count, byte_at, trailing_zeros, word_at
from parsers.table_numbers import to_double

PADDING = 64
"""Bytes that must be readable behind the last line feed of a text."""

_ONES = np.uint64(0x0101010101010101)
_HIGHS = np.uint64(0x8080808080808080)
_LOWS = np.uint64(0x7F7F7F7F7F7F7F7F)
_ZEROS = np.uint64(0x3030303030303030)
_TO_HIGH = np.uint64(0x7676767676767676)
_NINES = np.uint64(0x0909090909090909)
_PAIRS = np.uint64(0x000000FF000000FF)
_FOURS = np.uint64(0x000F424000000064)
_TWOS = np.uint64(0x0000271000000001)
_TENS = np.array([10**k for k in range(9)], dtype=np.uint64)
_POWERS = np.array([10.0**k for k in range(23)])
_EXACT = np.uint64(1 << 53)
_MOST_DIGITS = 18


@lean_kernel
def _first_byte(mask: np.uint64) -> int:
    """The place of the first byte of a word whose high bit is set in `mask`; 8 where there is none."""
    return trailing_zeros(mask) >> 3


@lean_kernel
def _digit_run(word: np.uint64) -> int:
    """How many digits a word of characters (already XORed with "00000000") begins with."""
    return _first_byte((((word & _LOWS) + _TO_HIGH) | word) & _HIGHS)


@lean_kernel
def _digits_value(word: np.uint64, count: int) -> np.uint64:
    """The number that the first `count` (0 to 8) digits of a word spell; the word is XORed with "00000000"."""
    if count == 0:
        return np.uint64(0)
    word = word << np.uint64(64 - 8 * count)
    word = word * np.uint64(10) + (word >> np.uint64(8))
    low = (word & _PAIRS) * _FOURS
    high = ((word >> np.uint64(16)) & _PAIRS) * _TWOS
    return (low + high) >> np.uint64(32)


@lean_kernel
def _run_of_digits(at: int, value: np.uint64) -> tuple[np.uint64, int]:
    """Append the digits at `at` to `value`; and where they end. Past 19 digits the value is worth nothing."""
    word = word_at(at) ^ _ZEROS
    count = _digit_run(word)
    value = value * _TENS[count] + _digits_value(word, count)
    at += count
    while count == 8:
        word = word_at(at) ^ _ZEROS
        count = _digit_run(word)
        value = value * _TENS[count] + _digits_value(word, count)
        at += count
    return value, at


@kernel
def _exponent(at: int) -> tuple[bool, int, int]:
    """The power after an "e" at `at`, and where it ends; False where there is none of at most three digits."""
    i = at + 1
    minus = byte_at(i) == 45
    if minus or byte_at(i) == 43:
        i += 1
    power = 0
    first = i
    while 48 <= byte_at(i) <= 57 and i - first < 4:
        power = int(power * 10 + byte_at(i) - 48)
        i += 1
    return 0 < i - first < 4, -power if minus else power, i


@lean_kernel
def quick_number(start: int, decimal: int) -> tuple[bool, float, int]:
    """The number at `start` as the nearest double, and where it ends; False where a slower reader must look.

    What stands behind the number is the caller's to judge.
    """
    first = byte_at(start)
    i = start + (1 if first == 45 or first == 43 else 0)
    begin = i
    digits, i = _run_of_digits(i, np.uint64(0))
    count = i - begin
    power = 0
    if byte_at(i) == decimal:
        point = i + 1
        digits, i = _run_of_digits(point, digits)
        power = point - i
        count -= power
    letter = byte_at(i) | 32
    if letter == 101 or letter == 100:
        sure, more, i = _exponent(i)
        if not sure:
            return False, math.nan, start
        power += more
    if count == 0 or count > _MOST_DIGITS:
        return False, math.nan, start
    if digits <= _EXACT and -22 <= power <= 22:
        value = float(np.int64(digits))
        value = value / _POWERS[-power] if power < 0 else value * _POWERS[power]
    else:
        sure, value = to_double(digits, power)
        if not sure:
            return False, math.nan, start
    return True, -value if first == 45 else value, i


@lean_kernel
def _events(word: np.uint64, separator: np.uint64, other: np.uint64) -> np.uint64:
    """Marks in a word of characters: separators, line feeds and bytes that no text has. The first mark is sure.

    separator, other: the separator's byte (and a second one) in all eight places.
    """
    a = word ^ separator
    b = word ^ other
    c = word ^ (_ONES * np.uint64(10))
    marks = ((a - _ONES) & ~a) | ((b - _ONES) & ~b) | ((c - _ONES) & ~c) | ((word - _NINES) & ~word)
    return marks & _HIGHS


@lean_kernel
def cell_end(start: int, separator: int, blank: int, quote: int) -> int:
    """Where the cell at `start` ends: its separator or line feed; 0 where there is a byte that no text has, or a
    quote that is not closed within the line."""
    i = start
    if byte_at(i) == quote:
        i += 1
        while byte_at(i) != quote and byte_at(i) != 10:
            i += 1
        if byte_at(i) == 10:
            return 0
    one = np.uint64(separator) * _ONES
    two = np.uint64(blank if blank > 0 else separator) * _ONES
    marks = _events(word_at(i), one, two)
    while marks == np.uint64(0):
        i += 8
        marks = _events(word_at(i), one, two)
    i += _first_byte(marks)
    return 0 if byte_at(i) < 9 else i


@lean_kernel
def skip_cells(start: int, cells: int, separator: int, quote: int) -> tuple[int, int]:
    """Skip cells that end with a single separator: where the separator of the last one is, and 0.

    Or where a line feed, a quote or a byte that no text has comes first, and how many separators lacked.
    """
    one = np.uint64(separator) * _ONES
    two = np.uint64(quote if quote >= 0 else 10) * _ONES
    i = start
    while True:
        word = word_at(i)
        ends = word ^ one
        # exact in every byte, not only in the first: they are counted
        ends = ~(((ends & _LOWS) + _LOWS) | ends | _LOWS)
        stops = _events(word, two, two)
        count = bit_count(ends)
        if stops == np.uint64(0) and count < cells:
            cells -= count
            i += 8
            continue
        last = trailing_zeros(stops)
        while ends != np.uint64(0) and trailing_zeros(ends) < last:
            cells -= 1
            if cells == 0:
                return i + (trailing_zeros(ends) >> 3), 0
            ends &= ends - np.uint64(1)
        if last < 64:
            return i + (last >> 3), cells
        i += 8
