"""CSV, TSV and their relatives: tables of text with one time column, however they are written."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

from parsers.channels import ChannelInfo, Chunk
from parsers.csv_dialect import TextTable, find_table, number_columns
from parsers.errors import LogError
from parsers.frame_tables import refuse_frames, refuse_frames_of_tools, tool_of_frames
from parsers.importer import TAKEN_AS_UTC, ImportLog, ReadOptions
from parsers.table_clock import judge_rows
from parsers.table_dates import settle_order
from parsers.table_hhmmss import UNIT, as_time_of_day, could_be, is_it
from parsers.table_pass import TablePass, TextFile, group_name, take_over_raster
from parsers.table_preamble import stated_start
from parsers.table_rasters import Columns, Raster, find_rasters
from parsers.table_text import BLOCK_BYTES, Encoding, decode, find_encoding, read_sample
from parsers.table_time import find_time
from parsers.table_time_plan import TimePlan

_HEAD = 16384
_LABVIEW = b"LabVIEW Measurement"
_NO_TABLE = "no rows of numbers separated by comma, semicolon, tab, bar or spaces"


class CsvImporter:
    """Tables of text."""

    name = "csv"
    title = "CSV table"
    suffixes = (".csv", ".tsv", ".txt", ".dat", ".tab", ".asc")

    def claims(self, path: Path, head: bytes) -> bool:
        """Whether the first bytes are text with rows of numbers; or any text, where the suffix says CSV or TSV, or its
        first words that LabVIEW wrote it."""
        encoding = find_encoding(head)
        if encoding is None or head.lstrip()[:1] in (b"{", b"<"):
            return False
        if (path.suffix.lower() in (".csv", ".tsv") and not encoding.damaged) or head.startswith(_LABVIEW):
            return True
        if tool_of_frames(decode(head, encoding)) is not None:
            return True
        try:
            return find_table(read_sample(path, encoding), encoding, complete=False) is not None
        except LogError:
            return False

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> CsvReader:
        """Find the table and its time column; raises LogError where there is none."""
        if path.is_dir():
            raise LogError(
                "a folder, where a table of text was expected", path=path, hint="give one file of it"
            )
        try:
            with path.open("rb") as file:
                head = file.read(65536)
            size = path.stat().st_size
        except OSError as error:
            raise LogError(f"cannot be read ({error.strerror})", path=path) from error
        if not head:
            raise LogError(
                "the file is empty (0 bytes)", path=path, hint="check that the recording was copied whole"
            )
        encoding = find_encoding(head)
        if encoding is None:
            raise LogError(
                "not text: it holds bytes that no text has", path=path, hint="check what the file is"
            )
        sample = read_sample(path, encoding)
        refuse_frames_of_tools(decode(sample[:_HEAD], encoding), path)
        _refuse_spectra(sample, path)
        table = find_table(sample, encoding, complete=len(sample) + encoding.mark >= size)
        if table is None:
            raise LogError(
                _NO_TABLE, path=path, hint="check that this is the log and not a description of it"
            )
        refuse_frames([column.name for column in table.names], path)
        columns = Columns(table.names, table.columns, table.style)
        plan = _time_of(path, encoding, table, columns.samples, options, size)
        rasters, said = find_rasters(columns, plan, options, path)
        for note in (*table.notes, *plan.notes, *filter(None, [said])):
            log.note(note)
        if plan.no_zone:
            log.without_zone(plan.no_zone)
        if not plan.absolute and plan.kind in ("decimal", "elapsed"):
            _note_start(decode(sample[: table.body], encoding), table, log)
        return CsvReader(path, encoding, table, rasters, options, log, size)


def _note_start(head: str, table: TextTable, log: ImportLog) -> None:
    """Write down the moment of stamp 0 where the lines above a table state it."""
    stated = stated_start(head, table.rules)
    if stated is not None:
        moment, said = stated
        log.began(moment)
        log.note(
            f"{said}: stamps count from {moment:%Y-%m-%d %H:%M:%S} (local time, time zone unknown: {TAKEN_AS_UTC})"
        )


def _time_of(
    path: Path,
    encoding: Encoding,
    table: TextTable,
    columns: Sequence[Sequence[str]],
    options: ReadOptions,
    size: int,
) -> TimePlan:
    """How the table tells time. columns: the first cells of each. Raises LogError where it does not."""
    if (options.time_unit or "").lower() == UNIT:
        plan = find_time(
            table.names, columns, table.style, replace(options, time_unit="s"), path, table.counts
        )
        return as_time_of_day(plan, said=True) if plan.kind == "decimal" else plan
    plan = find_time(table.names, columns, table.style, options, path, table.counts)
    try:
        if plan.two_ways:
            return settle_order(plan, columns, path, encoding, table.rules, size)
        if (
            plan.kind != "decimal"
            or plan.other_point
            or not could_be(plan, cells := columns[plan.columns[0]])
        ):
            return plan
        found = is_it(plan, cells, path, encoding, table.rules, size)
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    return as_time_of_day(plan, said=False) if found else plan


def _refuse_spectra(sample: bytes, path: Path) -> None:
    """Raise LogError for a LabVIEW measurement file whose first column is not the time of all the others."""
    if not sample.startswith(_LABVIEW):
        return
    for key, right in ((b"X_Columns", b"One"), (b"X_Dimension", b"Time")):
        found = re.search(rb"^" + key + rb"[\t;, ]+(\w+)", sample, re.MULTILINE)
        if found is None or found[1] != right:
            said = f"says {found[1].decode()}" if found else "is not there"
            raise LogError(
                f"a LabVIEW measurement file (LVM) without one time column for all channels: {key.decode()} {said}, "
                f"where {right.decode()} was expected",
                path=path,
                hint="write it with one X column, which is the time, or export it as CSV with a time column",
            )


class CsvReader:
    """An opened table of text."""

    def __init__(
        self,
        path: Path,
        encoding: Encoding,
        table: TextTable,
        rasters: tuple[Raster, ...],
        options: ReadOptions,
        log: ImportLog,
        size: int,
        block_bytes: int = BLOCK_BYTES,
    ) -> None:
        self._path = path
        self._encoding = encoding
        self._table = table
        self._rasters = rasters
        self._plan = rasters[0].plan
        self._options = options
        self._log = log
        self._size = size
        self._block_bytes = block_bytes
        numeric = number_columns(table)
        group_of = {k: group_name(number) for number, raster in enumerate(rasters) for k in raster.columns}
        self._places = {
            column.name: k
            for k, column in enumerate(table.names)
            if k in group_of and (column.header or numeric[k])
        }
        self._channels = tuple(
            ChannelInfo(
                name,
                group_of[k],
                table.names[k].unit,
                "table",
                "number" if numeric[k] else "text",
                tags=MappingProxyType({"column": table.names[k].header or name}),
            )
            for name, k in self._places.items()
        )

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """All columns but the time's."""
        return self._channels

    @property
    def clock(self) -> str:
        """Which column the time is from."""
        return self._plan.clock

    @property
    def absolute(self) -> bool:
        """Whether the time column counts from 1970."""
        return self._plan.absolute

    @property
    def start_utc_ns(self) -> int | None:
        """Unknown: a relative time column says nothing of the wall clock."""
        return None

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted columns block by block, raster by raster; raises LogError where no row at all can be read."""
        known = {channel.name for channel in self._channels if channel.kind == "number"}
        names = [name for name in self._places if name in wanted and name in known]
        if len(self._rasters) == 1:
            yield from self._pass(self._rasters[0], group_name(0), names).chunks()
        else:
            yield from self._by_raster(names)
        if self._log.messages == 0:
            raise LogError(
                "no row with a time and numbers could be read",
                path=self._path,
                hint="cogest inspect shows what was found",
            )
        judge_rows(self._log)

    def _by_raster(self, names: list[str]) -> Iterator[Chunk]:
        """A pass through the file for each raster of which something is wanted."""
        wanted = [[n for n in names if self._places[n] in raster.columns] for raster in self._rasters]
        passes = [number for number, own in enumerate(wanted) if own] or [0]
        for turn, number in enumerate(passes):
            log = ImportLog()
            progress = partial(self._progress_of, turn, len(passes))
            raster = self._pass(self._rasters[number], group_name(number), wanted[number])
            yield from replace(raster, log=log, progress=progress, first=turn == 0).chunks()
            take_over_raster(self._log, log, first=turn == 0)

    def _progress_of(self, turn: int, turns: int, done: int, size: int) -> None:
        self._options.progress(turn * size + done, turns * size)

    def _pass(self, raster: Raster, group: str, names: list[str]) -> TablePass:
        return TablePass(
            TextFile(self._path, self._encoding, self._table, self._size, self._block_bytes),
            raster,
            group,
            {name: self._places[name] for name in names},
            self._log,
            self._options.progress,
        )
