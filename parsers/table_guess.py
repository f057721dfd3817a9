"""The unit of time stamps that state none, by their size and steps, and the order of a date's parts."""

from __future__ import annotations

import re
import statistics
from collections.abc import Sequence
from datetime import date
from itertools import pairwise

from parsers.table_calendar import DAY_FIRST, MONTH_FIRST
from parsers.table_cells import WITH_DATE
from parsers.table_stamps import DAY_NS

_HALF_DAY = re.compile(r"\d\s*[AaPp][Mm]\b")

SERIAL_DATES = (20_000.0, 80_000.0)
SERIAL_1970 = 25_569
DATENUMS = (690_000.0, 800_000.0)
"""Days since 1899-12-30 and since the year 0, from about 1955 to 2119 and 1889 to 2190."""
_DAY_STEP = 1.5e-4
"""Days: seconds in steps as small would be a log of more than 6 kHz."""

TICK_NS = 100
_TICKS = (
    (116_444_736_000_000_000, 1.25e17, 1.42e17, "100 ns since 1601 (Windows' FILETIME)"),
    (621_355_968_000_000_000, 6.3e17, 6.5e17, "100 ns since the year 1 (.NET's ticks)"),
)
"""The number of 1970, and what numbers the years 1997 to 2050 and 1997 to 2060 have: nanoseconds since 1970 of so small
numbers would be of 1973 and 1990."""

_SHUFFLED = 0.2
"""Share of rows that go back from which on they are in no order, and their steps tell nothing."""

_DENSE_S, _SPARSEST_S = 2.0, 60.0
_LOGGED_S = (946_684_800.0, 2_208_988_800.0)
"""Rows of a drive are seconds apart at most, a tracker's up to a minute. The years 2000 to 2039, since 1970."""


def are_days(values: Sequence[float], span: tuple[float, float]) -> bool:
    """Whether numbers are dates counted in days: in `span`, and in steps of less than a quarter of a minute."""
    steps = [b - a for a, b in pairwise(values) if b > a]
    return (
        bool(steps)
        and span[0] < min(values) <= max(values) < span[1]
        and statistics.median(steps) < _DAY_STEP
    )


def find_ticks(values: Sequence[float]) -> tuple[int, str] | None:
    """Of time stamps that count 100 ns: the number that stands for 1970, and what they are in words; None for others."""
    if not values:
        return None
    size = statistics.median(values)
    return next(((zero, what) for zero, least, most, what in _TICKS if least <= size <= most), None)


def guess_unit(values: Sequence[float]) -> tuple[int, str]:
    """The unit, in ns, of time stamps that state none; and the reason, for the import record."""
    if not values:
        return 1_000_000_000, "as most logs are"
    size = statistics.median(abs(value) for value in values)
    steps = [b - a for a, b in pairwise(values) if b > a]
    if sum(b < a for a, b in pairwise(values)) > _SHUFFLED * len(values):
        steps = [b - a for a, b in pairwise(sorted(values)) if b > a]
    step = statistics.median(steps) if steps else 0.0
    for least, unit_ns in ((1e17, 1), (1e14, 1000), (1e11, 1_000_000), (3e8, 1_000_000_000)):
        if size < least:
            continue
        apart = step * unit_ns / 1e9
        if not _is_wall_clock(size * unit_ns / 1e9, apart):
            break
        rows = f", with rows {apart:g} s apart" if apart > _DENSE_S else ""
        return unit_ns, f"since values near {size:.4g} are then times since 1970{rows}"
    if are_days(values, SERIAL_DATES):
        return DAY_NS, f"since values near {size:.0f} with so small steps are a spreadsheet's dates"
    for least, unit_ns in ((2e6, 1), (2e3, 1000), (2.0, 1_000_000)):
        if step >= least:
            return unit_ns, f"since its steps are {step:g}"
    return 1_000_000_000, f"since its steps are {step:g}"


def _is_wall_clock(moment_s: float, apart_s: float) -> bool:
    """Whether stamps of some size (seconds since 1970) and usual step can be a wall clock, and are no counter's.

    Rows minutes apart are no drive. A counter since the power came on has any size: rows seconds apart are a wall clock's
    where logs are recorded, in this century's first decades.
    """
    if apart_s <= _DENSE_S:
        return True
    return apart_s <= _SPARSEST_S and _LOGGED_S[0] <= moment_s < _LOGGED_S[1]


_WORDS = {DAY_FIRST: "day, month, year", MONTH_FIRST: "month, day, year"}


def date_order(dates: Sequence[str], cells: Sequence[str]) -> tuple[int, str, bool]:
    """Whether the day or the month comes first, a note where the dates alone do not say it, and whether they leave it open.

    dates: cells that begin with one, in the log's order. cells: those of dates and times of day.
    """
    named = WITH_DATE.match(dates[0])
    if named is None or re.search(r"[^\W\d_]{3}", named.group()):
        return DAY_FIRST, "", False
    parts = [tuple(int(part) for part in re.findall(r"\d+", cell)[:3]) for cell in dates]
    if max(p[1] for p in parts) > 12:
        return MONTH_FIRST, "", False
    if max(p[0] for p in parts) > 12 or "." in dates[0][:6]:
        return DAY_FIRST, "", False
    two_ways = f"dates such as {dates[0]!r} can be read in two ways: taken as"
    order = _running_on(parts)
    if order is not None:
        return order, f"{two_ways} {_WORDS[order]}, under which the times run on", False
    if "/" in dates[0][:6] and any(_HALF_DAY.search(cell) for cell in cells):
        return MONTH_FIRST, f"{two_ways} {_WORDS[MONTH_FIRST]}, as is usual beside AM and PM", True
    return DAY_FIRST, f"{two_ways} {_WORDS[DAY_FIRST]}", True


def _running_on(parts: Sequence[tuple[int, ...]]) -> int | None:
    """The order under which dates go on without leaps of months, as those of a drive over midnight do; None where neither is better."""
    steps = [b for a, b in pairwise(parts) if a != b]
    spans = {}
    for order, (day, month) in ((DAY_FIRST, (0, 1)), (MONTH_FIRST, (1, 0))):
        try:
            days = [date(p[2], p[month], p[day]).toordinal() for p in (parts[0], *steps)]
        except ValueError:
            continue
        back = sum(b < a for a, b in pairwise(days))
        spans[order] = (back, max(days) - min(days))
    if len(spans) < 2 or spans[DAY_FIRST] == spans[MONTH_FIRST]:
        return next(iter(spans)) if len(spans) == 1 else None
    return min(spans, key=lambda order: spans[order])
