"""Kernels that turn time texts into nanoseconds: decimal numbers exactly, and dates with times of day."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import IntArray
from parsers.jit import kernel
from parsers.table_bytes import byte_at
from parsers.table_numbers import after_sign, group_sign

BoolArray = NDArray[np.bool_]

YEAR_FIRST, DAY_FIRST, MONTH_FIRST = 0, 1, 2
"""Order of the parts of a date."""
WHOLE_MS = 4
"""Added to the order: what stands behind a second are whole milliseconds without zeros before them, 43 of 08:53:20.43."""

DAY_NS = 86_400_000_000_000
MONTHS = (
    ("jan",), ("feb",), ("mar",), ("apr",), ("may", "mai"), ("jun",), ("jul",), ("aug",), ("sep",),
    ("oct", "okt"), ("nov",), ("dec", "dez"),
)  # fmt: skip
"""What the months' names begin with, in English and German."""
_MONTH_KEYS = np.array(
    [(int.from_bytes(name.encode(), "big"), k + 1) for k, names in enumerate(MONTHS) for name in names]
)
_TENS = 10 ** np.arange(19, dtype=np.int64)
_SECOND_NS = 1_000_000_000
_MINUTE_NS = 60 * _SECOND_NS
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
        i = _word_end(i + 1, stop)
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
def _word_end(start: int, stop: int) -> int:
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
def _digits(start: int, stop: int, most: int) -> tuple[int, int]:
    """The whole number at `start` of at most `most` digits, and where it ends (`start` where there is none)."""
    i = start
    value = 0
    while i < stop and i - start < most and 48 <= byte_at(i) <= 57:
        value = int(value * 10 + byte_at(i) - 48)
        i += 1
    return value, i


@kernel
def _days(year: int, month: int, day: int) -> int:
    """Days from 1970-01-01 to a date of the Gregorian calendar."""
    y = year - 1 if month <= 2 else year
    era = y // 400
    of_era = y - era * 400
    month_from_march = (month + 9) % 12
    day_of_year = (153 * month_from_march + 2) // 5 + day - 1
    return era * 146097 + of_era * 365 + of_era // 4 - of_era // 100 + day_of_year - 719468


@kernel
def _month(start: int, stop: int) -> tuple[int, int]:
    """The month that is named at `start` by its first three letters, and where its name ends (`start`: none).

    Names are those of `MONTHS`, which differ in English and German by three.
    """
    end = _word_end(start, stop)
    if end - start < 3:
        return 0, start
    key = (byte_at(start) | 32) << 16 | (byte_at(start + 1) | 32) << 8 | (byte_at(start + 2) | 32)
    for k in range(_MONTH_KEYS.shape[0]):
        if _MONTH_KEYS[k, 0] == key:
            return int(_MONTH_KEYS[k, 1]), end
    return 0, start


@kernel
def _date(start: int, stop: int, order: int) -> tuple[int, int]:
    """The day number of a date such as 2014-04-11 or 11-Apr-2014, and where it ends (`start` where there is none)."""
    first, i = _digits(start, stop, 4)
    if i == start or i >= stop or not (byte_at(i) == 45 or byte_at(i) == 47 or byte_at(i) == 46):
        return 0, start
    second, j = _digits(i + 1, stop, 2)
    named = j == i + 1
    if named:
        second, j = _month(i + 1, stop)
    if j == i + 1 or j >= stop or byte_at(j) != byte_at(i):
        return 0, start
    third, k = _digits(j + 1, stop, 4)
    if k == j + 1:
        return 0, start
    year, month, day = first, second, third
    if order == 1 or (named and first < 32):
        year, month, day = third, second, first
    elif order == 2:
        year, month, day = third, first, second
    if year < 100:
        year += 2000
    if not (1 <= month <= 12 and 1 <= day <= 31 and 1900 <= year <= 2200):
        return 0, start
    return _days(year, month, day), k


@kernel
def _fraction(start: int, stop: int, whole_ms: bool) -> tuple[int, int]:
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
def _clock(start: int, stop: int, whole_ms: bool) -> tuple[int, int]:
    """Nanoseconds since midnight of HH:MM[:SS[.fraction]] [AM|PM], and where it ends (`start`: there is none)."""
    hour, i = _digits(start, stop, 2)
    if i == start or i >= stop or byte_at(i) != 58:
        return 0, start
    minute, j = _digits(i + 1, stop, 2)
    if j == i + 1:
        return 0, start
    second = 0
    nanos = 0
    if j < stop and byte_at(j) == 58:
        second, k = _digits(j + 1, stop, 2)
        if k == j + 1:
            return 0, start
        j = k
        if j < stop and (byte_at(j) == 46 or byte_at(j) == 44 or byte_at(j) == 58):
            nanos, j = _fraction(j + 1, stop, whole_ms)
    k = j
    while k < stop and byte_at(k) == 32:
        k += 1
    if k + 1 < stop and byte_at(k + 1) | 32 == 109 and (byte_at(k) | 32 == 97 or byte_at(k) | 32 == 112):
        hour = hour % 12 + (12 if byte_at(k) | 32 == 112 else 0)
        j = k + 2
    if hour > 24 or minute > 59 or second > 60:
        return 0, start
    return (hour * 3600 + minute * 60 + second) * 1_000_000_000 + nanos, j


@kernel
def _zone(start: int, stop: int) -> tuple[int, int]:
    """Minutes east of Greenwich of "Z", "UTC", "+02:00", "+0200", "+02", and where it ends (`start`: none)."""
    i = start
    while i < stop and byte_at(i) == 32:
        i += 1
    if i >= stop:
        return 0, start
    if byte_at(i) | 32 == 122:
        return 0, i + 1
    if i + 2 < stop and byte_at(i) | 32 == 117 and byte_at(i + 1) | 32 == 116 and byte_at(i + 2) | 32 == 99:
        return 0, i + 3
    if byte_at(i) != 43 and byte_at(i) != 45:
        return 0, start
    hours, j = _digits(i + 1, stop, 2)
    if j != i + 3:
        return 0, start
    if j < stop and byte_at(j) == 58:
        j += 1
    minutes, k = _digits(j, stop, 2)
    total = hours * 60 + minutes
    return -total if byte_at(i) == 45 else total, k


@kernel
def _basic(start: int, stop: int, whole_ms: bool) -> tuple[int, int, int]:
    """Day number and nanoseconds since midnight of 20140411T083856.3 or 20140411T0838, and where it ends (`start`: none)."""
    date, i = _digits(start, stop, 8)
    if i != start + 8 or i >= stop or byte_at(i) | 32 != 116:
        return 0, 0, start
    clock, j = _digits(i + 1, stop, 6)
    if j == i + 5:
        clock *= 100
    elif j != i + 7:
        return 0, 0, start
    nanos = 0
    if j == i + 7 and j < stop and (byte_at(j) == 46 or byte_at(j) == 44):
        nanos, j = _fraction(j + 1, stop, whole_ms)
    year, month, day = date // 10000, date // 100 % 100, date % 100
    hour, minute, second = clock // 10000, clock // 100 % 100, clock % 100
    if not (1 <= month <= 12 and 1 <= day <= 31 and 1900 <= year <= 2200):
        return 0, 0, start
    if hour > 24 or minute > 59 or second > 60:
        return 0, 0, start
    return _days(year, month, day), (hour * 3600 + minute * 60 + second) * _SECOND_NS + nanos, j


@kernel
def calendar_stamp(start: int, stop: int, order: int) -> tuple[bool, int, int]:
    """A date, a time of day or both ("2014-04-11T08:38:56.3+02:00"): midnight of the date since 1970 (0 without a
    date), and the nanoseconds from there, at Greenwich.

    order: YEAR_FIRST, DAY_FIRST or MONTH_FIRST, and WHOLE_MS. False where the text was not understood to its end.
    """
    whole_ms = order >= WHOLE_MS
    day, i = _date(start, stop, order % WHOLE_MS)
    if i > start:
        if i < stop and (byte_at(i) == 84 or byte_at(i) == 116):
            i += 1
        while i < stop and (byte_at(i) == 32 or byte_at(i) == 44):
            i += 1
    clock, j = _clock(i, stop, whole_ms)
    if j == start:
        day, clock, j = _basic(start, stop, whole_ms)
    zone, k = _zone(j, stop)
    if k > j:
        clock -= zone * _MINUTE_NS
    return k == stop and stop > start, day * DAY_NS, clock


@kernel
def elapsed_stamp(start: int, stop: int) -> tuple[bool, int]:
    """A stretch of time in nanoseconds: "03:00.020", "1:03:00.02", "0 days 00:03:00.02", "1 day, 0:03:00"; with a sign
    before it, and after days. False where the text was not understood to its end."""
    i, negative = after_sign(start, stop)
    days = 0
    number, j = _digits(i, stop, 6)
    if j > i and j < stop and byte_at(j) == 32:
        # pandas writes -1 days +23:59:59: the sign is that of the days alone
        days = -number if negative else number
        i = _word_end(j + 1, stop)
        if i < j + 4 or byte_at(j + 1) | 32 != 100 or number > _MOST_DAYS:
            return False, 0
        while i < stop and (byte_at(i) == 44 or byte_at(i) == 32):
            i += 1
        i, negative = after_sign(i, stop)
        number, j = _digits(i, stop, 6)
    if j == i or j >= stop or byte_at(j) != 58:
        return False, 0
    second, k = _digits(j + 1, stop, 2)
    if k != j + 3:
        return False, 0
    total = number * 60 + second
    valid = second < 60
    if k < stop and byte_at(k) == 58:
        third, i = _digits(k + 1, stop, 2)
        valid = valid and i == k + 3 and third < 61
        total, k = total * 60 + third, i
    nanos = 0
    if k < stop and (byte_at(k) == 46 or byte_at(k) == 44):
        nanos, k = _fraction(k + 1, stop, False)
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
