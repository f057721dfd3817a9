"""Tables of text by their first bytes: is there a time column, and when do the rows begin and end.

Logs of one recorder have one header, so what was found out of a header is kept: ten thousand tables are looked at in seconds.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from parsers.csv_dialect import TextTable, find_table, number_columns
from parsers.errors import LogError
from parsers.importer import HEAD_BYTES, ReadOptions
from parsers.table_cells import NumberStyle, split_cells
from parsers.table_names import split_header
from parsers.table_text import Encoding, decode, find_encoding, read_sample
from parsers.table_time import find_time
from parsers.table_time_plan import TimePlan

_NS = 1_000_000_000
_ROW = re.compile(rb"^[ \t\"']*[-+.]?\d")
_TAIL_BYTES = 8192
_Key = tuple[bytes, int, int, str | None]
_SEPARATORS = re.compile(r"[\t;,|]")


@dataclass(frozen=True)
class TableLook:
    """What a table's first bytes say. plan: how it tells time."""

    table: TextTable
    plan: TimePlan
    encoding: Encoding

    @property
    def mostly_numbers(self) -> bool:
        """Whether at least half of what stands beside the time are numbers: programs' own logs have words."""
        numeric = number_columns(self.table)
        beside = [numeric[k] for k in range(len(numeric)) if k not in self.plan.columns]
        return bool(beside) and sum(beside) * 2 >= len(beside)

    def stamp(self, line: bytes) -> int | None:
        """The time of a row in ns; None where the line is no whole row, or its time is not quickly read."""
        cells = split_cells(decode(line, self.encoding), self.table.rules)
        if not self.table.rules.min_width <= len(cells) <= self.table.rules.width:
            return None
        texts = [cells[k] for k in self.plan.columns if k < len(cells)]
        if len(texts) < len(self.plan.columns):
            return None
        if self.plan.kind == "calendar":
            return _moment(" ".join(texts)) if self.plan.absolute else None
        if self.plan.kind == "elapsed":
            return None
        values = [self.table.style.value(text) for text in texts]
        units = (self.plan.unit_ns,) if self.plan.kind == "decimal" else (_NS, 1)
        total = 0
        for value, unit in zip(values, units, strict=True):
            if value is None or not abs(value) * unit < 9.2e18:
                return None
            total += round(value * unit)
        return total


def _moment(text: str) -> int | None:
    """A date and time of day that begins with the year, in ns since 1970; None for other spellings."""
    try:
        found = datetime.fromisoformat(text.replace("/", "-").replace(",", ".").replace(" UTC", "Z"))
    except ValueError:
        return None
    zoned = found if found.tzinfo is not None else found.replace(tzinfo=UTC)
    return round((zoned - datetime(1970, 1, 1, tzinfo=UTC)).total_seconds() * _NS)


@dataclass
class TableHeads:
    """Looks at tables; keeps what headers taught."""

    known: dict[_Key, TableLook] = field(default_factory=dict)

    def known_look(self, head: bytes, options: ReadOptions) -> TableLook | None:
        """What a table is, where its header was met before; None where it was not."""
        key, row = _key(head, options)
        known = self.known.get(key) if key is not None else None
        return known if known is not None and known.stamp(row) is not None else None

    def look(self, path: Path, head: bytes, options: ReadOptions) -> TableLook:
        """What the table is. Raises LogError where it is none, or has no time column."""
        look = self._careful(path, head, options)
        key, _ = _key(head, options)
        if key is not None:
            self.known[key] = look
        return look

    def _careful(self, path: Path, head: bytes, options: ReadOptions) -> TableLook:
        encoding = find_encoding(head)
        if encoding is None:
            raise LogError("not text", path=path)
        complete = len(head) < HEAD_BYTES
        plain = head[encoding.mark :]
        if not encoding.wide and not encoding.old_lines:
            try:
                return _look(plain, encoding, complete, path, options)
            except LogError:
                if complete:
                    raise
        return _look(read_sample(path, encoding), encoding, False, path, options)


def _key(head: bytes, options: ReadOptions) -> tuple[_Key | None, bytes]:
    """What tells a header from others, and the first row below it; None where there is no header.

    Numbers in the lines above the columns' names (a date, a serial number) make no other header. The rows' look counts too: a
    header may stand over rows of another kind.
    """
    lines = head.split(b"\n")[:-1]
    at = next((k for k, line in enumerate(lines) if _ROW.match(line)), 0)
    if at == 0:
        return None, b""
    row, above = lines[at], re.sub(rb"\d+", b"0", b"\n".join(lines[: at - 1]))
    return (above + b"\n" + lines[at - 1], row.count(b","), row.count(b";"), options.time_channel), row


def _look(plain: bytes, encoding: Encoding, complete: bool, path: Path, options: ReadOptions) -> TableLook:
    table = find_table(plain, encoding, complete=complete)
    if table is None:
        raise LogError("holds no rows of numbers", path=path)
    plan = find_time(table.names, table.columns, table.style, options, path, table.counts)
    return TableLook(table, plan, encoding)


def names_a_time(head: bytes, path: Path) -> bool:
    """Whether one of a text's first lines is a header with a time column, though no row of numbers follows."""
    encoding = find_encoding(head)
    if encoding is None:
        return False
    for line in decode(head, encoding).splitlines()[:8]:
        cells = _SEPARATORS.split(line)
        if len(cells) < 2:
            continue
        names = [split_header(cell.strip().strip('"')) for cell in cells]
        # as if rows of numbers stood below it
        rows = [("0", "1")] * len(names)
        try:
            find_time(names, rows, NumberStyle("."), ReadOptions(), path)
        except LogError:
            continue
        return True
    return False


def first_and_last(look: TableLook, path: Path) -> tuple[int, int] | None:
    """When a table's rows begin and end, in ns on its own clock; None where that is not quickly told.

    Raises OSError.
    """
    if look.encoding.wide or look.encoding.old_lines:
        return None
    with path.open("rb") as file:
        file.seek(look.encoding.mark)
        start = file.read(HEAD_BYTES)
        size = file.seek(0, 2)
        file.seek(max(0, size - _TAIL_BYTES))
        end = file.read(_TAIL_BYTES)
    first = next(
        (s for line in start.split(b"\n")[:-1] if _ROW.match(line) and (s := look.stamp(line)) is not None),
        None,
    )
    # a last line without its end may be cut inside the time
    whole = end.split(b"\n")[:-1]
    last = next(
        (s for line in reversed(whole) if _ROW.match(line) and (s := look.stamp(line)) is not None), None
    )
    if first is None or last is None or last < first:
        return None
    return first, last
