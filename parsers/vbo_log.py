"""Racelogic VBO: the text logs of VBOX units.

[column names]
sats time lat long velocity heading height vert-vel YawRate Y_Accel
[data]
018 083856.300 +3608.22250787 -1086.93269549 008.931 231.91 +0036.11 -0000.06 -3.000000E-02 +1.247217E-02
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType

import numpy as np

from parsers.channels import ChannelInfo, Chunk, FloatArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.table_cells import split_cells
from parsers.table_clock import TableClock, judge_rows, write_counts
from parsers.table_names import ColumnName, unique_names
from parsers.table_ranges import RangeRows, read_again, read_table
from parsers.table_rows import RowBlock, RowPlan, RowRules
from parsers.table_stamps import DAY_NS
from parsers.table_text import Encoding, decode, find_encoding
from parsers.vbo_clock import VboClock, find_clock
from parsers.vbo_degrees import numbers_of, pieces_of, told_degrees
from parsers.vbo_fix import NAVIGATION, TOLD_BY, NoFix
from parsers.vbo_header import VboColumn, VboHead, name_columns, read_head
from parsers.vbo_heads import HEAD_LIMIT, FurtherHead, ended_by, further_heads, goes_on
from parsers.wide_text import narrow, narrow_text

_GROUP = "vbo"
_ROWS_BYTES = 64 * 1024
_POSITIONS = ("lat", "long", "_lat", "_long")


class VboImporter:
    """Racelogic VBO."""

    name = "vbo"
    title = "Racelogic VBO"
    suffixes = (".vbo",)

    def claims(self, path: Path, head: bytes) -> bool:
        """Whether the first bytes are text with a VBO file's first line or its sections."""
        encoding = find_encoding(head)
        if encoding is None:
            return False
        lower = (narrow(head, encoding) if encoding.wide else head).lower()
        sections = (b"[header]", b"[column names]", b"[channel units]", b"[data]")
        return sum(section in lower for section in sections) >= 2 or (
            lower.lstrip(b"\xef\xbb\xbf \r\n").startswith(b"file created on") and b"[" in lower
        )

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> VboReader:
        """Read the head; raises LogError where there is no data, no time column, or no text."""
        try:
            path = narrow_text(path, log)
            start, at = _read_start(path)
            size = path.stat().st_size
        except OSError as error:
            raise LogError(f"cannot be read ({error.strerror})", path=path) from error
        if not start:
            raise LogError(
                "the file is empty (0 bytes)", path=path, hint="check that the recording was copied whole"
            )
        if at < 0:
            raise LogError(
                "no [data] section: the log breaks off within its head",
                path=path,
                hint="nothing was recorded in it",
            )
        encoding = find_encoding(start[:at]) or Encoding("cp1252")
        body = start.find(b"\n", at) + 1 or len(start)
        rules, first = _rules(start[body : body + _ROWS_BYTES], encoding, path)
        head = read_head(decode(start[encoding.mark : at], encoding))
        columns, notes = name_columns(head, rules.width)
        names, repeated = unique_names([ColumnName(c.title, c.name, c.unit) for c in columns])
        for note in notes:
            log.note(note)
        for name in repeated:
            log.note(f"the column name {name!r} is repeated: further columns are called {name}_2 and so on")
        time_at = next((k for k, column in enumerate(names) if column.name.lower() == "time"), None)
        if time_at is None:
            shown = ", ".join(column.name for column in names[:10])
            raise LogError(f"no column called time among {shown}", path=path, place="[column names]")
        try:
            places = pieces_of(path, body, size, encoding)
        except OSError as error:
            raise LogError(f"cannot be read ({error.strerror})", path=path) from error
        times = numbers_of([line for lines in places for line in lines], rules, [time_at])[:, 0]
        clock = find_clock(head, first, time_at, times, log)
        degrees = told_degrees(places, rules, [n.name for n in names], time_at, seconds=clock.seconds)
        if degrees is not None:
            log.note(degrees)
        named = tuple(
            VboColumn(n.name, c.title, "deg" if degrees and n.name.lower() in _POSITIONS else c.unit)
            for n, c in zip(names, columns, strict=True)
        )
        return VboReader(
            path, encoding, head, named, time_at, rules, body - encoding.mark, clock, options, log, size
        )


def _read_start(path: Path) -> tuple[bytes, int]:
    """A file's beginning with its first rows, and where in it [data] is; -1 where it is not."""
    with path.open("rb") as file:
        start = file.read(_ROWS_BYTES)
        at = start.lower().find(b"[data]")
        while at < 0 and len(start) < HEAD_LIMIT and (more := file.read(len(start))):
            start += more
            at = start.lower().find(b"[data]")
        return start + file.read(_ROWS_BYTES), at


def _rules(start: bytes, encoding: Encoding, path: Path) -> tuple[RowRules, list[list[str]]]:
    """How the rows are written, by the commonest width of the first ones; and the first rows of that width."""
    lines = [decode(line, encoding) for line in start.split(b"\n")]
    if len(lines) > 1:
        lines = lines[:-1]
    plain = RowRules(32, 0, 0, spaces=True, quote=-1, comment=-1)
    rows = [row for line in lines if (row := split_cells(line, plain))]
    if not rows:
        raise LogError("[data] holds no rows", path=path, hint="nothing was recorded in it")
    widths = [len(row) for row in rows]
    width = max(set(widths), key=widths.count)
    rows = [row for row in rows if len(row) == width]
    comma = any("," in cell for cell in rows[0]) and not any("." in cell for cell in rows[0])
    return RowRules(32, width, width, spaces=True, quote=-1, comment=-1, decimal=44 if comma else 46), rows


def _with_time(block: RowBlock) -> RowBlock | None:
    """A block without rows whose time stands at zero, as before the satellites are found; None where none is left."""
    zero = block.time_ns == 0
    if not zero.any():
        return block
    # a drive may pass midnight, with one row
    beside = np.zeros(len(zero), dtype=np.bool_)
    beside[1:] |= zero[:-1]
    beside[:-1] |= zero[1:]
    kept = np.flatnonzero(~(zero & beside))
    if len(kept) == len(zero):
        return block
    if len(kept) == 0:
        return None
    gaps, torn = (np.unique(np.searchsorted(kept, rows)) for rows in (block.gaps, block.torn))
    return RowBlock(
        block.time_ns[kept], block.numbers[:, kept], gaps[gaps < len(kept)], torn[torn < len(kept)]
    )


class VboReader:
    """An opened VBO log."""

    def __init__(
        self,
        path: Path,
        encoding: Encoding,
        head: VboHead,
        columns: tuple[VboColumn, ...],
        time_at: int,
        rules: RowRules,
        body: int,
        clock: VboClock,
        options: ReadOptions,
        log: ImportLog,
        size: int,
    ) -> None:
        self._path = path
        self._encoding = encoding
        self._head = head
        self._columns = columns
        self._time_at = time_at
        self._rules = rules
        self._body = body
        self._clock = clock
        self._options = options
        self._log = log
        self._size = size

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """All columns but the time. Positions are raw minutes (or degrees, as their unit says), and longitudes count west: tag "positive"."""
        return tuple(
            ChannelInfo(c.name, _GROUP, c.unit, "vbo", comment=c.title, tags=MappingProxyType(_tags(c)))
            for k, c in enumerate(self._columns)
            if k != self._time_at
        )

    @property
    def clock(self) -> str:
        """The satellites' clock."""
        if self._clock.midnight is None and self._clock.seconds:
            return "seconds from a zero of the log's own"
        return "UTC time of day from satellites"

    @property
    def absolute(self) -> bool:
        """Whether the log has a date."""
        return self._clock.midnight is not None

    @property
    def start_utc_ns(self) -> int | None:
        """None: stamps are since 1970 already, or the day is unknown."""
        return None

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted columns block by block; raises LogError where no row at all can be read."""
        places = {c.name: k for k, c in enumerate(self._columns) if c.name in wanted and k != self._time_at}
        standard = {c.name.lower(): k for k, c in enumerate(self._columns) if k != self._time_at}
        # what tells whether the unit had a fix is read too, behind what is wanted
        emptied = [k for k in places.values() if k in {standard.get(name) for name in NAVIGATION}]
        told = [standard[name] for name in TOLD_BY if emptied and name in standard]
        numbers = (*places.values(), *(k for k in told if k not in places.values()))
        fix = NoFix(
            self._log,
            {name: numbers.index(standard[name]) for name in TOLD_BY if standard.get(name) in told},
            [numbers.index(k) for k in emptied],
        )
        plan = RowPlan(self._rules, numbers, (self._time_at,), self._clock.rule)
        clock = TableClock(self._log, time_of_day=True, midnight=self._clock.midnight or 0)
        rows = 0
        for part in self._parts(plan):
            write_counts(part.counts, self._log)
            whole = self._whole_rows(part)
            blocks = [kept for block in whole if (kept := _with_time(block)) is not None]
            timeless = sum(len(b.time_ns) for b in whole) - sum(len(b.time_ns) for b in blocks)
            self._log.reject("row before the satellites' time was known", timeless)
            count = sum(len(block.time_ns) for block in blocks)
            rows += count
            if part.ends_open:
                self._log.worsen(
                    "truncated", f"the last row has no end: the log was cut; {rows} rows before it are whole"
                )
            self._log.messages += count
            self._options.progress(part.done, self._size)
            for block in blocks:
                time_ns = clock.follow(block)
                self._note_midnight(time_ns)
                values = dict(zip(places, fix.apply(block.numbers), strict=False))
                yield Chunk(_GROUP, time_ns, self._without_flags(values))
            if part.left_out:
                clock.leave_out(part.left_out)
        if rows == 0:
            raise LogError(
                "no row of [data] could be read", path=self._path, hint="cogest inspect shows what was found"
            )
        judge_rows(self._log)

    def _parts(self, plan: RowPlan) -> Iterator[RangeRows]:
        """The rows part by part, on over further heads with the same columns; one with others ends the log."""
        heads: Iterator[FurtherHead] = iter(())
        found: FurtherHead | None = None
        looked = False
        for part in read_table(self._path, self._encoding, self._body, self._size, plan):
            counts, place = part.counts, part.place
            if not looked and place is not None and (counts.too_few or counts.too_many or counts.no_time):
                looked = True
                heads = further_heads(self._path, place.start, self._encoding)
                found = self._next(heads)
            if found is not None and place is not None and found.at < place.stop:
                yield read_again(self._path, plan, place, found.at)
                break
            yield part
        passed = 0
        while found is not None:
            if not goes_on(self._head, found.head):
                self._log.worsen("malformed", ended_by(self._path, found, self._head, self._size))
                break
            passed += 1
            body, found = found.body - self._encoding.mark, self._next(heads)
            stop = self._size if found is None else found.at
            yield from read_table(self._path, self._encoding, body, stop, plan)
        if passed:
            self._log.note(
                f"{passed} further head{'s' if passed > 1 else ''} with the same columns stand{'' if passed > 1 else 's'} among "
                "the rows, which go on behind"
            )

    def _next(self, heads: Iterator[FurtherHead]) -> FurtherHead | None:
        try:
            return next(heads, None)
        except OSError as error:
            raise LogError(f"cannot be read ({error.strerror})", path=self._path) from error

    def _whole_rows(self, part: RangeRows) -> list[RowBlock]:
        """The blocks without a last row that has no end: "1.2E" of "1.2E-03" would be a number too, and a wrong one."""
        if not (part.ends_open and part.last_kept):
            return part.blocks
        self._log.reject("row cut off at the end of the file")
        return part.without_last_row()

    def _note_midnight(self, time_ns: IntArray) -> None:
        if int(time_ns.max()) - (self._clock.midnight or 0) >= DAY_NS:
            self._log.note("the time of day passes midnight: it runs on into the next day")

    def _without_flags(self, values: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """Take the flags out of the satellite count: 64 for a brake trigger, 128 for differential corrections."""
        count = values.get("sats")
        if count is not None and bool(np.any(count >= 64)):
            values["sats"] = np.mod(count, 64.0, out=count.copy(), where=(count >= 64) & np.isfinite(count))
            self._log.note(
                "the satellite count carries flags (64 brake trigger, 128 differential corrections): taken out"
            )
        return values


def _tags(column: VboColumn) -> dict[str, str]:
    tags = {"column": column.name, "title": column.title}
    if column.name.lower() in ("long", "_long"):
        tags["positive"] = "west"
    return tags
