"""Find the table in a text: separator, decimal sign, quoting, where the rows begin and what the columns are called."""

from __future__ import annotations

import re
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import islice, pairwise

from parsers.table_cells import NO_BREAK, NumberStyle, best_style, is_missing, split_cells, value_share
from parsers.table_names import ColumnName, split_header, unique_names
from parsers.table_points import has_fractions, without_groups
from parsers.table_rows import RowRules
from parsers.table_text import Encoding, decode
from parsers.table_time import is_called_time
from parsers.unit_rows import with_unit_row
from parsers.unit_words import is_unit

_MOST_LINES = 3000
_SCORED_LINES = 80
_BROKEN_ROWS = 3
_HEADER_LINES = 8
_SAMPLED_ROWS = 500
_NO_CELLS = ' \t,;|"'
_SEPARATORS = ("\t", ";", ",", "|", " ")
_WRAPPED_LINES = 60
_WRAPPED_CELLS = 40
"""A header with line ends within quotes stands in the first lines, and goes over so many of them at the most."""
_OPEN_QUOTE = re.compile(rb'(?:^|[\t;,|]) *"[^"]*$')
_ROW_START = re.compile(rb"^[ \t\"']*[-+.]?\d")
_SEP_LINE = re.compile(r'^\s*"?sep=(.)"?\s*$', re.IGNORECASE)
_TYPE = re.compile(r"[fiu][1248]|float(32|64)?|double|u?int(8|16|32|64)?", re.IGNORECASE)
_NUMBERS_IN_NAMES, _DIGITS_IN_NAMES = 0.2, 0.5
"""Share of a header's cells that may be numbers, and below which they may be names of one or two digits."""
_DIGITS = re.compile(r"\d{1,2}")
_COMMENT_START = re.compile(r"^\s*(?:#+|//|%%?(?=\s))\s*")


@dataclass(frozen=True)
class TextTable:
    """A table in a text file. body: byte of the plain text at which the rows begin. sample: cells of the first
    rows. notes: what was assumed, in sentences."""

    rules: RowRules
    style: NumberStyle
    names: tuple[ColumnName, ...]
    body: int
    sample: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...]

    @cached_property
    def columns(self) -> tuple[tuple[str, ...], ...]:
        """The sampled cells of each column, empty where a row has too few."""
        width = self.rules.width
        rows = [row if len(row) == width else (row + ("",) * width)[:width] for row in self.sample]
        return tuple(zip(*rows, strict=True)) if rows else ((),) * width

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """How many of each column's sampled cells are numbers."""
        return tuple(map(self.style.count, self.columns))


def find_table(sample: bytes, encoding: Encoding, *, complete: bool) -> TextTable | None:
    """The table in the first bytes of a text, or None where nothing looks like rows of numbers.

    complete: whether the sample is the whole file, so that its last line is not cut.
    """
    raw_lines = sample.split(b"\n")
    if not complete and len(raw_lines) > 1:
        raw_lines = raw_lines[:-1]
    raw_lines = _with_whole_headers(raw_lines[:_MOST_LINES])
    lines = [
        decode(line, encoding).rstrip("\r").replace("\r\n", " ").replace("\n", " ") for line in raw_lines
    ]
    stated = next((_SEP_LINE.match(line) for line in lines[:1]), None)
    if stated is not None:
        lines[0] = ""
    chosen = _choose_rules(lines, stated[1] if stated is not None else None)
    if chosen is None:
        return None
    rules, style, share = chosen
    first = _first_row(lines, rules, style, share)
    if first is None:
        return None
    first = _before_broken_rows(lines, first, rules, style)
    fitting = (
        tuple(row)
        for line in lines[first:]
        if _is_filled(line) and rules.min_width <= len(row := split_cells(line, rules)) <= rules.width
    )
    rows = tuple(islice(fitting, _SAMPLED_ROWS))
    style = without_groups(style, list(zip(*(row for row in rows if len(row) == rules.width), strict=True)))
    rules = rules if style.thousands else replace(rules, thousands=-1)
    names, rules, notes = _name_columns(lines, first, rules, style, rows)
    body = sum(len(line) + 1 for line in raw_lines[:first])
    return TextTable(rules, style, names, body, rows, tuple(notes + _style_notes(rules, style)))


def _with_whole_headers(raw_lines: list[bytes]) -> list[bytes]:
    """The lines, with those joined over which a header's cell in quotes goes on, as spreadsheets write two lines in one."""
    lines = list(raw_lines)
    for at in range(_WRAPPED_LINES):
        if at >= len(lines):
            break
        if not _OPEN_QUOTE.search(lines[at]) or _ROW_START.match(lines[at]) or lines[at].count(b'"') % 2 == 0:
            continue
        for stop in range(at + 2, min(at + _WRAPPED_CELLS, len(lines)) + 1):
            joined = b"\n".join(lines[at:stop])
            if joined.count(b'"') % 2 == 0:
                lines[at:stop] = [joined]
                break
    return lines


ROW_END = "_row_end"
"""Name of the column without name and values behind a separator that ends every row."""


def _is_filled(line: str) -> bool:
    """Whether a line holds more than blanks or a comment."""
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _style_notes(rules: RowRules, style: NumberStyle) -> list[str]:
    notes = []
    if style.decimal == ",":
        notes.append("the decimal sign is a comma")
    if style.thousands:
        sign = "no-break blanks" if style.thousands == NO_BREAK else repr(style.thousands)
        notes.append(f"digits are grouped by {sign}")
    if rules.row_quotes:
        notes.append("every row stands in quotes as a whole")
    return notes


def _choose_rules(lines: Sequence[str], stated: str | None) -> tuple[RowRules, NumberStyle, float] | None:
    """The separator and number style that read the last lines of the sample best, and the share of values in a row."""
    # spreadsheets add rows of separators alone
    scored = [line for line in lines if line.strip(_NO_CELLS) and not line.lstrip().startswith("#")]
    scored = scored[-_SCORED_LINES:]
    if not scored:
        return None
    row_quotes = _rows_are_quoted(scored)
    best: tuple[float, RowRules, NumberStyle, float] | None = None
    for separator in (stated,) if stated else _SEPARATORS:
        rules = RowRules(ord(separator), 0, 0, spaces=separator == " ", row_quotes=row_quotes)
        split = [split_cells(line, rules) for line in scored]
        width = statistics.mode(len(row) for row in split)
        rows = [row for row in split if len(row) == width]
        if width < 2:
            continue
        style = best_style(cell for row in rows for cell in row)
        share = statistics.median(value_share(row, style) for row in rows)
        score = share * len(rows) / len(split)
        if best is None or score > best[0] + 1e-9:
            best = (score, replace(rules, width=width, min_width=width), style, share)
    if best is None or best[0] < 0.15:
        return None
    _, rules, style, share = best
    # what is beyond ASCII the kernel knows whatever the rules say
    groups = ord(style.thousands) if style.thousands.isascii() and style.thousands else -1
    point = ord(style.decimal)
    return replace(rules, decimal=point, thousands=groups), style, share


def _rows_are_quoted(lines: Sequence[str]) -> bool:
    """Whether (nearly) every line stands in one pair of quotes: "0.01,1.5,2.5"."""
    stripped = [line.strip() for line in lines]
    whole = [
        line for line in stripped if len(line) > 2 and line[0] == line[-1] == '"' and '"' not in line[1:-1]
    ]
    return len(whole) >= 0.8 * len(stripped)


def _first_row(lines: Sequence[str], rules: RowRules, style: NumberStyle, share: float) -> int | None:
    """The index of the first line that is a row of the table, followed by rows."""
    filled = [k for k, line in enumerate(lines) if _is_filled(line)]

    @cache
    def fits(at: int) -> bool:
        cells = split_cells(lines[filled[at]], rules)
        return len(cells) == rules.width and value_share(cells, style) >= share / 2

    for at, k in enumerate(filled):
        if not fits(at):
            continue
        following = [fits(later) for later in range(at, min(at + 3, len(filled)))]
        if all(following) or (at + 3 >= len(filled) and sum(following) >= len(following) - 1):
            return k
    return None


def _before_broken_rows(lines: Sequence[str], first: int, rules: RowRules, style: NumberStyle) -> int:
    """The first line behind the header, where the rows begin with some that are too short or too long.

    They are then counted as rejected like those further down, and do not part the header from its table.
    """
    at = first
    while at > 0 and first - at < _BROKEN_ROWS:
        above = split_cells(lines[at - 1], rules)
        if len(above) == rules.width:
            return at if value_share(above, style) <= 0.2 else first
        if not _is_filled(lines[at - 1]) or value_share(above, style) < 1:
            return first
        at -= 1
    return first


def _name_columns(
    lines: Sequence[str], first: int, rules: RowRules, style: NumberStyle, rows: Sequence[tuple[str, ...]]
) -> tuple[tuple[ColumnName, ...], RowRules, list[str]]:
    """Names and units from the lines above the first row; also the rules, with what the header taught."""
    notes: list[str] = []
    empty_end = rules.width > 2 and all(not row[-1] for row in rows if len(row) == rules.width)
    above: list[tuple[list[str], str | None]] = []
    other_width = 0
    for line in [line for line in lines[:first] if line.strip(_NO_CELLS)][-_HEADER_LINES:][::-1]:
        header, note = _fit_header(
            split_cells(_COMMENT_START.sub("", line), rules), rules.width, empty_end, rows
        )
        if header is None or not _may_name(header, style, nearest=not above):
            other_width = other_width or len(split_cells(line, rules))
            break
        above.append((header, note))
    if not above:
        notes.append(
            f"{_why_nameless(other_width, rules.width)} the columns are called column_1 to column_{rules.width}"
        )
        plain = tuple(ColumnName("", f"column_{k + 1}") for k in range(rules.width))
        return plain, rules, notes
    above = [each for each in above if not _is_type_row(each[0])] or above
    unit_at = next((k for k, (row, _) in enumerate(above[:-1]) if _is_unit_row(row)), None)
    header, note = _with_time(above if unit_at is None else above[unit_at + 1 :], notes)
    if note:
        notes.append(note)
    columns = [split_header(name) for name in header]
    if unit_at is not None:
        columns, contradicted = with_unit_row(columns, above[unit_at][0])
        notes += contradicted
    names, repeated = unique_names(columns)
    for name in repeated:
        notes.append(f"the column name {name!r} is repeated: further columns are called {name}_2 and so on")
    if empty_end and not header[-1]:
        rules = replace(rules, min_width=rules.width - 1)
        # a separator that ends every row makes no column that anybody wants told of
        names = (*names[:-1], replace(names[-1], name=ROW_END))
    return names, rules, notes


def _why_nameless(above: int, width: int) -> str:
    """Why the columns get names of cogest's own. above: cells of the line above the rows, 0 without one."""
    if not above:
        return "no header:"
    if above == width:
        return "the line above the rows holds numbers where names would stand, so"
    return f"the line above the rows has {above} columns and the rows {width}, so"


def _may_name(row: Sequence[str], style: NumberStyle, *, nearest: bool) -> bool:
    """Whether a row above the table names its columns, or their units. nearest: it stands right above the rows.

    There some names may be digits ("1", "2" of an exporter that names a sensor's first axis alone), if most are words and
    none is twice.
    """
    share = value_share(row, style)
    if share <= _NUMBERS_IN_NAMES or not nearest:
        return share <= _NUMBERS_IN_NAMES
    if share >= _DIGITS_IN_NAMES:
        return False
    words = [cell.casefold() for cell in row if any(letter.isalpha() for letter in cell)]
    others = [cell for cell in row if cell and not any(letter.isalpha() for letter in cell)]
    named = len(set(words)) == len(words) and not any(map(is_missing, words))
    return (named or _is_unit_row(row)) and all(_DIGITS.fullmatch(cell) for cell in others)


def _with_time(
    above: Sequence[tuple[list[str], str | None]], notes: list[str]
) -> tuple[list[str], str | None]:
    """The row of names: the last above the rows, unless that has no time and one above it has, which it then describes."""
    timed = [all(row) and any(is_called_time(split_header(cell)) for cell in row) for row, _ in above]
    # two cells that stand alone can be a remark ("Date", "morning")
    if len(above[0][0]) < 3 or True not in timed or any(map(is_called_time, map(split_header, above[0][0]))):
        return above[0]
    notes.append("the header's last row holds descriptions: the names are those of the row above it")
    return above[timed.index(True)]


def _is_unit_row(row: Sequence[str]) -> bool:
    """Whether most of what stands in a row are units."""
    kept = [cell for cell in row if cell]
    return bool(kept) and sum(is_unit(cell) for cell in kept) >= 0.5 * len(kept)


def _is_type_row(row: Sequence[str]) -> bool:
    """Whether a row says how each column's numbers are stored, as INCA's ASCII files do: "f8", "f8", "i4"."""
    return len(set(row)) < len(row) and all(_TYPE.fullmatch(cell) for cell in row)


def _fit_header(
    header: list[str], width: int, empty_end: bool, rows: Sequence[tuple[str, ...]]
) -> tuple[list[str] | None, str | None]:
    """Bring a header to the rows' width where it is certain how; None where it is not."""
    if len(header) == width:
        return header, None
    of_labview = header[0] == "X_Value" and header[-1] == "Comment"
    if len(header) == width + 1 and (not header[-1] or of_labview):
        return header[:-1], None
    if len(header) > width:
        joined = _join_brackets(header)
        if len(joined) == width:
            return joined, "a separator stands inside brackets in the header; the pieces were joined"
        return None, None
    if len(header) == width - 1:
        if empty_end:
            return [*header, ""], None
        counted = [row[0] for row in rows[:50]]
        if len(counted) > 2 and all(
            a.isdigit() and b.isdigit() and int(b) == int(a) + 1 for a, b in pairwise(counted)
        ):
            return ["row", *header], "the header has no name for the first column, which counts the rows"
    return None, None


def _join_brackets(cells: Sequence[str]) -> list[str]:
    """Join cells while a bracket stands open: "pos(x" and "y)" are one name."""
    joined: list[str] = []
    for cell in cells:
        if joined and sum(joined[-1].count(c) for c in "([{") > sum(joined[-1].count(c) for c in ")]}"):
            joined[-1] = f"{joined[-1]},{cell}"
        else:
            joined.append(cell)
    return joined


def number_columns(table: TextTable) -> tuple[bool, ...]:
    """For each column, whether its sampled cells are numbers (or all missing)."""
    result = []
    for cells, count in zip(table.columns, table.counts, strict=True):
        if has_fractions(cells, table.style):
            # its other cells would be read as groups of digits
            result.append(False)
            continue
        # a word for "missing" is no number: the cells are only looked at one by one where that could matter
        result.append(count >= 0.5 * len(cells) or count >= 0.5 * sum(not is_missing(cell) for cell in cells))
    return tuple(result)
