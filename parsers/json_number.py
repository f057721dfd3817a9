"""Numbers in JSON texts, eight digits at a time.

A number whose digits make an integer up to 2^53 and whose power of ten is at most 22 is one correctly rounded
multiplication or division of two exact numbers (Clinger, "How to read floating point numbers accurately"); of any
other only the place is told, and its text is read elsewhere.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import ByteArray
from parsers.jit import lean_kernel, load_u64

MINUS, PLUS, DOT, ZERO, NINE = 45, 43, 46, 48, 57
SLACK = 32
"""So many bytes behind the beginning of a number may be looked at by the fast way."""
_EXACT = 1 << 53
_POWERS = np.array([10.0**k for k in range(23)])
_TENS = np.array([10**k for k in range(9)])
_ZEROS = np.uint64(0x3030303030303030)
_ABOVE_NINE = np.uint64(0x7676767676767676)
_HIGH_BITS = np.uint64(0x8080808080808080)
_ONES = np.uint64(0x0101010101010101)
_PAIRS, _FOURS = np.uint64(0x00FF00FF00FF00FF), np.uint64(0x0000FFFF0000FFFF)


@lean_kernel
def _digit(byte: int) -> int:
    """The value of a digit, as int64."""
    return np.int64(byte) - ZERO  # type: ignore[return-value]


@lean_kernel
def _eight(data: ByteArray, at: int) -> tuple[int, int]:
    """The number that the digits at a place make, and how many there are: up to 8. Looks at 8 bytes, unchecked."""
    digits = load_u64(data, at) ^ _ZEROS
    other = ((digits + _ABOVE_NINE) | digits) & _HIGH_BITS
    count = np.uint64(8)
    if other != np.uint64(0):
        # the ones below the lowest bit of `other` reach into each byte before it
        below = ((other ^ (other - np.uint64(1))) & _ONES) * _ONES
        count = (below >> np.uint64(56)) - np.uint64(1)
        if count == np.uint64(0):
            return 0, 0
        digits <<= np.uint64(64) - (count << np.uint64(3))
    pairs = (digits * np.uint64(2561)) >> np.uint64(8)
    fours = ((pairs & _PAIRS) * np.uint64(6553601)) >> np.uint64(16)
    value = ((fours & _FOURS) * np.uint64(42949672960001)) >> np.uint64(32)
    return np.int64(value), np.int64(count)  # type: ignore[return-value]


@lean_kernel
def quick_number(data: ByteArray, at: int) -> tuple[int, float, int]:
    """An everyday number: the place behind it, its value, and as an integer (-1 where it has a fraction).

    Place -1: not an everyday one, or none. Looks at up to SLACK bytes, unchecked.
    """
    negative = data[at] == MINUS
    if negative:
        at += 1
    first = data[at]
    if data[at + 1] == DOT and ZERO <= first <= NINE:
        mantissa, count = _digit(first), 1
    else:
        mantissa, count = _eight(data, at)
        if count == 0 or count == 8 or (count > 1 and first == ZERO):
            return -1, np.nan, -1
    at += count
    value, scale = float(mantissa), 0
    if data[at] == DOT:
        fraction, scale = _eight(data, at + 1)
        mantissa = mantissa * int(_TENS[scale]) + fraction
        at += 1 + scale
        if scale == 8:
            rest, more = _eight(data, at)
            if more == 8 or count + more > 10:
                return -1, np.nan, -1
            mantissa = mantissa * int(_TENS[more]) + rest
            at += more
            scale += more
        if scale == 0 or mantissa > _EXACT:
            return -1, np.nan, -1
        value = mantissa / _POWERS[scale]
        mantissa = -1
    if data[at] | 32 == 101:
        return -1, np.nan, -1
    if negative:
        return at, -value, -1
    return at, value, mantissa


@lean_kernel
def _run(data: ByteArray, at: int, end: int, mantissa: int, used: int) -> tuple[int, int, int]:
    """Read on digits: the place behind them, the mantissa with them, and how many of its digits count (18 are kept)."""
    while at < end and ZERO <= data[at] <= NINE:
        if used < 18:
            mantissa = mantissa * 10 + _digit(data[at])
        used += 1 if mantissa > 0 else 0
        at += 1
    return at, mantissa, used


@lean_kernel
def _exponent(data: ByteArray, at: int, end: int) -> tuple[int, int]:
    """What stands behind an "e": the place behind it (-1: no exponent) and its value, at most 2^30."""
    minus = at < end and data[at] == MINUS
    if at < end and (minus or data[at] == PLUS):
        at += 1
    first, power = at, 0
    while at < end and ZERO <= data[at] <= NINE:
        if power < 1 << 20:
            power = power * 10 + _digit(data[at])
        at += 1
    if at == first:
        return -1, 0
    return at, -power if minus else power


@lean_kernel
def _any(data: ByteArray, at: int, end: int) -> tuple[int, float, int, int]:
    """Any number; what `number` says."""
    negative = at < end and data[at] == MINUS
    if negative:
        at += 1
    first = at
    at, mantissa, used = _run(data, at, end, 0, 0)
    if at == first or (data[first] == ZERO and at - first > 1):
        return -1, np.nan, 0, -1
    whole = mantissa if at - first <= 18 and not negative else -1
    scale = 0
    if at < end and data[at] == DOT:
        first = at + 1
        at, mantissa, used = _run(data, first, end, mantissa, used)
        if at == first:
            return -1, np.nan, 0, -1
        scale, whole = first - at, -1
    if at < end and (data[at] == 101 or data[at] == 69):
        at, power = _exponent(data, at + 1, end)
        if at < 0:
            return -1, np.nan, 0, -1
        scale, whole = scale + power, -1
    if used > 18 or mantissa > _EXACT or scale > 22 or scale < -22:
        return at, np.nan, 0, whole
    value = mantissa * _POWERS[scale] if scale >= 0 else mantissa / _POWERS[-scale]
    return at, -value if negative else value, 1, whole


@lean_kernel
def number(data: ByteArray, at: int, end: int) -> tuple[int, float, int, int]:
    """A number in data[at:end]: the place behind it (-1: none), its value, whether that is exact, and as an integer.

    exact 1: the value is the nearest float64. 0: only the text tells (many digits or a large exponent).
    The integer is -1 where the number is negative, has a fraction, an exponent, or more than 18 digits.
    """
    if at + SLACK <= data.size:
        stop, value, whole = quick_number(data, at)
        if 0 <= stop <= end:
            return stop, value, 1, whole
    return _any(data, at, end)
