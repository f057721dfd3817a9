"""Rows at places all over a table's file: what the first ones leave open, later ones may tell."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from parsers.table_cells import split_cells
from parsers.table_rows import RowRules
from parsers.table_text import Encoding, decode

_PLACES = 24
_PIECE = 1 << 14


def rows_all_over(path: Path, encoding: Encoding, rules: RowRules, size: int) -> Iterator[list[str]]:
    """The cells of whole lines at two dozen places of a file, in its order. Raises OSError where it cannot be read."""
    with path.open("rb") as file:
        for k in range(_PLACES):
            # two bytes a letter begin at even places
            file.seek(max(0, size - _PIECE) * (k + 1) // _PLACES // 2 * 2)
            data = file.read(_PIECE)
            text = data.decode(encoding.codec, "replace") if encoding.wide else decode(data, encoding)
            for line in text.splitlines()[1:-1]:
                yield split_cells(line, rules)
