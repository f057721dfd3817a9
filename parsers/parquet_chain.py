"""Parquet files of one folder: files with the same columns are parts of one table, others are tables beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import polars as pl

from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.native_stderr import quiet_panics
from parsers.parquet_columns import SAMPLE_ROWS, is_number, time_of
from parsers.parquet_group import FAILURES, ParquetGroup, damaged
from parsers.parquet_units import same_unit
from parsers.table_names import ColumnName, unique_names
from parsers.table_stamps import DAY_NS
from parsers.timebase import JUMP_BACK_NS

_HINT = "give the files that belong together one by one, or rename the columns of those that do not"


def chained(groups: Sequence[ParquetGroup], path: Path, log: ImportLog) -> tuple[ParquetGroup, ...]:
    """The files table by table, the parts of a table in the order of their time, with names unique in the whole log.

    Raises LogError where two parts of a table hold the same time, or tell it in different ways.
    """
    tables: dict[frozenset[str], list[ParquetGroup]] = {}
    for group in groups:
        tables.setdefault(frozenset(group.headers), []).append(group)
    ordered = [_in_order(parts, path, log) if len(parts) > 1 else parts for parts in tables.values()]
    names = _unique_names([parts[0] for parts in ordered], log)
    return tuple(
        replace(part, name=parts[0].name, names=own, table=k)
        for k, (parts, own) in enumerate(zip(ordered, names, strict=True))
        for part in parts
    )


def _in_order(parts: Sequence[ParquetGroup], path: Path, log: ImportLog) -> list[ParquetGroup]:
    """The parts of one table, alike in the order of their columns and in how they tell time."""
    # the longest part shows best in which unit a column without one counts
    model = max(parts, key=lambda part: part.rows)
    alike = [_like(model, part, path) for part in parts]
    alike = _with_units(_without_texts(alike, log), path)
    day = model.time.kind == "calendar" and not model.time.absolute
    spans = {part.path: _span(part) for part in alike}
    known = [part for part in alike if spans[part.path] is not None]
    if day:
        # times of day begin again at midnight: there the files' names tell the order
        known.sort(key=_by_name)
    else:
        known.sort(key=lambda part: spans[part.path] or (0, 0))
    for before, after in pairwise(known):
        (_, end), (start, _) = spans[before.path] or (0, 0), spans[after.path] or (0, 0)
        step = (start - end + DAY_NS // 2) % DAY_NS - DAY_NS // 2 if day else start - end
        if step < -JUMP_BACK_NS:
            raise LogError(
                f"{before.path.name} and {after.path.name} have the same columns, so that they are parts of one table, "
                f"but their times overlap by {-step / 1e9:g} s",
                path=path,
                hint=_HINT,
            )
    log.note(
        f"{len(parts)} files with the same columns are parts of one table, read in the order of their time"
    )
    return known + [part for part in alike if spans[part.path] is None]


def _with_units(parts: Sequence[ParquetGroup], path: Path) -> list[ParquetGroup]:
    """The parts with the units that any of them states. Raises LogError where two state different ones for a column."""
    names = list(parts[0].names)
    teller = [parts[0]] * len(names)
    for part in parts[1:]:
        for k, column in enumerate(part.names):
            before = names[k].unit
            if before is None and column.unit is not None:
                names[k], teller[k] = column, part
            elif before is not None and column.unit is not None and not same_unit(before, column.unit):
                raise LogError(
                    f'{teller[k].path.name} has column "{column.header}" in {before}, {part.path.name} in {column.unit}, '
                    "and both are parts of one table",
                    path=path,
                    hint=_HINT,
                )
    return [replace(part, names=tuple(names)) for part in parts]


def _by_name(part: ParquetGroup) -> tuple[int, str]:
    """Names with numbers in order: part-2 before part-10."""
    return len(part.path.name), part.path.name


def _like(model: ParquetGroup, part: ParquetGroup, path: Path) -> ParquetGroup:
    """A part with its columns in the order of another, and its way to tell time."""
    order = [part.headers.index(header) for header in model.headers]
    types = tuple(part.types[k] for k in order)
    if any(types[k].is_temporal() != model.types[k].is_temporal() for k in model.time.columns):
        raise LogError(
            f"{model.path.name} and {part.path.name} have the same columns, but their times are of different types",
            path=path,
            hint=_HINT,
        )
    return replace(
        part,
        names=tuple(part.names[k] for k in order),
        headers=model.headers,
        types=types,
        time=model.time,
        left_out=model.left_out,
    )


def _without_texts(parts: Sequence[ParquetGroup], log: ImportLog) -> list[ParquetGroup]:
    """Columns of numbers that are something else in some of the parts have no values there, which is said."""
    without: dict[Path, set[int]] = {part.path: set() for part in parts}
    for k, column in enumerate(parts[0].names):
        other = [p for p in parts if not is_number(p.types[k]) and p.types[k] != pl.Null]
        if k not in parts[0].time.columns and 0 < len(other) < len(parts):
            named = ", ".join(p.path.name for p in other[:3]) + (", …" if len(other) > 3 else "")
            log.note(f'column "{column.name}" holds no numbers in {named}: it has no values there')
            for part in other:
                without[part.path].add(k)
    return [
        replace(part, types=tuple(pl.Null() if k in out else kind for k, kind in enumerate(part.types)))
        for part, out in zip(parts, without.values(), strict=True)
    ]


def _span(part: ParquetGroup) -> tuple[int, int] | None:
    """The first and last stamp by the rows at both ends; None where none of these has a time. Raises LogError."""
    times = [part.headers[k] for k in part.time.columns]
    try:
        with quiet_panics():
            frame = part.frame(times)
            head = frame.head(SAMPLE_ROWS).collect()
            tail = frame.slice(max(0, part.rows - SAMPLE_ROWS), SAMPLE_ROWS).collect()
    except FAILURES as error:
        raise damaged(part.path, error) from error
    first, in_head = time_of(head, times, part.time)
    last, in_tail = time_of(tail, times, part.time)
    if not in_head.any() or not in_tail.any():
        return None
    return int(first[in_head][0]), int(last[in_tail][-1])


def _unique_names(tables: Sequence[ParquetGroup], log: ImportLog) -> list[tuple[ColumnName, ...]]:
    """The columns' names, those that several tables have in common numbered, but for the time."""
    flat = [
        ColumnName(c.header, f"\0{g}" if k in group.time.columns else c.name, c.unit)
        for g, group in enumerate(tables)
        for k, c in enumerate(group.names)
    ]
    named, repeated = unique_names(flat)
    for name in repeated:
        if not name.startswith("\0"):
            log.note(f"the column name {name!r} is repeated: further columns are called {name}_2 and so on")
    result = []
    at = 0
    for group in tables:
        result.append(named[at : at + len(group.names)])
        at += len(group.names)
    return result
