"""How a table tells time: the plan for the column or columns that were chosen, their unit and their clock."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from parsers.errors import LogError
from parsers.importer import TAKEN_AS_UTC, ReadOptions
from parsers.table_calendar import MONTH_FIRST, YEAR_FIRST
from parsers.table_cells import (
    DURATION_CELL,
    WITH_DATE,
    NumberStyle,
    is_missing,
)
from parsers.table_fractions import unpadded
from parsers.table_guess import DATENUMS, SERIAL_1970, TICK_NS, are_days, date_order, find_ticks, guess_unit
from parsers.table_months import ZONES
from parsers.table_names import ColumnName
from parsers.table_points import has_other_point
from parsers.table_stamps import DAY_NS
from parsers.units import find_unit

ABSOLUTE_FROM_NS = 630_000_000_000_000_000
ABSOLUTE_TO_NS = 4_100_000_000_000_000_000
"""A stamp between 1990 and 2100 counts from 1970: no logger has run that long."""

_UNIT_TEXTS = {1: "ns", 1000: "us", 1_000_000: "ms", DAY_NS: "days"}

Shape = Literal["number", "duration", "elapsed", "moment", "date", "clock", "text"]
Kind = Literal["decimal", "seconds_nanos", "calendar", "hhmmss", "elapsed"]


@dataclass(frozen=True)
class TimePlan:
    """How a table tells time.

    kind: "decimal", one column of numbers in `unit_ns`; "seconds_nanos", two columns; "calendar", one column, or a
    date's and a time of day's; "hhmmss", one column of numbers that spell a time of day; "elapsed", one of minutes and seconds, or of
    days and a time ("03:00.02", "0 days 00:03:00.02"). columns: their places. order: of a date's parts. absolute: since 1970; else, for a
    calendar, a time of day that runs on over midnight. no_zone: what says that nothing names their time zone, or "". clock: in words. origin_ns: added to each stamp. zero: taken off each
    number before its unit counts. whole_ms: a time of day has milliseconds without zeros before them behind its seconds. guessed: the unit is stated nowhere.
    two_ways: the note on an order that the first rows leave open, or "". other_point: the decimal sign is a point in a table of commas, or a comma in one of points.
    """

    kind: Kind
    columns: tuple[int, ...]
    clock: str
    absolute: bool
    unit_ns: int = 1_000_000_000
    order: int = YEAR_FIRST
    notes: tuple[str, ...] = ()
    origin_ns: int = 0
    guessed: bool = False
    zero: int = 0
    whole_ms: bool = False
    no_zone: str = ""
    two_ways: str = ""
    other_point: bool = False


_SHORT_YEAR = re.compile(r"\d{1,2}\.\d{1,2}\.\d{2}(?!\d)")
_ZONE_NAME = re.compile(r"(?<=\d)\s+([A-Z]{3,5})(?=$|[+-]\d|\s+\d{4}$)")
_WITH_ZONE = re.compile(
    r"(?:[zZ]|(?:UTC|GMT)(?:[+-][\d:]+)?|(?::|\d{8}[tT]\d{2}|\d{8}[tT]\d{4})\d{2}(?:[.,]\d+)?\s*[+-]\d{2}(?::?\d{2})?)$"
)
_GROUPED = re.compile("\\d[\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}]\\d")
HEADER_STAMP = re.compile(r"(?:^|[._/])header[._/]stamp$", re.IGNORECASE)
UNIT_TAIL = re.compile(r"_(?:n?s|[um]s|n?sec|[um]sec|seconds)$", re.IGNORECASE)
_NS_NAMES = re.compile(r"^%time$|rosbag_?timestamp|(?:^|[._/])header[._/]stamp$", re.IGNORECASE)


def no_time(column: ColumnName, cells: Sequence[str], path: Path) -> LogError:
    """The error for a column of texts that are no times."""
    grouped = next((cell for cell in cells if _GROUPED.search(cell)), None)
    if grouped is not None:
        return LogError(
            f'the digits in column "{column.name}" are grouped by no-break blanks, and not by threes ({grouped!r}): not read',
            path=path,
            hint="write the numbers without groups",
        )
    return LogError(
        f'column "{column.name}" holds no time that cogest knows ({first_cell(cells)!r})',
        path=path,
        hint="a time is a number, a date and time (best as ISO 8601), or a time of day",
    )


def plan_for(
    place: int,
    names: Sequence[ColumnName],
    samples: Sequence[Sequence[str]],
    shapes: Sequence[Shape],
    style: NumberStyle,
    options: ReadOptions,
    path: Path,
) -> TimePlan:
    """The plan for a chosen column."""
    shape, column = shapes[place], names[place]
    if shape == "text":
        raise no_time(column, samples[place], path)
    if shape in ("number", "duration"):
        if (options.time_unit or "").lower().startswith("iso"):
            raise LogError(
                f'column "{column.name}" holds numbers, not ISO 8601 times',
                path=path,
                hint="give its unit: s, min, ms, us or ns",
            )
        return _number_plan(place, column, samples[place], style, options, path)
    if shape == "elapsed":
        notes = (
            ()
            if "day" in first_cell(samples[place])
            else (f'column "{column.name}" is read as minutes and seconds',)
        )
        return TimePlan("elapsed", (place,), f'time (column "{column.name}")', False, notes=notes)
    columns = [place]
    partner: Shape | None = {"date": "clock", "clock": "date"}.get(shape)  # type: ignore[assignment]
    if partner is not None:
        columns += [k for k, other in enumerate(shapes) if other == partner][:1]
    if shape == "date" and len(columns) == 1:
        raise LogError(
            f'column "{column.name}" holds dates without a time of day',
            path=path,
            hint="name the time column in the map file: [time] channel",
        )
    return _calendar_plan(tuple(columns), names, samples)


def first_cell(cells: Sequence[str]) -> str:
    """The first cell that holds anything, "" where none does."""
    return next((cell for cell in cells if cell), "")


def _dates(cells: Sequence[str]) -> list[str]:
    """The cells with a date, of a column of dates; a single one among times of day is damage."""
    kept = [cell for cell in cells if not is_missing(cell)]
    dates = [cell for cell in kept if WITH_DATE.match(cell)]
    return dates if len(dates) > 0.5 * len(kept) else []


def _calendar_plan(
    columns: tuple[int, ...], names: Sequence[ColumnName], samples: Sequence[Sequence[str]]
) -> TimePlan:
    cells = [cell for k in columns for cell in samples[k] if not is_missing(cell)]
    dates = [cell for k in columns for cell in _dates(samples[k])]
    said = " and ".join(f'"{names[k].name}"' for k in columns)
    clock = f"column{'s' if len(columns) > 1 else ''} {said}"
    whole_ms = any(unpadded([cell for cell in samples[k] if not is_missing(cell)]) for k in columns)
    unpadded_note = (
        f"the digits behind the seconds in {clock} are read as whole milliseconds (08:53:20.43 as 20.043 s): as decimals the "
        "times would go back again and again"
    )
    spelt = [unpadded_note] if whole_ms else []
    if not dates:
        note = f"{clock} holds the time of day without a date: taken as a time that runs on over midnight"
        return TimePlan(
            "calendar", columns, f"time of day ({clock})", False, notes=(note, *spelt), whole_ms=whole_ms
        )
    notes = spelt
    order, two_ways = YEAR_FIRST, ""
    if not re.match(r"\d{4}", dates[0]):
        order, note, left_open = date_order(dates, cells)
        notes += [note] if note else []
        two_ways = note if left_open else ""
        if _SHORT_YEAR.match(dates[0]):
            parts = "month, day" if order == MONTH_FIRST else "day, month"
            notes.append(f"dates such as {dates[0].split()[0]!r} are taken as {parts}, year from 2000 on")
    named = {
        found[1] for cell in cells if (found := _ZONE_NAME.search(cell)) and found[1] not in ("AM", "PM")
    }
    unknown = sorted(named - set(ZONES))
    zoned = not unknown and (bool(named) or any(_WITH_ZONE.search(cell) for cell in cells))
    no_zone = f"the times in {clock} state no time zone: {TAKEN_AS_UTC}"
    if unknown:
        no_zone = (
            f"the times in {clock} state a time zone that has no one meaning ({unknown[0]}): {TAKEN_AS_UTC}"
        )
    return TimePlan(
        "calendar", columns, f"{clock}, {'UTC' if zoned else 'taken as UTC'}", True, order=order, notes=tuple(notes),
        whole_ms=whole_ms, two_ways=two_ways, no_zone="" if zoned else no_zone,
    )  # fmt: skip


def is_absolute(cells: Sequence[str], style: NumberStyle, unit_ns: int) -> bool:
    """Whether a column's first number, in its unit, is a date since 1970."""
    value = next((v for cell in cells if (v := style.value(cell)) is not None), 0.0)
    return ABSOLUTE_FROM_NS <= value * unit_ns <= ABSOLUTE_TO_NS


def _number_plan(
    place: int, column: ColumnName, cells: Sequence[str], style: NumberStyle, options: ReadOptions, path: Path
) -> TimePlan:
    """The plan for a column of numbers, whose decimal sign may be another than the table's."""
    unit = find_unit(options.time_unit or column.unit, "time")
    if not has_other_point(cells, style, seconds=unit is None or unit.scale >= 1):
        return _decimal_plan(place, column, cells, style, options, path)
    own = NumberStyle("." if style.decimal == "," else ",")
    plan = _decimal_plan(place, column, cells, own, options, path)
    said = f'the decimal sign in column "{column.name}" is {own.decimal!r}, in the others {style.decimal!r}'
    return replace(plan, other_point=True, notes=(*plan.notes, said))


def _decimal_plan(
    place: int, column: ColumnName, cells: Sequence[str], style: NumberStyle, options: ReadOptions, path: Path
) -> TimePlan:
    """The plan for a column of numbers: its unit as stated, else by magnitude, which is then said."""
    behind = next((found["unit"] for cell in cells if (found := DURATION_CELL.fullmatch(cell))), None)
    stated = behind or options.time_unit or column.unit
    if stated is None and (tail := UNIT_TAIL.search(column.name)):
        stated = tail.group().strip("_")
    if stated is None and _NS_NAMES.search(column.name):
        stated = "ns"
    unit = find_unit(stated, "time")
    if options.time_unit and unit is None:
        raise LogError(
            f"unit {options.time_unit!r} of the time column is no unit of time",
            path=path,
            hint="use s, min, ms, us, ns, iso8601 or hhmmss",
        )
    notes: tuple[str, ...] = ()
    if unit is not None:
        unit_ns = round(unit.scale * 1e9)
    else:
        values = [v for cell in cells if (v := style.value(cell)) is not None]
        if are_days(values, DATENUMS):
            raise LogError(
                f'column "{column.name}" holds days since the year 0 (MATLAB\'s datenum): not read',
                path=path,
                hint="write it as seconds, (t - t(1)) * 86400, or as ISO 8601 texts",
            )
        ticks = find_ticks(values)
        if ticks is not None:
            zero, what = ticks
            note = f'column "{column.name}" states no unit: taken as {what}, by the size of its values'
            clock = f'time (column "{column.name}", since 1970)'
            return TimePlan("decimal", (place,), clock, True, TICK_NS, notes=(note,), guessed=True, zero=zero)
        unit_ns, why = guess_unit(values)
        text = _UNIT_TEXTS.get(unit_ns, "s")
        advice = "" if unit_ns == DAY_NS else "; state it in the map file: [time] unit"
        notes = (f'column "{column.name}" states no unit: taken as {text}, {why}{advice}',)
    absolute = unit_ns != DAY_NS and is_absolute(cells, style, unit_ns)
    origin_ns = 0
    if unit is None and unit_ns == DAY_NS:
        # a spreadsheet's dates count days from 1899-12-30
        absolute, origin_ns = True, -SERIAL_1970 * DAY_NS
    stamp = "header stamp" if HEADER_STAMP.search(column.name) else "time"
    clock = f'{stamp} (column "{column.name}"{", since 1970" if absolute else ""})'
    return TimePlan(
        "decimal", (place,), clock, absolute, unit_ns, notes=notes, origin_ns=origin_ns, guessed=unit is None
    )
