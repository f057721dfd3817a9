"""Columns whose decimal sign is not their table's: a program's time stamps with points beside a country's values with commas."""

from __future__ import annotations

import re
from collections.abc import Sequence

from parsers.table_cells import NumberStyle, is_missing


def _other(style: NumberStyle) -> NumberStyle:
    return NumberStyle("." if style.decimal == "," else ",")


def has_fractions(cells: Sequence[str], style: NumberStyle) -> bool:
    """Whether what a table takes for groups of digits are fractions in a column: nobody groups digits behind a nought."""
    sign = _other(style).decimal
    if style.thousands != sign:
        return False
    found = re.compile(rf"[+-]?0+{re.escape(sign)}\d")
    return any(found.match(cell) for cell in cells)


def without_groups(style: NumberStyle, columns: Sequence[Sequence[str]]) -> NumberStyle:
    """The style without groups of digits where all columns that seem to have some hold fractions."""
    if style.thousands != _other(style).decimal:
        return style
    grouped = [
        cells
        for cells in columns
        if any(style.thousands in cell for cell in cells if style.pattern.fullmatch(cell))
    ]
    if any(not has_fractions(cells, style) for cells in grouped):
        return style
    return NumberStyle(style.decimal)


def has_other_point(cells: Sequence[str], style: NumberStyle, *, seconds: bool) -> bool:
    """Whether a time column's numbers have the other decimal sign, point or comma, than their table's. seconds: their unit may be a second or longer.

    Groups of three digits in every cell are none where they would count seconds: the first ones and the last ones have other counts.
    """
    other, plain = _other(style), NumberStyle(style.decimal)
    kept = [cell for cell in cells if not is_missing(cell)]
    if not kept or other.count(kept) < len(kept) or plain.count(kept) == len(kept):
        return False
    if style.count(kept) < len(kept) or has_fractions(kept, style):
        return True
    return seconds and all(re.fullmatch(rf"[+-]?\d+{re.escape(other.decimal)}\d{{3}}", cell) for cell in kept)
