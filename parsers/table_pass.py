"""One pass through a table of text: the rows of one raster as chunks, and what the log book says of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from parsers.channels import Chunk
from parsers.csv_dialect import TextTable
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.table_clock import NO_TIME, TableClock, clock_rule, write_counts
from parsers.table_cut import cut_cell
from parsers.table_headers import second_header
from parsers.table_ranges import RangeRows, read_again, read_table
from parsers.table_rasters import Raster
from parsers.table_repeats import LEAST_SHARE, RepeatedStamps, repeat_share
from parsers.table_rows import RowPlan
from parsers.table_text import Encoding, decode
from parsers.table_wraps import HOUR_NS, turns_of

_ROW = "row with "


def group_name(number: int) -> str:
    """What a raster's channels are called as a group."""
    return "table" if number == 0 else f"table_{number + 1}"


@dataclass(frozen=True)
class TextFile:
    """A table in a file. size: of the file, in bytes."""

    path: Path
    encoding: Encoding
    table: TextTable
    size: int
    block_bytes: int


@dataclass(frozen=True)
class TablePass:
    """What to read in one pass. places: name of each wanted column -> its place. first: of several passes, which then says
    what concerns whole rows."""

    file: TextFile
    raster: Raster
    group: str
    places: Mapping[str, int]
    log: ImportLog
    progress: Callable[[int, int], None]
    first: bool = True

    def chunks(self) -> Iterator[Chunk]:
        """The wanted columns block by block. Raises LogError where the file cannot be read."""
        file, names = self.file, tuple(self.places)
        plan = RowPlan(
            file.table.rules,
            tuple(self.places.values()),
            self.raster.plan.columns,
            clock_rule(self.raster.plan),
        )
        clock, repeats = self._clock(), RepeatedStamps(self.log) if self._repeats() else None
        rows = comments = 0
        for part in read_table(
            file.path, file.encoding, file.table.body, file.size, plan, block_bytes=file.block_bytes
        ):
            part, ended = self._own_rows(part, plan)
            part = self._whole(part, rows)
            rows += part.rows
            comments += part.counts.comments
            self._count(part)
            self.log.messages += part.rows
            self.progress(part.done, file.size)
            for block in part.blocks:
                time_ns, numbers = clock.follow(block), block.numbers
                if repeats is not None:
                    time_ns, numbers = repeats.take(time_ns, numbers)
                if len(time_ns):
                    yield Chunk(self.group, time_ns, dict(zip(names, numbers, strict=True)))
            if part.left_out:
                clock.leave_out(part.left_out)
            if ended:
                break
        if comments:
            self.log.note(
                f"{comments} line{'s' if comments > 1 else ''} within the table that begin{'' if comments > 1 else 's'} "
                f"with {chr(file.table.rules.comment)} {'were' if comments > 1 else 'was'} passed over as {'comments' if comments > 1 else 'a comment'}"
            )
        if repeats is not None and (rest := repeats.finish()) is not None:
            yield Chunk(self.group, rest[0], dict(zip(names, rest[1], strict=True)))

    def _own_rows(self, part: RangeRows, plan: RowPlan) -> tuple[RangeRows, bool]:
        """A part of the file up to a header with other columns, which is written down; and whether there is one."""
        if part.place is None or not (part.counts.text_cells or part.counts.no_time or part.counts.too_many):
            return part, False
        file = self.file
        header = [name.header for name in file.table.names]
        try:
            found = second_header(
                file.path, part.place.start, part.place.stop, file.table.rules, file.encoding.codec, header
            )
        except OSError as error:
            raise LogError(f"cannot be read ({error.strerror})", path=file.path) from error
        if found is None:
            return part, False
        at, cells = found
        shown = ", ".join(cells[:4]) + (", …" if len(cells) > 4 else "")
        self.log.worsen(
            "malformed",
            f"a second header with other columns ({shown!r}) stands {at} bytes into the file: the table ends there, and the "
            f"{file.size - at} bytes from there on are left out; split the file there",
        )
        return read_again(file.path, plan, part.place, at), True

    def _clock(self) -> TableClock:
        plan = self.raster.plan
        counter = plan.kind == "decimal" and not plan.absolute
        turns = turns_of(plan.unit_ns) if counter else ()
        if plan.kind == "elapsed":
            # minutes and seconds of a time of day start again with the hour
            turns = (HOUR_NS,)
        return TableClock(
            self.log,
            time_of_day=plan.kind == "hhmmss" or (plan.kind == "calendar" and not plan.absolute),
            midnight=plan.origin_ns,
            turns=turns,
            dated=plan.kind == "calendar" and plan.absolute and len(plan.columns) > 1,
        )

    def _repeats(self) -> bool:
        """Whether the first rows share stamps with each other."""
        columns = map(self.file.table.columns.__getitem__, self.raster.plan.columns)
        return repeat_share(["|".join(row) for row in zip(*columns, strict=True)]) > LEAST_SHARE

    def _whole(self, part: RangeRows, before: int) -> RangeRows:
        """A part of the file without a last row that is cut, which is written down. before: rows in earlier parts."""
        if not part.ends_open:
            return part
        rows, cut, cell = before + part.rows, "the last row breaks off", None
        if part.last_kept and self._holds_last_column():
            cell = cut_cell(
                self.file.path, self.file.encoding, self.file.table, self.raster.plan.columns, self.file.size
            )
        if cell is not None:
            part = replace(part, blocks=part.without_last_row())
            rows, cut = rows - 1, f"{cut} (its last cell, {cell!r}, is shorter than those before it)"
            self.log.reject("row cut off at the end of the file")
        if (part.last_short and self.first) or cell is not None:
            self.log.worsen("truncated", f"{cut}: the log was cut; {rows} rows before it are whole")
        else:
            self.log.note(
                "the last line has no line end; if the log was cut there, its last value may be cut too"
            )
        return part

    def _holds_last_column(self) -> bool:
        return self.file.table.rules.width - 1 in {*self.raster.columns, *self.raster.plan.columns}

    def _count(self, part: RangeRows) -> None:
        """Write down what a part of the file lacked."""
        counts, log = part.counts, self.log
        write_counts(counts, log)
        if counts.first_text is not None:
            place, raw = counts.first_text
            shown = decode(raw, self.file.encoding)
            name = self.file.table.names[place].name
            if not any(note.startswith("text where") and f'"{name}"' in note for note in log.notes):
                log.note(f'text where a number was expected in column "{name}", first {shown!r}')


def take_over_raster(log: ImportLog, own: ImportLog, *, first: bool) -> None:
    """Write down what one raster's pass found. first: of those through the file, which counts what concerns whole rows.

    A raster that ends before the others has rows without a time, and lost nothing by it.
    """
    for reason in list(own.rejected):
        if reason == NO_TIME or (reason.startswith(_ROW) and not first):
            del own.rejected[reason]
    log.take_over(own)
