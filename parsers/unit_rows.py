"""A table's row of units, and what the names above it say of theirs: where the two contradict each other, one of them is a template's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from parsers.table_names import ColumnName
from parsers.unit_words import is_unit, plain_unit, says_unit
from parsers.units import find_unit, quantities_of

_NAMED = 4


def with_unit_row(
    columns: Sequence[ColumnName], units: Sequence[str]
) -> tuple[list[ColumnName], tuple[str, ...]]:
    """The columns with the units of the row, and a note on those whose names state others."""
    told = [replace(c, unit=plain_unit(unit) or c.unit) for c, unit in zip(columns, units, strict=True)]
    differ = [
        f"{c.header} over {unit.strip()}"
        for c, unit in zip(columns, units, strict=True)
        if c.unit is not None and _contradict(c, unit)
    ]
    if not differ:
        return told, ()
    named = ", ".join(differ[:_NAMED]) + (f" and {len(differ) - _NAMED} more" if len(differ) > _NAMED else "")
    return told, (
        f"the names and the row of units below them state different units ({named}): the row's are taken; where they are wrong, "
        "a mapping file states the unit",
    )


def _contradict(column: ColumnName, unit: str) -> bool:
    """Whether a name's unit and the row's are two different ones. An ending of a name ("_g") must be of the same quantity at least."""
    stated, below = column.unit or "", plain_unit(unit) or ""
    if not (says_unit(stated) and says_unit(below) and is_unit(below)) or stated.lower() == below.lower():
        return False
    pairs = [
        (find_unit(stated, each), find_unit(below, each))
        for each in quantities_of(stated) & quantities_of(below)
    ]
    if not pairs:
        known = bool(quantities_of(stated) and quantities_of(below))
        return known and column.name != column.header
    return all(a is None or b is None or a.scale != b.scale for a, b in pairs)
