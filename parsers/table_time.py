"""Find a table's time: which column or columns, in which unit, on which clock."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from pathlib import Path

from parsers.errors import LogError
from parsers.importer import ReadOptions
from parsers.table_cells import (
    CALENDAR_CELL,
    CLOCK_CELL,
    COMPACT_CELL,
    DATE_CELL,
    DURATION_CELL,
    ELAPSED_CELL,
    NumberStyle,
    is_missing,
)
from parsers.table_names import ColumnName
from parsers.table_points import has_other_point
from parsers.table_time_plan import (
    HEADER_STAMP,
    UNIT_TAIL,
    Shape,
    TimePlan,
    first_cell,
    is_absolute,
    no_time,
    plan_for,
)
from parsers.units import find_unit

_TIME_WORDS = """
    time t timestamp timestamps ts times zeit zeitstempel temps tiempo tempo utc utctime timeutc gpstime timegps unixtime
    timeunix unixtimestamp epoch epochtime posixtime %time datetime dateandtime date datum elapsed elapsedtime timeelapsed
    reltime relativetime rectime recordtime logtime logtimestamp systemtime systime sampletime timesec timesecs
    timeseconds timens timems timeus rosbagtimestamp rosbagtime bagtime runtime clock localtime measurementtime testtime
    gpsutctime xtime timestampns timestampms timestampus timestamputc utctimestamp gpstimestamp hosttime secondselapsed elapsedseconds
    elapseds timeelapseds datenum exceltime serialdate xvalue
"""
_TIME_NAMES = frozenset(_TIME_WORDS.split())
_OF_OTHER_SCRIPTS = frozenset(
    [
        "時間",
        "時刻",
        "日時",
        "経過時間",
        "計測時間",
        "測定時間",
        "記録時間",
        "タイム",
        "时间",
        "时刻",
        "时间戳",
        "время",
    ]
)
_STAMP_SECONDS = re.compile(r"^(?P<head>(?:.*(?:stamp|time)[._/])?)(?:sec(?:ond)?s?|tv_sec)$", re.IGNORECASE)
_STAMP_NANOS = re.compile(
    r"^(?P<head>(?:.*(?:stamp|time)[._/])?)(?:n(?:ano)?sec(?:ond)?s?|tv_nsec)$", re.IGNORECASE
)


def shape_of(cells: Sequence[str], style: NumberStyle, count: int | None = None) -> Shape:
    """What the sampled cells of a column are: for most of those that hold anything. count: of the numbers, where it is known."""
    if cells and (style.count(cells) if count is None else count) == len(cells):
        return "number"
    kept = [cell for cell in cells if not is_missing(cell)]
    if not kept:
        return "text"
    shapes: tuple[tuple[Shape, re.Pattern[str]], ...] = (
        ("number", style.pattern),
        ("duration", DURATION_CELL),
        ("moment", CALENDAR_CELL),
        ("date", DATE_CELL),
        ("clock", CLOCK_CELL),
        ("elapsed", ELAPSED_CELL),
    )
    for shape, pattern in shapes:
        if sum(pattern.fullmatch(cell) is not None for cell in kept) > 0.5 * len(kept):
            return shape
    return "text"


def find_time(
    names: Sequence[ColumnName],
    samples: Sequence[Sequence[str]],
    style: NumberStyle,
    options: ReadOptions,
    path: Path,
    counts: Sequence[int] | None = None,
) -> TimePlan:
    """Find the time column. samples: for each column its first cells as text; counts: how many of them are numbers, where that is known.

    Raises LogError where there is none, or the one that the map file names is not there or holds no time.
    """
    if counts is None:
        counts = [style.count(cells) for cells in samples]
    shapes = [shape_of(cells, style, count) for cells, count in zip(samples, counts, strict=True)]
    for k, cells in enumerate(samples):
        if shapes[k] == "text" and is_called_time(names[k]) and has_other_point(cells, style, seconds=False):
            shapes[k] = "number"
        if shapes[k] == "number" and _is_compact(names[k], cells, options):
            shapes[k] = "moment"
    if options.time_channel is not None:
        place = _named_column(names, options.time_channel, path)
        return plan_for(place, names, samples, shapes, style, options, path)
    pair = _stamp_pair(names, samples, shapes)
    if pair is not None:
        return TimePlan(
            "seconds_nanos",
            pair,
            f'header stamp (columns "{names[pair[0]].name}" and "{names[pair[1]].name}")',
            is_absolute(samples[pair[0]], style, 1_000_000_000),
        )
    ranked = sorted(
        (rank, place)
        for place in range(len(names))
        if (rank := _rank(names[place], samples[place], shapes[place])) is not None
    )
    if not ranked:
        called = next((k for k, c in enumerate(names) if is_called_time(c) and first_cell(samples[k])), None)
        if called is not None and shapes[called] == "text":
            raise no_time(names[called], samples[called], path)
        cells = [] if called is None else [cell for cell in samples[called] if cell.strip()]
        if called is not None and len(cells) > 1 and len({*cells}) == 1:
            raise LogError(
                f'column "{names[called].name}" stands still at {cells[0].strip()[:40]!r}: no time',
                path=path,
                hint="name another in the map file: [time] channel",
            )
        raise LogError(
            f"no time column among {_listed(names)}",
            path=path,
            hint='name it in the map file: [time] channel = "…", unit = "s" (or min, ms, us, ns, iso8601, hhmmss)',
        )
    return plan_for(ranked[0][1], names, samples, shapes, style, options, path)


def _is_compact(column: ColumnName, cells: Sequence[str], options: ReadOptions) -> bool:
    """Whether a column of numbers without a unit spells dates and times of day: 20251009085320.000."""
    unit = options.time_unit or column.unit or UNIT_TAIL.search(column.name)
    if unit and str(unit).lower() != "iso8601":
        return False
    kept = [cell for cell in cells if not is_missing(cell)]
    return bool(kept) and all(COMPACT_CELL.fullmatch(cell) for cell in kept)


def may_be_time(column: ColumnName, options: ReadOptions) -> bool:
    """Whether a column of numbers can be the time as far as its name says: for tables whose cells cost something to read."""
    wanted = (options.time_channel or "").strip().lower()
    header = column.header or column.name
    return (
        bool(wanted and wanted in (column.name.lower(), column.header.lower()))
        or bool(_STAMP_NANOS.match(header) or _STAMP_SECONDS.match(header))
        or _rank(column, ("0", "1"), "number") is not None
    )


def _listed(names: Sequence[ColumnName]) -> str:
    shown = ", ".join(f'"{column.name}"' for column in names[:8])
    return f"the {len(names)} columns {shown}{' …' if len(names) > 8 else ''}"


def _named_column(names: Sequence[ColumnName], wanted: str, path: Path) -> int:
    """The place of the column that the map file names: by name, else by its whole header, else without case."""
    for match in (
        [k for k, c in enumerate(names) if c.name == wanted],
        [k for k, c in enumerate(names) if c.header == wanted],
        [k for k, c in enumerate(names) if wanted.strip().lower() in (c.name.lower(), c.header.lower())],
    ):
        if match:
            return match[0]
    near = difflib.get_close_matches(wanted, [c.name for c in names], n=1)
    hint = f'did you mean "{near[0]}"?' if near else f"it has {_listed(names)}"
    raise LogError(f'no column "{wanted}", which the map file names as the time', path=path, hint=hint)


def _stamp_pair(
    names: Sequence[ColumnName], samples: Sequence[Sequence[str]], shapes: Sequence[Shape]
) -> tuple[int, int] | None:
    """Two columns "…stamp.secs" and "…stamp.nsecs" that move."""
    nanos = {
        m["head"].lower(): k for k, c in enumerate(names) if (m := _STAMP_NANOS.match(c.header or c.name))
    }
    for k, column in enumerate(names):
        match = _STAMP_SECONDS.match(column.header or column.name)
        other = nanos.get(match["head"].lower()) if match else None
        if (
            other is not None
            and shapes[k] == shapes[other] == "number"
            and not (_stands(samples[k]) and _stands(samples[other]))
        ):
            return k, other
    return None


def _stands(cells: Sequence[str]) -> bool:
    return len(cells) > 1 and len({cell for cell in cells if cell}) == 1


def _plain(column: ColumnName) -> str:
    """A column's name without its unit, in small letters and digits alone."""
    return re.sub(r"[^a-z0-9%]+", "", UNIT_TAIL.sub("", column.name.strip().lower()))


def is_called_time(column: ColumnName) -> bool:
    """Whether a column's name is one of those that a time has."""
    return _plain(column) in _TIME_NAMES or column.name.strip().casefold() in _OF_OTHER_SCRIPTS


def _rank(column: ColumnName, cells: Sequence[str], shape: Shape) -> int | None:
    """How well a column stands for the time: lower is better, None not at all."""
    if shape == "text" or (_stands(cells) and shape != "date"):
        return None
    name = column.name.strip()
    if HEADER_STAMP.search(name):
        return 0
    if name == "time_ns":
        return 1
    called = is_called_time(column)
    if shape == "moment" and COMPACT_CELL.fullmatch(first_cell(cells)):
        # it is often a second clock, of whole seconds
        return 4 if called else 6
    if shape in ("moment", "clock", "duration") and called:
        return 2
    if called and not (shape == "number" and _plain(column) in ("date", "datum")):
        return 4 if shape in ("date", "elapsed") else 3
    if shape in ("moment", "duration"):
        return 5
    if (
        shape == "number"
        and find_unit(column.unit, "time") is not None
        and re.search("time|stamp", name, re.IGNORECASE)
    ):
        return 6
    return 7 if shape in ("clock", "elapsed") else None
