"""The order of a date's parts where the first rows leave it open: 03/04/2024 is in April or in March, which later rows may tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

from parsers.table_cells import WITH_DATE
from parsers.table_guess import date_order
from parsers.table_places import rows_all_over
from parsers.table_rows import RowRules
from parsers.table_text import Encoding
from parsers.table_time_plan import TimePlan


def settle_order(
    plan: TimePlan,
    columns: Sequence[Sequence[str]],
    path: Path,
    encoding: Encoding,
    rules: RowRules,
    size: int,
) -> TimePlan:
    """The plan with the order that the dates all over the file tell. columns: their first cells. Raises OSError where it cannot be read."""
    last = max(plan.columns)
    rows = [row for row in rows_all_over(path, encoding, rules, size) if len(row) > last]
    first = zip(*(columns[k] for k in plan.columns), strict=True)
    cells = [*chain.from_iterable(first), *(row[k] for row in rows for k in plan.columns)]
    # a cell that is cut may begin with another date
    dates = [
        cell for cell in cells if (found := WITH_DATE.match(cell)) and not cell[found.end() :][:1].isdigit()
    ]
    if not dates:
        return plan
    order, note, open_yet = date_order(dates, cells)
    if open_yet:
        return plan
    notes = tuple(note if each == plan.two_ways else each for each in plan.notes)
    return replace(plan, order=order, notes=tuple(filter(None, notes)), two_ways="")
