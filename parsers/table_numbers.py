"""Kernels that turn the text of one cell into a number.

Decimal text becomes the nearest double, exactly: by one multiplication or division where both factors are exact
(Clinger 1990), else by a 128-bit power of ten (Lemire 2021, "Number parsing at a gigabyte per second"); the few
texts that neither settles are handed back for Python's own `float`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel
from parsers.table_bytes import byte_at

OK, EMPTY, TEXT, HARD, INFINITE = 0, 1, 2, 3, 4
"""What a cell was found to be."""

_SMALLEST_POWER = -342
_LARGEST_POWER = 308
_EXACT_POWERS = np.array([10.0**k for k in range(23)])

MISSING_WORDS = (
    "nan",
    "na",
    "n/a",
    "#n/a",
    "null",
    "none",
    "nil",
    "-",
    "--",
    "---",
    "?",
    "missing",
    "-nan",
    "1.#qnan",
    "#nv",
    "nv",
    ".",
)
"""What loggers write for "no value", in lower case."""


def _power_table() -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
    """High and low words of the 128-bit mantissas of 10**q, truncated (rounded up where q < 0)."""
    high, low = [], []
    for q in range(_SMALLEST_POWER, _LARGEST_POWER + 1):
        if q >= 0:
            value = 5**q
            shift = 128 - value.bit_length()
            value = value << shift if shift >= 0 else value >> -shift
        else:
            divisor = 5**-q
            value = (1 << (127 + divisor.bit_length())) // divisor + 1
            value >>= max(0, value.bit_length() - 128)
        high.append(value >> 64)
        low.append(value & ((1 << 64) - 1))
    return np.array(high, dtype=np.uint64), np.array(low, dtype=np.uint64)


_POWER_HIGH, _POWER_LOW = _power_table()


def _word_table() -> tuple[ByteArray, IntArray]:
    width = max(len(word) for word in MISSING_WORDS)
    table = np.zeros((len(MISSING_WORDS), width), dtype=np.uint8)
    for row, word in enumerate(MISSING_WORDS):
        table[row, : len(word)] = np.frombuffer(word.encode(), dtype=np.uint8)
    return table, np.array([len(word) for word in MISSING_WORDS], dtype=np.int64)


_WORDS, _WORD_LENGTHS = _word_table()


@kernel
def _times(a: np.uint64, b: np.uint64) -> tuple[np.uint64, np.uint64]:
    """The high and the low word of a 64-bit by 64-bit product."""
    half = np.uint64(32)
    mask = np.uint64(0xFFFFFFFF)
    a0, a1 = a & mask, a >> half
    b0, b1 = b & mask, b >> half
    low = a0 * b0
    middle = a1 * b0 + (low >> half)
    other = a0 * b1 + (middle & mask)
    return a1 * b1 + (middle >> half) + (other >> half), a * b


@kernel
def to_double(digits: np.uint64, power: int) -> tuple[bool, float]:
    """digits * 10**power as the nearest double; (False, 0) where that is not certain."""
    if digits == np.uint64(0):
        return True, 0.0
    if digits <= np.uint64(1 << 53) and -22 <= power <= 22:
        if power < 0:
            return True, float(digits) / _EXACT_POWERS[-power]
        return True, float(digits) * _EXACT_POWERS[power]
    if power < _SMALLEST_POWER or power > _LARGEST_POWER:
        return False, 0.0
    zeros = 0
    while digits >> np.uint64(63) == np.uint64(0):
        digits = digits << np.uint64(1)
        zeros += 1
    high, low = _times(digits, _POWER_HIGH[power - _SMALLEST_POWER])
    if high & np.uint64(0x1FF) == np.uint64(0x1FF):
        more, _ = _times(digits, _POWER_LOW[power - _SMALLEST_POWER])
        low = low + more
        if more > low:
            high = high + np.uint64(1)
        if low == np.uint64(0xFFFFFFFFFFFFFFFF):
            return False, 0.0
    upper = high >> np.uint64(63)
    shift = upper + np.uint64(9)
    bits = high >> shift
    binary = ((217706 * power) >> 16) + 63 + int(np.int64(upper)) - zeros
    if binary < -1020 or binary > 1020:
        return False, 0.0
    half_way = low <= np.uint64(1) and bits & np.uint64(3) == np.uint64(1) and (bits << shift) == high
    if half_way and -4 <= power <= 23:
        bits = bits & ~np.uint64(1)
    bits = (bits + (bits & np.uint64(1))) >> np.uint64(1)
    return True, math.ldexp(float(bits), binary - 52)


@kernel
def after_sign(start: int, stop: int) -> tuple[int, bool]:
    """Where a number goes on behind its sign (`start` where it has none), and whether it is negative.

    A minus is the hyphen of ASCII or U+2212, which spreadsheets of some languages, R and matplotlib write.
    """
    if start >= stop:
        return start, False
    c = byte_at(start)
    if c == 45 or c == 43:
        return start + 1, c == 45
    if c == 226 and start + 2 < stop and byte_at(start + 1) == 136 and byte_at(start + 2) == 146:
        return start + 3, True
    return start, False


@kernel
def group_sign(at: int, stop: int) -> int:
    """How many bytes a no-break blank, a thin blank or an apostrophe (U+2019) before a group of three digits has; 0 where there is none.

    Between digits of one cell these mean nothing else, in UTF-8 and in cp1252 alike.
    """
    c = byte_at(at)
    size = 1 if c == 0xA0 or c == 0x92 else 0
    if c == 0xC2 and at + 1 < stop and byte_at(at + 1) == 0xA0:
        size = 2
    elif c == 0xE2 and at + 2 < stop and byte_at(at + 1) == 0x80:
        last = byte_at(at + 2)
        size = 3 if last == 0xAF or last == 0x89 or last == 0x99 else 0
    end = at + size + 3
    if size == 0 or end > stop or (end < stop and 48 <= byte_at(end) <= 57):
        return 0
    for k in range(at + size, end):
        if not 48 <= byte_at(k) <= 57:
            return 0
    return size


@kernel
def parse_number(start: int, stop: int, decimal: int, thousands: int) -> tuple[int, float]:
    """The number in the text between two addresses and OK, or NaN and what stands there instead."""
    i, negative = after_sign(start, stop)
    mantissa = np.uint64(0)
    digits = 0
    power = 0
    seen = False
    cut = False
    fraction = False
    while i < stop:
        c = byte_at(i)
        if 48 <= c <= 57:
            seen = True
            if digits < 19:
                mantissa = mantissa * np.uint64(10) + np.uint64(c - 48)
                if mantissa != np.uint64(0):
                    digits += 1
                if fraction:
                    power -= 1
            else:
                cut = cut or c != 48
                if not fraction:
                    power += 1
        elif c == decimal and not fraction:
            fraction = True
        elif seen and not fraction and c != thousands and group_sign(i, stop) > 0:
            i += group_sign(i, stop) - 1
        # nobody groups digits behind a nought: 0.020 is no 20
        elif not (c == thousands and mantissa != np.uint64(0) and not fraction):
            break
        i += 1
    if not seen:
        return TEXT, math.nan
    if i < stop and (byte_at(i) | 32 == 101 or byte_at(i) | 32 == 100):
        i, minus = after_sign(i + 1, stop)
        exponent = 0
        first = i
        while i < stop and 48 <= byte_at(i) <= 57:
            if exponent < 100000:
                exponent = int(exponent * 10 + byte_at(i) - 48)
            i += 1
        if i == first:
            return TEXT, math.nan
        power += -exponent if minus else exponent
    if i != stop:
        return TEXT, math.nan
    sure, value = to_double(mantissa, power)
    if sure and cut:
        sure, above = to_double(mantissa + np.uint64(1), power)
        sure = sure and above == value
    if not sure:
        return HARD, math.nan
    return OK, -value if negative else value


@kernel
def odd_cell(start: int, stop: int) -> int:
    """What a cell (between two addresses) without a number is: EMPTY (or a word for it), INFINITE or TEXT."""
    length = stop - start
    for w in range(_WORDS.shape[0]):
        if _WORD_LENGTHS[w] != length:
            continue
        same = True
        for k in range(length):
            c = byte_at(start + k)
            if 65 <= c <= 90:
                c |= 32
            if c != _WORDS[w, k]:
                same = False
                break
        if same:
            return EMPTY
    k = start
    if k < stop and (byte_at(k) == 43 or byte_at(k) == 45):
        k += 1
    rest = stop - k
    if (
        (rest == 3 or rest == 8)
        and byte_at(k) | 32 == 105
        and byte_at(k + 1) | 32 == 110
        and byte_at(k + 2) | 32 == 102
    ):
        return INFINITE
    return TEXT
