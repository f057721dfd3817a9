"""Parquet: what `cogest convert` writes (a folder, one file a rate group), and tables of others with a time column."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import timedelta
from itertools import groupby
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
import polars as pl

from parsers.channels import ChannelInfo, Chunk
from parsers.errors import LogError
from parsers.importer import TAKEN_AS_UTC, ImportLog, ReadOptions
from parsers.native_stderr import quiet_panics
from parsers.parquet_around import readable
from parsers.parquet_chain import chained
from parsers.parquet_clock import ParquetClock
from parsers.parquet_columns import (
    SAMPLE_ROWS,
    are_iso,
    floats,
    is_number,
    is_text,
    reject_cells,
    stamps_repeat,
    time_of,
    too_many_digits,
)
from parsers.parquet_group import FAILURES, ParquetGroup, damaged
from parsers.parquet_torn import read_slice, torn_pages
from parsers.parquet_units import file_metadata, with_stated_units
from parsers.places import remote
from parsers.table_cells import NumberStyle, is_missing
from parsers.table_names import ColumnName, split_header, unique_names
from parsers.table_rasters import Columns, without_other_rasters
from parsers.table_repeats import RepeatedStamps
from parsers.table_time import find_time, may_be_time
from parsers.table_time_plan import TimePlan

if TYPE_CHECKING:
    from parsers.parquet_parts import PartlyFilled

_MAGIC = b"PAR1"
_CHUNK_BYTES = 16 * 1024 * 1024
_BESIDE = (".parquet", ".pq", ".json", ".toml", ".md")
"""What a folder of Parquet files may hold: the tables, and an import record or a description."""


class ParquetImporter:
    """Parquet tables."""

    name = "parquet"
    title = "Parquet table"
    suffixes = (".parquet", ".pq")

    def claims(self, path: Path, head: bytes) -> bool:
        """Whether a file begins with Parquet's magic bytes, or a folder holds Parquet files and no other data."""
        if head:
            return head.startswith(_MAGIC)
        return (
            path.is_dir() and bool(_files(path)) and all(p.suffix.lower() in _BESIDE for p in _visible(path))
        )

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> ParquetReader:
        """Read the footers; raises LogError where one is damaged or a table has no time column."""
        files = _files(path) if path.is_dir() else [path]
        if not files:
            raise LogError(
                "the folder holds no Parquet file", path=path, hint="give a folder that cogest convert wrote"
            )
        opened = _with_rows([_open_group(file, options, log) for file in files], path, log)
        if len({group.time.absolute for group in opened}) > 1:
            raise LogError(
                "some files count time from 1970 and others from their own zero, so they have no common clock",
                path=path,
                hint="give the files one by one",
            )
        groups = chained(opened, path, log)
        for note in dict.fromkeys(note for group in groups for note in group.time.notes):
            log.note(note)
        for note in dict.fromkeys(group.time.no_zone for group in groups if group.time.no_zone):
            log.without_zone(note)
        return ParquetReader(path, groups, options, log)


def _with_rows(opened: list[ParquetGroup | None], path: Path, log: ImportLog) -> list[ParquetGroup]:
    """The files that have rows: writers of parts leave empty ones. Raises LogError where there is none."""
    groups = [group for group in opened if group is not None]
    if not groups:
        raise LogError("the Parquet file has no rows", path=path, hint="nothing was recorded in it")
    if len(groups) < len(opened):
        log.note(f"{len(opened) - len(groups)} of {len(opened)} files have no rows")
    return groups


def _visible(path: Path) -> list[Path]:
    return [entry for entry in path.iterdir() if not entry.name.startswith((".", "_"))]


def _files(path: Path) -> list[Path]:
    return sorted(
        entry
        for entry in _visible(path)
        if entry.suffix.lower() in ParquetImporter.suffixes and entry.is_file()
    )


def _check_frame(path: Path) -> None:
    """Look at the magic bytes at both ends, for a clear word on files that break off."""
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - 4))
            tail = file.read(4)
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    if size == 0:
        raise LogError("the file is empty (0 bytes)", path=path, hint="check that it was copied whole")
    if size < 12 or tail != _MAGIC:
        raise LogError(
            "the Parquet file is truncated: its table of contents, which stands at the end, is missing",
            path=path,
            place=f"byte {size}",
            hint="copy or convert it again",
        )


def _open_group(path: Path, options: ReadOptions, log: ImportLog) -> ParquetGroup | None:
    """The columns, time and row count of one file; None where it has no rows."""
    _check_frame(path)
    far = _partly_filled(path)
    try:
        with quiet_panics():
            frame = pl.scan_parquet(far.path if far else path, glob=False)
            schema = frame.collect_schema()
            rows = int(frame.select(pl.len()).collect().item())
            stated = with_stated_units(
                [split_header(name) for name in schema.names()],
                schema.names(),
                file_metadata(far.path if far else path),
            )
            names = stated.names
            types = tuple(schema.dtypes())
            if far is not None:
                frame = frame.select(_fetched_sample(far, names, schema, options))
            head = _head(frame)
    except FAILURES as error:
        raise damaged(path, error) from error
    if rows == 0:
        return None
    cells = tuple(
        tuple(_cells(head[name], kind)) if name in head.columns else ()
        for name, kind in zip(schema.names(), types, strict=True)
    )
    columns = Columns(unique_names(names)[0], cells, NumberStyle("."))
    spelt = _spelt_numbers(cells, types)
    plan = _calendar_time(names, types, options) or find_time(names, cells, columns.style, options, path)
    told = all(types[k].is_temporal() for k in plan.columns)
    if plan.kind == "calendar" and len(plan.columns) == 1:
        told = told or (not plan.whole_ms and are_iso(cells[plan.columns[0]]))
    if plan.kind in ("calendar", "elapsed") and not told:
        raise LogError(
            f'the time in column "{names[plan.columns[0]].name}" is text',
            path=path,
            hint="write it as ISO 8601 (2025-03-04T10:20:30.123Z), as a timestamp or as nanoseconds in a column time_ns",
        )
    lost = [names[k].header for k in plan.columns if schema.names()[k] not in head.columns]
    if lost and far is None:
        raise damaged(path, ValueError(f"the time in column {lost[0]!r} cannot be decoded"))
    left_out, said = without_other_rasters(columns, plan, options, path)
    spelt -= {*plan.columns}
    wide, undone = too_many_digits(schema)
    for note in filter(
        None, [*stated.notes, said, undone, _nested_note(names, types), _spelt_note(names, spelt)]
    ):
        log.note(note)
    types = tuple(pl.Float64() if k in spelt else kind for k, kind in enumerate(types))
    return ParquetGroup(
        path, path.stem, names, tuple(schema.names()), types, plan, rows, 0, far, left_out | wide
    )


def _head(frame: pl.LazyFrame) -> pl.DataFrame:
    """The first rows; without the columns that cannot be decoded there, where there are any. Raises FAILURES."""
    try:
        return frame.head(SAMPLE_ROWS).collect()
    except FAILURES:
        head = readable(frame, frame.collect_schema().names(), SAMPLE_ROWS)
        if not head.width:
            raise
        return head


def _nested_note(names: Sequence[ColumnName], types: Sequence[pl.DataType]) -> str | None:
    """A sentence on columns that hold several values a row, which are no channels."""
    nested = [f'"{c.header or c.name}"' for c, kind in zip(names, types, strict=True) if kind.is_nested()]
    if not nested:
        return None
    shown = ", ".join(nested[:6]) + (f" and {len(nested) - 6} more" if len(nested) > 6 else "")
    return f"columns of structures or lists are not read: {shown}; write their fields as columns of their own"


def _spelt_numbers(cells: Sequence[Sequence[str]], types: Sequence[pl.DataType]) -> set[int]:
    """The columns of text of which at least half of the first values that there are are numbers, as in CSV."""
    style = NumberStyle(".")
    kept = [[text for cell in own if not is_missing(text := cell.strip())] for own in cells]
    return {
        k
        for k, (own, kind) in enumerate(zip(kept, types, strict=True))
        if is_text(kind) and own and style.count(own) >= 0.5 * len(own)
    }


def _spelt_note(names: Sequence[ColumnName], spelt: set[int]) -> str | None:
    if not spelt:
        return None
    named = ", ".join(f'"{names[k].header}"' for k in sorted(spelt))
    return f"columns that hold numbers as text are read as numbers: {named}"


def _partly_filled(path: Path) -> PartlyFilled | None:
    """The copy that is filled as needed, of a file behind a URL. Raises OSError, LogError."""
    far = remote(path)
    if far is None:
        return None
    from parsers.parquet_parts import PartlyFilled

    try:
        return PartlyFilled(far)
    except ValueError as error:
        raise damaged(path, error) from error


def _fetched_sample(
    far: PartlyFilled, names: Sequence[ColumnName], schema: pl.Schema, options: ReadOptions
) -> list[str]:
    """Fetch the first rows of the columns that may be the time, and name them."""
    columns = [
        header
        for column, (header, kind) in zip(names, schema.items(), strict=True)
        if is_text(kind)
        or isinstance(kind, (pl.Duration, pl.Time))
        or (kind.is_numeric() and may_be_time(column, options))
    ]
    far.fill(columns, SAMPLE_ROWS)
    return columns


def _cells(column: pl.Series, kind: pl.DataType) -> list[str]:
    """The first values as text, for the time column's recognition. Floats keep all their digits."""
    if isinstance(kind, pl.Duration):
        # as pandas writes a stretch of time
        return ["" if v is None else f"{v.days} days {v - timedelta(v.days)}" for v in column.to_list()]
    if not kind.is_numeric() and not is_text(kind) and kind != pl.Time:
        return []
    return ["" if value is None else str(value) for value in column.to_list()]


def _calendar_time(
    names: tuple[ColumnName, ...], types: tuple[pl.DataType, ...], options: ReadOptions
) -> TimePlan | None:
    """A column of Parquet's own time stamps: the one that the map file names, else the first."""
    for place, (column, kind) in enumerate(zip(names, types, strict=True)):
        if not isinstance(kind, pl.Datetime) or options.time_channel not in (
            None,
            column.name,
            column.header,
        ):
            continue
        if options.time_channel is None and any(other.name == "time_ns" for other in names):
            return None
        clock, no_zone = f'column "{column.name}", UTC', ""
        if kind.time_zone is None:
            clock = f'column "{column.name}", taken as UTC'
            no_zone = f'the time stamps in column "{column.name}" state no time zone: {TAKEN_AS_UTC}'
        return TimePlan("calendar", (place,), clock, True, no_zone=no_zone)
    return None


class ParquetReader:
    """Opened Parquet files."""

    def __init__(
        self, path: Path, groups: tuple[ParquetGroup, ...], options: ReadOptions, log: ImportLog
    ) -> None:
        self._path = path
        self._groups = groups
        self._options = options
        self._log = log
        self._runs_on = ParquetClock(log)

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """All columns of all tables but the times."""
        tables = [tuple(parts) for _, parts in groupby(self._groups, lambda group: group.table)]
        return tuple(
            ChannelInfo(
                column.name,
                parts[0].name,
                column.unit,
                "table",
                "number" if any(is_number(part.types[k]) for part in parts) else "text",
                sum(part.rows for part in parts),
                tags=MappingProxyType(
                    {"column": column.header}
                    | ({"holds": "no values"} if all(part.types[k] == pl.Null for part in parts) else {})
                ),
            )
            for parts in tables
            for k, column in enumerate(parts[0].names)
            if k not in parts[0].time.columns and k not in parts[0].left_out
        )

    @property
    def clock(self) -> str:
        """Which column the time is from."""
        return self._groups[0].time.clock

    @property
    def absolute(self) -> bool:
        """Whether the time column counts from 1970."""
        return self._groups[0].time.absolute

    @property
    def start_utc_ns(self) -> int | None:
        """Unknown: a relative time column says nothing of the wall clock."""
        return None

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted columns file by file; raises LogError where a file is damaged before its first row."""
        total = sum(group.rows for group in self._groups)
        done = 0
        for group in self._groups:
            for rows, chunk in self._read_group(group, wanted):
                self._options.progress(done + rows, total)
                yield chunk
            done += group.rows

    def _read_group(self, group: ParquetGroup, wanted: frozenset[str]) -> Iterator[tuple[int, Chunk]]:
        """Chunks of one file, each with the rows read so far."""
        columns = {
            column.name: header
            for k, (column, header, kind) in enumerate(
                zip(group.names, group.headers, group.types, strict=True)
            )
            if column.name in wanted
            and k not in {*group.time.columns, *group.left_out}
            and (is_number(kind) or kind == pl.Null)
        }
        if wanted and not columns:
            return
        times = [group.headers[k] for k in group.time.columns]
        frame = group.frame([*times, *columns.values()])
        step = max(1024, _CHUNK_BYTES // (8 * (len(times) + len(columns))))
        torn = torn_pages(group, times, columns, self._log)
        repeats: RepeatedStamps | None = None
        for start in range(0, group.rows, step):
            try:
                part = read_slice(frame, start, step, times, columns, torn)
            except FAILURES as error:
                if start == 0:
                    raise damaged(group.path, error) from error
                self._log.worsen(
                    "malformed", f"{group.path.name} is damaged after row {start} of {group.rows}"
                )
                self._log.reject("row in a damaged block", group.rows - start)
                break
            time_ns, valid = time_of(part, times, group.time)
            values = {name: floats(part[header]) for name, header in columns.items()}
            bad = len(valid) - int(valid.sum())
            self._log.reject("row without a valid time", bad)
            valid, values = torn.take_out(start, valid, values)
            bad = len(valid) - int(valid.sum())
            self._log.messages += len(valid) - bad
            if bad == len(valid):
                continue
            keep = slice(None) if bad == 0 else valid
            time_ns = time_ns[keep]
            time_ns = self._runs_on.follow(group.table, group.time, time_ns)
            values = {name: each[keep] for name, each in values.items()}
            torn.write_spans(start, np.flatnonzero(valid), time_ns)
            reject_cells(part[[*columns.values()]], self._log)
            if start == 0 and values and stamps_repeat(time_ns):
                repeats = RepeatedStamps(self._log)
            if repeats is not None:
                time_ns, numbers = repeats.take(time_ns, np.stack(tuple(values.values())))
                values = dict(zip(values, numbers, strict=True))
            if len(time_ns):
                yield start + part.height, Chunk(group.name, time_ns, values)
        if repeats is not None and (rest := repeats.finish()) is not None:
            yield group.rows, Chunk(group.name, rest[0], dict(zip(columns, rest[1], strict=True)))
