"""Kernels that turn time texts into nanoseconds: decimal numbers exactly, stretches of time, and numbers that spell HHMMSS."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import IntArray
from parsers.jit import kernel
from parsers.table_bytes import byte_at
from parsers.table_numbers import after_sign, group_sign

BoolArray = NDArray[np.bool_]

DAY_NS = 86_400_000_000_000
_TENS = 10 ** np.arange(19, dtype=np.int64)
_SECOND_NS = 1_000_000_000
_MOST_DAYS = 50_000
"""Of a stretch of time, so that it and as many hours as have six digits fit into int64."""


@kernel
def _scaled(digits: np.int64, power: int, unit_ns: int) -> tuple[bool, np.int64]:
    """digits * 10**power * unit_ns as a whole number, rounded; (False, 0) where it is beyond int64."""
    if -18 <= power <= 0:
        divisor = _TENS[-power]
        factor = unit_ns // divisor
        if factor * divisor == unit_ns and float(digits) * float(factor) < 9.2e18:
            return True, np.int64(digits * factor)
    if power > 18 or float(digits) * 10.0**power * unit_ns > 9.2e18:
        return False, np.int64(0)
    if power >= 0:
        return True, np.int64(digits * _TENS[power] * unit_ns)
    if power < -18:
        return True, np.int64(np.floor(float(digits) * 10.0**power * unit_ns + 0.5))
    divisor = _TENS[-power]
    whole = digits // divisor
    rest = digits - whole * divisor
    return True, np.int64(whole * unit_ns + np.int64(np.floor(float(rest) / float(divisor) * unit_ns + 0.5)))


@kernel
def decimal_stamp(
    start: int, stop: int, decimal: int, thousands: int, unit_ns: int, zero: int
) -> tuple[bool, int]:
    """A decimal text in units of `unit_ns` as whole nanoseconds (rounded), without a detour over doubles.

    A word behind a blank ("0.02 sec") is the unit, which `unit_ns` knows. zero: what whole number stands for 1970, of clocks that
    count too far back for nanoseconds in int64; 0 for others. False where the text is no number, or beyond int64.
    """
    i, negative = after_sign(start, stop)
    digits = np.int64(0)
    count = 0
    power = 0
    seen = False
    fraction = False
    while i < stop:
        c = byte_at(i)
        if 48 <= c <= 57:
            seen = True
            if count < 18 or (count == 18 and digits < 900_000_000_000_000_000):
                digits = digits * 10 + (c - 48)
                count += digits != 0
                power -= fraction
            elif not fraction:
                return False, 0
        elif c == decimal and not fraction:
            fraction = True
        elif seen and not fraction and c != thousands and group_sign(i, stop) > 0:
            i += group_sign(i, stop) - 1
        elif not (c == thousands and digits != 0 and not fraction):
            break
        i += 1
    # Fortran writes 1.5D-02
    if i < stop and seen and (byte_at(i) | 32 == 101 or byte_at(i) | 32 == 100):
        more, end = _exponent(i + 1, stop)
        seen = end > i
        power += more
        i = end
    if seen and i < stop and byte_at(i) == 32:
        i = word_end(i + 1, stop)
    if not seen or i != stop:
        return False, 0
    if zero != 0:
        if power != 0 or negative or digits < zero:
            return False, 0
        digits -= zero
    valid, scaled = _scaled(digits, power, unit_ns)
    value = int(scaled)
    return valid, -value if negative else value


@kernel
def word_end(start: int, stop: int) -> int:
    """Where a word of letters ends."""
    i = start
    while i < stop and 97 <= byte_at(i) | 32 <= 122:
        i += 1
    return i


@kernel
def _exponent(start: int, stop: int) -> tuple[int, int]:
    """The power behind an "e", and where it ends; -1 where there is none."""
    i, minus = after_sign(start, stop)
    exponent = 0
    first = i
    while i < stop and 48 <= byte_at(i) <= 57 and exponent < 1000:
        exponent = int(exponent * 10 + byte_at(i) - 48)
        i += 1
    return -exponent if minus else exponent, i if i > first else -1


@kernel
def digits_at(start: int, stop: int, most: int) -> tuple[int, int]:
    """The whole number at `start` of at most `most` digits, and where it ends (`start` where there is none)."""
    i = start
    value = 0
    while i < stop and i - start < most and 48 <= byte_at(i) <= 57:
        value = int(value * 10 + byte_at(i) - 48)
        i += 1
    return value, i


@kernel
def fraction_at(start: int, stop: int, whole_ms: bool) -> tuple[int, int]:
    """The digits behind a second's decimal sign as nanoseconds, and where they end. whole_ms: up to three are milliseconds."""
    nanos = 0
    scale = 100_000_000
    i = start
    while i < stop and 48 <= byte_at(i) <= 57:
        nanos += int(scale * (np.int64(byte_at(i)) - 48))
        scale //= 10
        i += 1
    if whole_ms and i - start < 3:
        nanos //= 10 ** (3 - (i - start))
    return nanos, i


@kernel
def elapsed_stamp(start: int, stop: int) -> tuple[bool, int]:
    """A stretch of time in nanoseconds: "03:00.020", "1:03:00.02", "0 days 00:03:00.02", "1 day, 0:03:00"; with a sign
    before it, and after days. False where the text was not understood to its end."""
    i, negative = after_sign(start, stop)
    days = 0
    number, j = digits_at(i, stop, 6)
    if j > i and j < stop and byte_at(j) == 32:
        # pandas writes -1 days +23:59:59: the sign is that of the days alone
        days = -number if negative else number
        i = word_end(j + 1, stop)
        if i < j + 4 or byte_at(j + 1) | 32 != 100 or number > _MOST_DAYS:
            return False, 0
        while i < stop and (byte_at(i) == 44 or byte_at(i) == 32):
            i += 1
        i, negative = after_sign(i, stop)
        number, j = digits_at(i, stop, 6)
    if j == i or j >= stop or byte_at(j) != 58:
        return False, 0
    second, k = digits_at(j + 1, stop, 2)
    if k != j + 3:
        return False, 0
    total = number * 60 + second
    valid = second < 60
    if k < stop and byte_at(k) == 58:
        third, i = digits_at(k + 1, stop, 2)
        valid = valid and i == k + 3 and third < 61
        total, k = total * 60 + third, i
    nanos = 0
    if k < stop and (byte_at(k) == 46 or byte_at(k) == 44):
        nanos, k = fraction_at(k + 1, stop, False)
    total = total * _SECOND_NS + nanos
    return valid and k == stop, days * DAY_NS + (-total if negative else total)


@kernel
def clock_stamp(hhmmss_ns: int) -> tuple[bool, int]:
    """Nanoseconds since midnight of a time written as the number HHMMSS.ss, given as nanoseconds of that number."""
    if hhmmss_ns < 0:
        return False, 0
    whole = hhmmss_ns // _SECOND_NS
    hours = whole // 10000
    minutes = whole // 100 - hours * 100
    seconds = whole - whole // 100 * 100
    valid = hours < 24 and minutes < 60 and seconds < 61
    return valid, hhmmss_ns + (hours * 3600 + minutes * 60 + seconds - whole) * _SECOND_NS


@kernel
def _unwrap(clock: IntArray, before: int) -> None:
    half = DAY_NS // 2
    for k in range(clock.shape[0]):
        step = clock[k] - before
        if step < -half or step >= half:
            step = (step + half) % DAY_NS - half
        before += step
        clock[k] = before


def unwrap_days(clock: IntArray, before: int | None) -> IntArray:
    """Times of day as a time that runs on over midnight: each step is the shorter way round the day.

    clock: shape (n,), nanoseconds since midnight; changed in place. before: the last value of the chunk before,
    already running on.
    """
    if len(clock):
        _unwrap(clock, int(clock[0]) if before is None else before)
    return clock
