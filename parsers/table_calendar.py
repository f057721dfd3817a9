"""Kernels that turn dates with times of day into nanoseconds, as logs and spreadsheets of several countries write them."""

from __future__ import annotations

from parsers.jit import kernel
from parsers.table_bytes import byte_at
from parsers.table_months import month_at, sign_at, word_at_letters, zone_named
from parsers.table_stamps import DAY_NS, digits_at, fraction_at

YEAR_FIRST, DAY_FIRST, MONTH_FIRST = 0, 1, 2
"""Order of the parts of a date."""
WHOLE_MS = 4
"""Added to the order: what stands behind a second are whole milliseconds without zeros before them, 43 of 08:53:20.43."""

_SECOND_NS = 1_000_000_000
_MINUTE_NS = 60 * _SECOND_NS


@kernel
def _day_number(year: int, month: int, day: int) -> tuple[bool, int]:
    """Days from 1970-01-01 to a date of the Gregorian calendar; False where there is no such date."""
    if year < 100:
        year += 2000
    if not (1 <= month <= 12 and 1 <= day <= 31 and 1900 <= year <= 2200):
        return False, 0
    y = year - 1 if month <= 2 else year
    era = y // 400
    of_era = y - era * 400
    month_from_march = (month + 9) % 12
    day_of_year = (153 * month_from_march + 2) // 5 + day - 1
    return True, era * 146097 + of_era * 365 + of_era // 4 - of_era // 100 + day_of_year - 719468


@kernel
def _of_day(hour: int, minute: int, second: int, nanos: int) -> tuple[bool, int]:
    """Nanoseconds since midnight; False where there is no such time."""
    if hour > 24 or minute > 59 or second > 60:
        return False, 0
    return True, (hour * 3600 + minute * 60 + second) * _SECOND_NS + nanos


@kernel
def _date(start: int, stop: int, order: int) -> tuple[int, int]:
    """The day number of a date in numbers such as 2014-04-11, and where it ends (`start` where there is none)."""
    first, i = digits_at(start, stop, 4)
    if i == start or i >= stop or not (byte_at(i) == 45 or byte_at(i) == 47 or byte_at(i) == 46):
        return 0, start
    second, j = digits_at(i + 1, stop, 2)
    if j == i + 1 or j >= stop or byte_at(j) != byte_at(i):
        return 0, start
    third, k = digits_at(j + 1, stop, 4)
    if k == j + 1:
        return 0, start
    year, month, day = first, second, third
    if order == 1:
        year, month, day = third, second, first
    elif order == 2:
        year, month, day = third, first, second
    valid, number = _day_number(year, month, day)
    return number, k if valid else start


@kernel
def _clock(start: int, stop: int, whole_ms: bool) -> tuple[int, int]:
    """Nanoseconds since midnight of HH:MM[:SS[.fraction]] [AM|PM], and where it ends (`start`: there is none)."""
    hour, i = digits_at(start, stop, 2)
    if i == start or i >= stop or byte_at(i) != 58:
        return 0, start
    minute, j = digits_at(i + 1, stop, 2)
    if j == i + 1:
        return 0, start
    second = 0
    nanos = 0
    if j < stop and byte_at(j) == 58:
        second, k = digits_at(j + 1, stop, 2)
        if k == j + 1:
            return 0, start
        j = k
        if j < stop and (byte_at(j) == 46 or byte_at(j) == 44 or byte_at(j) == 58):
            nanos, j = fraction_at(j + 1, stop, whole_ms)
    k = _skip(j, stop, 32, 32)
    if k + 1 < stop and byte_at(k + 1) | 32 == 109 and (byte_at(k) | 32 == 97 or byte_at(k) | 32 == 112):
        hour = hour % 12 + (12 if byte_at(k) | 32 == 112 else 0)
        j = k + 2
    valid, clock = _of_day(hour, minute, second, nanos)
    return clock, j if valid else start


@kernel
def _dotted_clock(start: int, stop: int, whole_ms: bool) -> tuple[int, int, bool]:
    """Nanoseconds since midnight of HH.MM.SS[,fraction], where it ends (`start`: there is none), and whether it has a fraction."""
    hour, i = digits_at(start, stop, 2)
    if i == start or i >= stop or byte_at(i) != 46:
        return 0, start, False
    minute, j = digits_at(i + 1, stop, 2)
    if j != i + 3 or j >= stop or byte_at(j) != 46:
        return 0, start, False
    second, k = digits_at(j + 1, stop, 2)
    nanos = 0
    end = k
    if k < stop and (byte_at(k) == 44 or byte_at(k) == 46 or byte_at(k) == 58):
        nanos, end = fraction_at(k + 1, stop, whole_ms)
    valid, clock = _of_day(hour, minute, second, nanos)
    return clock, end if valid and k == j + 3 else start, end > k


@kernel
def _skip(start: int, stop: int, one: int, other: int) -> int:
    """Where something else than two characters begins."""
    i = start
    while i < stop and (byte_at(i) == one or byte_at(i) == other):
        i += 1
    return i


@kernel
def _offset(start: int, stop: int, fewest: int) -> tuple[int, int]:
    """Minutes east of Greenwich of "+02:00", "+0200", "+02", and where it ends (`start`: none). fewest: digits of the hours."""
    if start >= stop or (byte_at(start) != 43 and byte_at(start) != 45):
        return 0, start
    hours, j = digits_at(start + 1, stop, 2)
    if j < start + 1 + fewest:
        return 0, start
    if j < stop and byte_at(j) == 58:
        j += 1
    minutes, k = digits_at(j, stop, 2)
    total = hours * 60 + minutes
    return -total if byte_at(start) == 45 else total, k


@kernel
def _zone(start: int, stop: int) -> tuple[int, int]:
    """Minutes east of Greenwich of "Z", "UTC", "CET", "GMT+1", "+02:00", and where it ends (`start`: none). Names that nobody
    knows are taken for Greenwich's."""
    i = _skip(start, stop, 32, 32)
    minutes, j = _offset(i, stop, 2)
    if j == i:
        minutes, j = zone_named(i, stop)
        if j == i:
            return 0, start
        more, k = _offset(j, stop, 1)
        if k > j and j == i + 3:
            return minutes + more, k
    return minutes, j


@kernel
def _plain(start: int, stop: int, order: int, whole_ms: bool) -> tuple[int, int, int]:
    """Day number and nanoseconds since midnight of 2014-04-11 08:38:56.3, of a date or a time of day alone, and where it ends."""
    day, i = _date(start, stop, order)
    if i > start:
        if i < stop and (byte_at(i) == 84 or byte_at(i) == 116):
            i += 1
        i = _skip(i, stop, 32, 44)
    clock, j = _clock(i, stop, whole_ms)
    if j == i > start:
        clock, j, _ = _dotted_clock(i, stop, whole_ms)
    return day, clock, j


@kernel
def _basic(start: int, stop: int, whole_ms: bool) -> tuple[int, int, int]:
    """Day number and nanoseconds since midnight of 20140411T083856.3, 20140411T0838, 20140411 08:38:56.3 or 20140411083856300, and
    where it ends (`start`: none)."""
    date, i = digits_at(start, stop, 8)
    if i != start + 8 or i >= stop:
        return 0, 0, start
    valid, day = _day_number(date // 10000, date // 100 % 100, date % 100)
    c = byte_at(i)
    joined = 48 <= c <= 57
    if not (joined or c | 32 == 116 or c == 32 or c == 45 or c == 95) or not valid:
        return 0, 0, start
    if not joined:
        i += 1
        clock, j = _clock(i, stop, whole_ms)
        if j > i:
            return day, clock, j
    number, j = digits_at(i, stop, 6)
    if j == i + 4 and c | 32 == 116:
        number *= 100
    elif j != i + 6:
        return 0, 0, start
    nanos = 0
    if j == i + 6 and j < stop and (byte_at(j) == 46 or byte_at(j) == 44):
        nanos, j = fraction_at(j + 1, stop, whole_ms)
    elif joined:
        nanos, j = fraction_at(j, stop, False)
    valid, clock = _of_day(number // 10000, number // 100 % 100, number % 100, nanos)
    return day, clock, j if valid else start


@kernel
def _gap(start: int, stop: int) -> int:
    """Where blanks, points, commas, hyphens and slashes end."""
    i = start
    while i < stop and (byte_at(i) == 32 or 44 <= byte_at(i) <= 47):
        i += 1
    return i


@kernel
def _behind_weekday(start: int, stop: int) -> int:
    """Where a date with a month's name begins, behind the day of the week: "Sat Mar 16", "Sat, 16 Mar", "mar. 16 mars"."""
    word = word_at_letters(start, stop)
    if word == start:
        return start
    month, _ = month_at(start, stop)
    i = _gap(word, stop)
    if month == 0 or month_at(i, stop)[0] > 0:
        return i
    _, j = digits_at(i, stop, 2)
    return i if month_at(_gap(j, stop), stop)[0] > 0 else start


@kernel
def _by_name(start: int, stop: int, whole_ms: bool) -> tuple[int, int, int]:
    """Day number and nanoseconds since midnight of 16. March 2024 14:05:22, Mar 16, 2024 14:05:22 or Sat Mar 16 14:05:22 2024, and
    where it ends (`start`: none)."""
    i = _behind_weekday(start, stop)
    month, j = month_at(i, stop)
    clock = zone = 0
    early = False
    if month > 0:
        day, i = digits_at(_gap(j, stop), stop, 2)
        i = _gap(i, stop)
        clock, j = _clock(i, stop, whole_ms)
        early = j > i
        if early:
            zone, j = _zone(j, stop)
        year, i = digits_at(_skip(j, stop, 32, 32), stop, 4)
    else:
        day, j = digits_at(i, stop, 4)
        month, j = month_at(_gap(j, stop), stop)
        year, i = digits_at(_gap(j, stop), stop, 4)
    if day > 31:
        year, day = day, year
    valid, number = _day_number(year, month, day)
    if not valid or month == 0 or year < 100:
        return 0, 0, start
    if not early:
        if i < stop and byte_at(i) == 84:
            i += 1
        j = _skip(i, stop, 32, 44)
        clock, i = _clock(j, stop, whole_ms)
        if i == j:
            clock, i, _ = _dotted_clock(j, stop, whole_ms)
    return number, clock - zone * _MINUTE_NS, i


@kernel
def _by_signs(start: int, stop: int, whole_ms: bool) -> tuple[int, int, int]:
    """Day number and nanoseconds since midnight of a date with the signs of year, month and day behind its numbers, as in Japan, and
    where it ends (`start`: none)."""
    year, i = digits_at(start, stop, 4)
    first, i = sign_at(i, stop)
    month, i = digits_at(i, stop, 2)
    second, i = sign_at(i, stop)
    day, i = digits_at(i, stop, 2)
    third, i = sign_at(i, stop)
    valid, number = _day_number(year, month, day)
    if not (first == 1 and second == 2 and third == 3 and valid):
        return 0, 0, start
    i = _skip(i, stop, 32, 32)
    clock, j = _clock(i, stop, whole_ms)
    if j > i or i == stop:
        return number, clock, j
    hour, i = digits_at(i, stop, 2)
    first, i = sign_at(i, stop)
    minute, i = digits_at(i, stop, 2)
    second, i = sign_at(i, stop)
    if first != 4 or second != 5:
        return 0, 0, start
    seconds = nanos = 0
    if i < stop:
        seconds, i = digits_at(i, stop, 2)
        if i < stop and (byte_at(i) == 46 or byte_at(i) == 44):
            nanos, i = fraction_at(i + 1, stop, whole_ms)
        third, i = sign_at(i, stop)
        if third != 6:
            return 0, 0, start
    valid, clock = _of_day(hour, minute, seconds, nanos)
    return number, clock, i if valid else start


@kernel
def calendar_stamp(start: int, stop: int, order: int) -> tuple[bool, int, int]:
    """A date, a time of day or both ("2014-04-11T08:38:56.3+02:00"): midnight of the date since 1970 (0 without a
    date), and the nanoseconds from there, at Greenwich.

    order: YEAR_FIRST, DAY_FIRST or MONTH_FIRST, and WHOLE_MS. False where the text was not understood to its end.
    """
    whole_ms = order >= WHOLE_MS
    day, clock, j = _plain(start, stop, order % WHOLE_MS, whole_ms)
    zone, k = _zone(j, stop)
    if k != stop or j == start:
        day, clock, j = _basic(start, stop, whole_ms)
        zone, k = _zone(j, stop)
    if k != stop or j == start:
        day, clock, j = _by_name(start, stop, whole_ms)
        zone, k = _zone(j, stop)
    if k != stop or j == start:
        day, clock, j = _by_signs(start, stop, whole_ms)
        zone, k = _zone(j, stop)
    if k != stop or j == start:
        # with no fraction it is a date
        day = 0
        clock, j, fraction = _dotted_clock(start, stop, whole_ms)
        zone, k = _zone(j, stop)
        j = j if fraction else start
    return k == stop and j > start, day * DAY_NS, clock - zone * _MINUTE_NS
