"""Whether a table was cut within its last cell: "21" of "21.99" is a number too, and a wrong one."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from pathlib import Path

from parsers.csv_dialect import TextTable, number_columns
from parsers.errors import LogError
from parsers.table_cells import is_missing, split_cells
from parsers.table_text import Encoding, decode

_TAIL_BYTES = 256 * 1024
_MOST_ROWS = 100
_LEAST_ROWS = 3


def cut_cell(path: Path, encoding: Encoding, table: TextTable, times: Sequence[int], size: int) -> str | None:
    """The last cell of a table whose last line has no end, where it looks cut: shorter than all before it.

    None where the rows before it have cells as short, where there are none, or where the column is neither of numbers
    nor one of `times`. size: of the file. Raises LogError where the file cannot be read.
    """
    *lines, last = _last_lines(path, encoding, size)
    rules = table.rules
    row = split_cells(last, rules)
    place = len(row) - 1
    if last.lstrip().startswith("#") or not rules.min_width <= len(row) <= rules.width:
        return None
    is_time = place in times
    if not is_time and not number_columns(table)[place]:
        return None
    rows = (split_cells(line, rules) for line in reversed(lines))
    cells = (
        each[place] for each in rows if rules.min_width <= len(each) <= rules.width and place < len(each)
    )
    kept = (cell for cell in cells if is_time or is_missing(cell) or table.style.pattern.fullmatch(cell))
    above = list(islice(kept, _MOST_ROWS))
    if len(above) < _LEAST_ROWS:
        return None
    sign = table.style.decimal
    shorter = len(row[place]) < min(map(len, above))
    coarser = _decimals(row[place], sign) < min(_decimals(cell, sign) for cell in above)
    return row[place] if shorter or coarser else None


def _decimals(cell: str, sign: str) -> int:
    """How many characters stand behind a number's decimal sign."""
    return len(cell.partition(sign)[2])


def _last_lines(path: Path, encoding: Encoding, size: int) -> list[str]:
    """The last whole lines of a file, and what stands behind the last line end."""
    start = max(encoding.mark, size - _TAIL_BYTES)
    # UTF-16 has two bytes a character
    start += (start - encoding.mark) % 2
    try:
        with path.open("rb") as file:
            file.seek(start)
            raw = file.read(_TAIL_BYTES)
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    text = raw.decode(encoding.codec, "replace") if encoding.wide else decode(raw, encoding)
    lines = text.replace("\r", "\n").split("\n") if encoding.old_lines else text.split("\n")
    return lines if start == encoding.mark else lines[1:] or [""]
