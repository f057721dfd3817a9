"""The moment of stamp 0 that a table's head states above the column names, as MoTeC's and AiM's exports do."""

from __future__ import annotations

import re
from datetime import datetime
from itertools import takewhile

from parsers.table_cells import split_cells
from parsers.table_months import MONTHS
from parsers.table_rows import RowRules

_DATES, _TIMES = frozenset({"log date", "date"}), frozenset({"log time", "time"})
_MOST_LINES = 60
_CLOCK = re.compile(r"(\d{1,2}):(\d\d)(?::(\d\d)(?:[.,](\d{1,6}))?)?\s*([AaPp][Mm])?")
_ISO = re.compile(r"(\d{4})[-/.](\d{1,2})[-/.](\d{1,2})")
_NUMBERS = re.compile(r"(\d{1,2})[-/.](\d{1,2})[-/.](\d{4})")
_MONTH = {name: k + 1 for k, names in enumerate(MONTHS) for name in names}


def stated_start(head: str, rules: RowRules) -> tuple[datetime, str] | None:
    """The moment that lines such as "Log Date","16/03/2024" and "Log Time","14:05:22" state, and what is said of it; None without both."""
    said: dict[str, str] = {}
    for line in head.splitlines()[:_MOST_LINES]:
        cells = split_cells(line, rules)
        key = cells[0].casefold().rstrip(":") if len(cells) > 1 else ""
        kind = "date" if key in _DATES else "time" if key in _TIMES else ""
        if kind and cells[1]:
            # a date that stands in no quotes may hold the table's separator
            value = takewhile(bool, cells[1:]) if kind == "date" else cells[1:2]
            said.setdefault(kind, ", ".join(value))
    clock = _CLOCK.fullmatch(said.get("time", ""))
    day = _day(said.get("date", ""), american=clock is not None and bool(clock[5]))
    if clock is None or day is None:
        return None
    hour = int(clock[1]) % 12 + (12 if clock[5].lower() == "pm" else 0) if clock[5] else int(clock[1])
    micro = int((clock[4] or "0").ljust(6, "0"))
    try:
        moment = datetime(*day, hour, int(clock[2]), int(clock[3] or 0), micro)
    except ValueError:
        return None
    return moment, f"the log's head says that it begins at {said['time']} on {said['date']}"


def _day(text: str, *, american: bool) -> tuple[int, int, int] | None:
    """Year, month and day; of numbers the day comes first unless that is none, or the time has AM or PM."""
    if found := _ISO.match(text):
        return int(found[1]), int(found[2]), int(found[3])
    if found := _NUMBERS.match(text):
        day, month, year = (int(part) for part in found.groups())
        if month > 12 or (american and day <= 12 and "/" in text):
            day, month = month, day
        return year, month, day
    words = [word[:3].casefold() for word in re.findall(r"[^\W\d_]+", text)]
    month = next((_MONTH[word] for word in reversed(words) if word in _MONTH), 0)
    years, days = re.search(r"\b(\d{4})\b", text), re.search(r"\b(\d{1,2})\b", text)
    return (int(years[1]), month, int(days[1])) if month and years and days else None
