"""Kernels that turn time texts into nanoseconds: decimal numbers exactly, and dates with times of day."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel

BoolArray = NDArray[np.bool_]

YEAR_FIRST, DAY_FIRST, MONTH_FIRST = 0, 1, 2
"""Order of the parts of a date."""

DAY_NS = 86_400_000_000_000
_TENS = 10 ** np.arange(19, dtype=np.int64)
_NO_ZONE = -10000


@kernel
def _scaled(digits: np.int64, power: int, unit_ns: int) -> tuple[bool, np.int64]:
    """digits * 10**power * unit_ns as a whole number, rounded; (False, 0) where it is beyond int64."""
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
def decimal_ns(
    data: ByteArray,
    spans: IntArray,
    decimal: int,
    thousands: int,
    unit_ns: int,
    out: IntArray,
    valid: BoolArray,
) -> None:
    """Decimal texts of a time in units of `unit_ns` as whole nanoseconds (rounded), without a detour over doubles.

    spans: shape (2, n). out, valid: shape (n,). Not valid: no number, or beyond int64.
    """
    for row in range(out.shape[0]):
        i, stop = spans[0, row], spans[1, row]
        out[row] = 0
        valid[row] = False
        negative = i < stop and data[i] == 45
        if i < stop and (data[i] == 43 or data[i] == 45):
            i += 1
        digits = np.int64(0)
        count = 0
        power = 0
        seen = False
        fraction = False
        fits = True
        while i < stop:
            c = np.int64(data[i])
            if 48 <= c <= 57:
                seen = True
                if count < 18 or (count == 18 and digits < 900_000_000_000_000_000):
                    digits = digits * 10 + (c - 48)
                    count += digits != 0
                    power -= fraction
                elif not fraction:
                    fits = False
            elif c == decimal and not fraction:
                fraction = True
            elif not (c == thousands and seen and not fraction):
                break
            i += 1
        if i < stop and seen and data[i] | 32 == 101:
            i += 1
            minus = i < stop and data[i] == 45
            if i < stop and (data[i] == 43 or data[i] == 45):
                i += 1
            exponent = 0
            seen = False
            while i < stop and 48 <= data[i] <= 57 and exponent < 1000:
                exponent = int(exponent * 10 + np.int64(data[i]) - 48)
                seen = True
                i += 1
            power += -exponent if minus else exponent
        if seen and i == stop and fits:
            valid[row], value = _scaled(digits, power, unit_ns)
            out[row] = -value if negative else value


@kernel
def _digits(data: ByteArray, start: int, stop: int, most: int) -> tuple[int, int]:
    """The whole number at `start` of at most `most` digits, and where it ends (`start` where there is none)."""
    i = start
    value = 0
    while i < stop and i - start < most and 48 <= data[i] <= 57:
        value = int(value * 10 + np.int64(data[i]) - 48)
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
def _date(data: ByteArray, start: int, stop: int, order: int) -> tuple[int, int]:
    """The day number of a date such as 2014-04-11, and where it ends (`start` where there is none)."""
    first, i = _digits(data, start, stop, 4)
    if i == start or i >= stop or not (data[i] == 45 or data[i] == 47 or data[i] == 46):
        return 0, start
    second, j = _digits(data, i + 1, stop, 2)
    if j == i + 1 or j >= stop or data[j] != data[i]:
        return 0, start
    third, k = _digits(data, j + 1, stop, 4)
    if k == j + 1:
        return 0, start
    year, month, day = first, second, third
    if order == 1:
        year, month, day = third, second, first
    elif order == 2:
        year, month, day = third, first, second
    if year < 100:
        year += 2000
    if not (1 <= month <= 12 and 1 <= day <= 31 and 1900 <= year <= 2200):
        return 0, start
    return _days(year, month, day), k


@kernel
def _clock(data: ByteArray, start: int, stop: int) -> tuple[int, int]:
    """Nanoseconds since midnight of HH:MM[:SS[.fraction]] [AM|PM], and where it ends (`start`: there is none)."""
    hour, i = _digits(data, start, stop, 2)
    if i == start or i >= stop or data[i] != 58:
        return 0, start
    minute, j = _digits(data, i + 1, stop, 2)
    if j == i + 1:
        return 0, start
    second = 0
    nanos = 0
    if j < stop and data[j] == 58:
        second, k = _digits(data, j + 1, stop, 2)
        if k == j + 1:
            return 0, start
        j = k
        if j < stop and (data[j] == 46 or data[j] == 44 or data[j] == 58):
            scale = 100_000_000
            j += 1
            while j < stop and 48 <= data[j] <= 57:
                nanos += int(scale * (np.int64(data[j]) - 48))
                scale //= 10
                j += 1
    k = j
    while k < stop and data[k] == 32:
        k += 1
    if k + 1 < stop and data[k + 1] | 32 == 109 and (data[k] | 32 == 97 or data[k] | 32 == 112):
        hour = hour % 12 + (12 if data[k] | 32 == 112 else 0)
        j = k + 2
    if hour > 24 or minute > 59 or second > 60:
        return 0, start
    return (hour * 3600 + minute * 60 + second) * 1_000_000_000 + nanos, j


@kernel
def _zone(data: ByteArray, start: int, stop: int) -> tuple[int, int]:
    """Minutes east of Greenwich of "Z", "UTC", "+02:00", "+0200", "+02", and where it ends (`start`: none)."""
    i = start
    while i < stop and data[i] == 32:
        i += 1
    if i >= stop:
        return 0, start
    if data[i] | 32 == 122:
        return 0, i + 1
    if i + 2 < stop and data[i] | 32 == 117 and data[i + 1] | 32 == 116 and data[i + 2] | 32 == 99:
        return 0, i + 3
    if data[i] != 43 and data[i] != 45:
        return 0, start
    hours, j = _digits(data, i + 1, stop, 2)
    if j != i + 3:
        return 0, start
    if j < stop and data[j] == 58:
        j += 1
    minutes, k = _digits(data, j, stop, 2)
    total = hours * 60 + minutes
    return -total if data[i] == 45 else total, k


@kernel
def calendar_ns(
    data: ByteArray,
    spans: IntArray,
    order: int,
    day_ns: IntArray,
    clock_ns: IntArray,
    zones: IntArray,
    valid: BoolArray,
) -> None:
    """Texts of a date, a time of day or both ("2014-04-11T08:38:56.3+02:00") as nanoseconds.

    spans: shape (2, n). order: YEAR_FIRST, DAY_FIRST or MONTH_FIRST. Out, each of shape (n,): day_ns, midnight of
    the date since 1970 (0 without a date); clock_ns, since midnight; zones, minutes east of Greenwich, -10000
    where none is stated; valid, whether the whole text was understood.
    """
    for row in range(valid.shape[0]):
        start, stop = spans[0, row], spans[1, row]
        day_ns[row], clock_ns[row], zones[row] = 0, 0, _NO_ZONE
        days, i = _date(data, start, stop, order)
        if i > start:
            day_ns[row] = days * DAY_NS
            if i < stop and (data[i] == 84 or data[i] == 116):
                i += 1
            while i < stop and (data[i] == 32 or data[i] == 44):
                i += 1
        clock, j = _clock(data, i, stop)
        clock_ns[row] = clock
        zone, k = _zone(data, j, stop)
        if k > j:
            zones[row] = zone
        valid[row] = k == stop and stop > start


def has_zone(zones: IntArray) -> BoolArray:
    """Where `calendar_ns` found a zone. zones: shape (n,)."""
    return zones > _NO_ZONE


def unwrap_days(clock: IntArray, before: int | None) -> IntArray:
    """Times of day as a time that runs on over midnight: each step is the shorter way round the day.

    clock: shape (n,), nanoseconds since midnight. before: the last value of the chunk before, already running on.
    """
    if len(clock) == 0:
        return clock
    first = int(clock[0])
    if before is not None:
        first = before + (first - before + DAY_NS // 2) % DAY_NS - DAY_NS // 2
    steps = (np.diff(clock) + DAY_NS // 2) % DAY_NS - DAY_NS // 2
    return first + np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(steps)])
