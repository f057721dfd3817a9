"""What a cell of a text table looks like: a number (and in which spelling), a date, a time of day, nothing, a word."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from parsers.table_months import MONTH_WORD, SIGNS
from parsers.table_numbers import MISSING_WORDS
from parsers.table_rows import RowRules

MINUS = "\N{MINUS SIGN}"
"""Written for the hyphen by spreadsheets of some languages, R and matplotlib."""
NO_BREAK = "\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE}"
"""Written between groups of three digits by French, Russian, Swedish and other spreadsheets."""
_SIGN = f"[+{MINUS}-]?"
_EXPONENT = rf"(?:[eEdD]{_SIGN}\d+)?"
_CLOCK = r"\d{1,2}:\d{2}(?::\d{2}(?:[.,:]\d+)?)?(?:\s*[AaPp][Mm])?"
_ZONE = r"(?:\s*(?:[zZ]|(?:UTC|GMT)(?:[+-]\d{1,2}(?::?\d{2})?)?|[+-]\d{2}(?::?\d{2})?|[A-Z]{3,5}))?"
_DATE = (
    r"(?:\d{4}([-/.])\d{1,2}\1\d{1,2}|\d{1,2}([-/.])\d{1,2}\2\d{4}"
    # two digits of a year behind dots alone: with other signs it may stand first
    r"|\d{1,2}\.\d{1,2}\.\d{2}(?!\d|[,:]\d))"
)
_WEEKDAY = r"(?:[^\W\d_]{2,10}\.?,?\s+)?"
_NAMED = (
    rf"(?i:{_WEEKDAY}(?:\d{{1,2}}(?:[-/]|[. ]{{1,2}}){MONTH_WORD}[-/., ]{{1,2}}\d{{4}}"
    rf"|\d{{4}}[-/.]{MONTH_WORD}[-/.]\d{{1,2}}|{MONTH_WORD}\s+\d{{1,2}},?\s+\d{{4}}))"
)
"""A date with its month's name: 16-Mar-2024, 16. März 2024, Sat, 16 Mar 2024, Mar 16, 2024."""
_CTIME = rf"(?i:{_WEEKDAY}{MONTH_WORD}\s+\d{{1,2}}\s+{_CLOCK})(?:\s+[A-Z]{{3,5}})?\s+\d{{4}}"
"""Of C's ctime and the shell's date: Sat Mar 16 14:05:22 CET 2024."""
_BASIC = (
    r"\d{8}(?:[tT]\d{4}(?:\d{2}(?:[.,]\d+)?)?|[tT _-](?:\d{6}(?:[.,]\d+)?|\d{1,2}:\d{2}:\d{2}(?:[.,:]\d+)?))"
)
"""ISO 8601 without signs: 20251009T085320.000; and 20251009 08:53:20.000."""
_SIGNED = rf"\d{{4}}{SIGNS[0]}\d{{1,2}}{SIGNS[1]}\d{{1,2}}{SIGNS[2]}"
_SIGNED_CLOCK = rf"\d{{1,2}}[{SIGNS[3]}]\d{{1,2}}{SIGNS[4]}(?:\d{{1,2}}(?:[.,]\d+)?{SIGNS[5]})?"
_DOTTED = r"\d{1,2}\.\d{2}\.\d{2}"
"""A time of day of Danish, Finnish and other spreadsheets; alone it is one only with a fraction, else a date."""
COMPACT_CELL = re.compile(
    r"(?:19[7-9]\d|20\d\d)(?:0[1-9]|1[0-2])(?:0[1-9]|[12]\d|3[01])(?:[01]\d|2[0-3])[0-5]\d[0-5]\d(?:[.,]\d+|\d{3}|\d{6}|\d{9})?"
)
"""A number that spells a date and time of day: 20251009085320.000, 20251009085320000."""
DATE_CELL = re.compile(rf"{_DATE}(?:\s*(?:[zZ]|UTC))?|{_NAMED}|{_SIGNED}")
CLOCK_CELL = re.compile(
    rf"(?:\d{{1,2}}:\d{{2}}:\d{{2}}(?:[.,:]\d+)?(?:\s*[AaPp][Mm])?|{_DOTTED}[,:]\d+){_ZONE}"
)
CALENDAR_CELL = re.compile(
    rf"(?:{_DATE}|{_NAMED})(?:[tT]|[\s,]+)(?:{_CLOCK}|{_DOTTED}(?:[.,:]\d+)?){_ZONE}|{_BASIC}{_ZONE}|{COMPACT_CELL.pattern}{_ZONE}"
    rf"|{_CTIME}|{_SIGNED}\s*(?:{_SIGNED_CLOCK}|{_CLOCK}){_ZONE}"
)
WITH_DATE = re.compile(rf"{_DATE}|{_BASIC}|{_NAMED}|{_SIGNED}|{_CTIME}|{COMPACT_CELL.pattern}")
"""What a cell with a date begins with."""
DURATION_CELL = re.compile(rf"{_SIGN}\d+(?:[.,]\d*)?{_EXPONENT} (?P<unit>[num]?s|[mu]?sec|min|hr|h)")
"""A number and its unit, as MATLAB writes durations: "0.02 sec"."""
ELAPSED_CELL = re.compile(
    rf"{_SIGN}\d{{1,5}}:[0-5]\d[.,]\d+|-?\d+ days?,? [+]?\d{{1,2}}:[0-5]\d:[0-5]\d(?:[.,]\d+)?"
)
"""Minutes and seconds as spreadsheets show them ("03:00.020"), or what pandas and Python write of a stretch of time
("0 days 00:00:00.020000")."""
_TIME_CELLS = (CALENDAR_CELL, DATE_CELL, CLOCK_CELL, DURATION_CELL, ELAPSED_CELL)
_BLANKS = re.compile("[ \t]+")
_MISSING = frozenset(MISSING_WORDS) | {"inf", "-inf", "+inf", "infinity", "-infinity"}


@dataclass(frozen=True)
class NumberStyle:
    """How numbers are written. thousands: what stands between groups of digits, any of these; "" where they are not grouped."""

    decimal: str
    thousands: str = ""

    @cached_property
    def pattern(self) -> re.Pattern[str]:
        """What a number in this style looks like."""
        return re.compile(self._spelling)

    @cached_property
    def _line_pattern(self) -> re.Pattern[str]:
        return re.compile(f"^{self._spelling}$", re.MULTILINE)

    @property
    def _spelling(self) -> str:
        point = re.escape(self.decimal)
        whole = r"\d+"
        if self.thousands:
            # nobody writes 0.020 for 20
            whole = rf"(?:[1-9]\d{{0,2}}(?:[{re.escape(self.thousands)}]\d{{3}})+|\d+)"
        return rf"{_SIGN}(?:{whole}(?:{point}\d*)?|{point}\d+){_EXPONENT}"

    def count(self, cells: Sequence[str]) -> int:
        """How many cells are numbers; of cells without line feeds."""
        return len(self._line_pattern.findall("\n".join(cells)))

    def value(self, cell: str) -> float | None:
        """A cell as a number, for looking at samples; None where it is none."""
        if not self.pattern.fullmatch(cell):
            return None
        text = cell.translate({ord(sign): None for sign in self.thousands})
        return float(re.sub("[dD]", "e", text.replace(self.decimal, ".").replace(MINUS, "-")))


STYLES: tuple[NumberStyle, ...] = (
    NumberStyle("."),
    NumberStyle(","),
    NumberStyle(".", ","),
    NumberStyle(",", "."),
    NumberStyle(",", " "),
    NumberStyle(".", "'"),
    NumberStyle(".", " "),
    NumberStyle(",", NO_BREAK),
    NumberStyle(".", NO_BREAK),
    NumberStyle(".", "\N{RIGHT SINGLE QUOTATION MARK}"),
)
"""Tried in this order; the first that reads the most cells wins."""


def is_missing(cell: str) -> bool:
    """Whether a cell holds no value, or says so."""
    return not cell or cell.lower() in _MISSING


def is_time(cell: str) -> bool:
    """Whether a cell is a date, a time of day, both, or a stretch of time."""
    return any(pattern.fullmatch(cell) for pattern in _TIME_CELLS)


def best_style(cells: Iterable[str]) -> NumberStyle:
    """The style that reads most of the cells as numbers."""
    kept = [cell for cell in cells if not is_missing(cell)]
    best, most = STYLES[0], -1
    there = set().union(*kept)
    for style in STYLES:
        if style.thousands and there.isdisjoint(style.thousands):
            continue
        count = style.count(kept)
        if count > most:
            best, most = style, count
        if count == len(kept):
            break
    return best


def value_share(cells: Sequence[str], style: NumberStyle) -> float:
    """Share of the cells that hold anything which are numbers or times; 0 where none holds anything."""
    kept = [cell for cell in cells if not is_missing(cell)]
    if not kept:
        return 0.0
    pattern = style.pattern
    return sum(pattern.fullmatch(cell) is not None or is_time(cell) for cell in kept) / len(kept)


def split_cells(line: str, rules: RowRules) -> list[str]:
    """Split one line as the kernel does; for headers and samples."""
    line = line.strip(" \r\n" if not rules.spaces else None)
    if rules.row_quotes and len(line) >= 2 and line[0] == line[-1] == '"':
        line = line[1:-1]
    separator, quote = chr(rules.separator), chr(rules.quote) if rules.quote > 0 else ""
    if '"' not in line and (not quote or quote not in line):
        if not rules.spaces:
            return [cell.strip() for cell in line.split(separator)]
        return [cell.strip() for cell in _BLANKS.split(line)] if line else []
    cells: list[str] = []
    i = 0
    while i <= len(line):
        while i < len(line) and (line[i] == " " or (rules.spaces and line[i] == "\t")):
            i += 1
        if rules.spaces and i >= len(line):
            break
        start = i
        if quote and i < len(line) and line[i] == quote:
            end = line.find(quote, i + 1)
            i = len(line) if end < 0 else end
        while i < len(line) and line[i] != separator and not (rules.spaces and line[i] == "\t"):
            i += 1
        cells.append(line[start:i].strip().strip('"').strip())
        i += 1
    return cells
