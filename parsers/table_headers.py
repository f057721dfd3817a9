"""A second header among a table's rows: a recorder that began again, or two logs in one file. What follows may have other columns.

It is looked for only where a part of the file has words where numbers were expected, so that it costs good logs nothing.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from parsers.table_names import split_header
from parsers.table_rows import RowRules

MOST_LINES = 20_000
"""Lines of a part that begin with a letter which are looked at: where all do, the first column is text."""

MOST_BYTES = 64 * 1024
"""Of a line that is looked at."""

WORDS = 0.6
"""Least share of a header's cells that are words."""

_BEGINS = re.compile(rb"[\r\n][ \t]*[\"']?[ \t]*[A-Za-z\xb5\xc2-\xf4]")
_END = re.compile(rb"[\r\n]")
_NO_NAME = frozenset(
    ("nan", "na", "n/a", "null", "none", "inf", "infinity", "true", "false", "on", "off", "ok", "error", "err", "invalid")
)  # fmt: skip


def _cells(line: str, rules: RowRules) -> list[str]:
    quote = chr(rules.quote) if rules.quote >= 0 else '"'
    if rules.row_quotes:
        line = line.strip().strip(quote)
    parts = line.split() if rules.spaces else line.split(chr(rules.separator))
    return [part.strip().strip(quote).strip() for part in parts]


def _is_name(cell: str, rules: RowRules) -> bool:
    """Whether a cell is a word, and none that stands for a missing value."""
    if not any(c.isalpha() for c in cell) or cell.casefold() in _NO_NAME:
        return False
    plain = cell if rules.decimal < 0 else cell.replace(chr(rules.decimal), ".")
    try:
        float(plain)
    except ValueError:
        return True
    return False


def other_header(line: str, rules: RowRules, header: Sequence[str]) -> tuple[str, ...] | None:
    """A line's cells where they are names and not those of the table, else None. header: the table's own cells."""
    cells = _cells(line, rules)
    named = [cell for cell in cells if _is_name(cell, rules)]
    if len(named) < 2 or len(named) < WORDS * len(cells) or len(set(named)) < len(named):
        return None
    own = [cell.strip().casefold() for cell in header]
    found = [cell.casefold() for cell in cells]
    if found[: len(own)] == own:
        return None
    known = {split_header(cell).name for cell in own}
    again = sum(split_header(cell).name in known for cell in found)
    # a marker that somebody set has neither the table's names nor its width
    return tuple(cells) if 2 * again >= len(own) or len(cells) == len(own) > 2 else None


def second_header(
    path: Path, start: int, stop: int, rules: RowRules, codec: str, header: Sequence[str]
) -> tuple[int, tuple[str, ...]] | None:
    """Where another header than the table's begins in bytes start to stop of a file, and its cells; None where there is none.

    Raises OSError where the file cannot be read.
    """
    with path.open("rb") as file:
        # a line that begins at `start` is told by the line end before it
        file.seek(max(start - 1, 0))
        data = file.read(stop - max(start - 1, 0) + MOST_BYTES)
    base = max(start - 1, 0)
    for number, found in enumerate(_BEGINS.finditer(data)):
        begin = found.start() + 1
        if base + begin >= stop or number >= MOST_LINES:
            break
        end = _END.search(data, begin, begin + MOST_BYTES)
        line = data[begin : end.start() if end else begin + MOST_BYTES].decode(codec, "replace")
        cells = other_header(line, rules, header)
        if cells is not None:
            return base + begin, cells
    return None
