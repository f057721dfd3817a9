"""CSV, TSV and their relatives: tables of text with one time column, however they are written."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from parsers.channels import ChannelInfo, Chunk
from parsers.csv_dialect import TextTable, find_table, number_columns
from parsers.errors import LogError
from parsers.frame_tables import refuse_frames, refuse_frames_of_tools, tool_of_frames
from parsers.importer import ImportLog, ReadOptions
from parsers.table_clock import TableClock, clock_rule, write_counts
from parsers.table_cut import cut_cell
from parsers.table_hhmmss import UNIT, as_time_of_day, could_be, is_it
from parsers.table_ranges import RangeRows, read_table
from parsers.table_repeats import LEAST_SHARE, RepeatedStamps, repeat_share
from parsers.table_rows import RowPlan
from parsers.table_text import BLOCK_BYTES, Encoding, decode, find_encoding, read_sample
from parsers.table_time import TimePlan, find_time
from parsers.table_wraps import HOUR_NS, turns_of

_GROUP = "table"
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
        plan = _time_of(path, encoding, table, options, size)
        for note in (*table.notes, *plan.notes):
            log.note(note)
        return CsvReader(path, encoding, table, plan, options, log, size)


def _time_of(path: Path, encoding: Encoding, table: TextTable, options: ReadOptions, size: int) -> TimePlan:
    """How the table tells time. Raises LogError where it does not."""
    columns = [table.column(k) for k in range(table.rules.width)]
    if (options.time_unit or "").lower() == UNIT:
        plan = find_time(table.names, columns, table.style, replace(options, time_unit="s"), path)
        return as_time_of_day(plan, said=True) if plan.kind == "decimal" else plan
    plan = find_time(table.names, columns, table.style, options, path)
    if plan.kind != "decimal" or not could_be(plan, cells := columns[plan.columns[0]]):
        return plan
    try:
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
        plan: TimePlan,
        options: ReadOptions,
        log: ImportLog,
        size: int,
        block_bytes: int = BLOCK_BYTES,
    ) -> None:
        self._path = path
        self._encoding = encoding
        self._table = table
        self._plan = plan
        self._options = options
        self._log = log
        self._size = size
        self._block_bytes = block_bytes
        numeric = number_columns(table)
        self._places = {
            column.name: k
            for k, column in enumerate(table.names)
            if k not in plan.columns and (column.header or numeric[k])
        }
        self._channels = tuple(
            ChannelInfo(
                name,
                _GROUP,
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
        """Yield the wanted columns block by block; raises LogError where no row at all can be read."""
        known = {channel.name for channel in self._channels if channel.kind == "number"}
        names = [name for name in self._places if name in wanted and name in known]
        columns = tuple(self._places[name] for name in names)
        plan = RowPlan(self._table.rules, columns, self._plan.columns, clock_rule(self._plan))
        counter = self._plan.kind == "decimal" and not self._plan.absolute
        turns = turns_of(self._plan.unit_ns) if counter else ()
        if self._plan.kind == "elapsed":
            # minutes and seconds of a time of day start again with the hour
            turns = (HOUR_NS,)
        clock = TableClock(
            self._log,
            time_of_day=self._plan.kind == "hhmmss"
            or (self._plan.kind == "calendar" and not self._plan.absolute),
            midnight=self._plan.origin_ns,
            turns=turns,
        )
        repeats = RepeatedStamps(self._log) if self._repeats() else None
        rows = 0
        for part in read_table(
            self._path, self._encoding, self._table.body, self._size, plan, block_bytes=self._block_bytes
        ):
            part = self._whole(part, rows)
            rows += part.rows
            self._count(part)
            self._log.messages += part.rows
            self._options.progress(part.done, self._size)
            for block in part.blocks:
                time_ns, numbers = clock.follow(block), block.numbers
                if repeats is not None:
                    time_ns, numbers = repeats.take(time_ns, numbers)
                if len(time_ns):
                    yield Chunk(_GROUP, time_ns, dict(zip(names, numbers, strict=True)))
            if part.left_out:
                clock.leave_out()
        if repeats is not None and (rest := repeats.finish()) is not None:
            yield Chunk(_GROUP, rest[0], dict(zip(names, rest[1], strict=True)))
        if rows == 0:
            raise LogError(
                "no row with a time and numbers could be read",
                path=self._path,
                hint="cogest inspect shows what was found",
            )

    def _repeats(self) -> bool:
        """Whether the first rows share stamps with each other."""
        cells = ["|".join(row) for row in zip(*map(self._table.column, self._plan.columns), strict=True)]
        return repeat_share(cells) > LEAST_SHARE

    def _whole(self, part: RangeRows, before: int) -> RangeRows:
        """A part of the file without a last row that is cut, which is written down. before: rows in earlier parts."""
        if not part.ends_open:
            return part
        rows, cut, cell = before + part.rows, "the last row breaks off", None
        if part.last_kept:
            cell = cut_cell(self._path, self._encoding, self._table, self._plan.columns, self._size)
        if cell is not None:
            part = replace(part, blocks=part.without_last_row())
            rows, cut = rows - 1, f"{cut} (its last cell, {cell!r}, is shorter than those before it)"
            self._log.reject("row cut off at the end of the file")
        if part.last_short or cell is not None:
            self._log.worsen("truncated", f"{cut}: the log was cut; {rows} rows before it are whole")
        else:
            self._log.note(
                "the last line has no line end; if the log was cut there, its last value may be cut too"
            )
        return part

    def _count(self, part: RangeRows) -> None:
        """Write down what a part of the file lacked."""
        counts, log = part.counts, self._log
        write_counts(counts, log)
        if counts.first_text is not None:
            place, raw = counts.first_text
            shown = decode(raw, self._encoding)
            name = self._table.names[place].name
            if not any(note.startswith("text where") and f'"{name}"' in note for note in log.notes):
                log.note(f'text where a number was expected in column "{name}", first {shown!r}')
