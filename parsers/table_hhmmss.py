"""Times of day that are written as a number: 083856.30 is 08:38:56.30, as satellite receivers write it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from parsers.table_cells import is_missing
from parsers.table_places import rows_all_over
from parsers.table_rows import RowRules
from parsers.table_text import Encoding
from parsers.table_time_plan import TimePlan

UNIT = "hhmmss"
"""What a mapping file's [time] unit says for it."""
_CELL = re.compile(r"(?:[01]\d|2[0-3])[0-5]\d[0-5]\d(?:[.,]\d+)?")
_LEAST = 12


def could_be(plan: TimePlan, cells: Sequence[str]) -> bool:
    """Whether seconds of no stated unit may be HHMMSS as far as the first rows say."""
    return plan.guessed and plan.unit_ns == 1_000_000_000 and not plan.absolute and _all_clocks(cells)


def _all_clocks(cells: Sequence[str]) -> bool:
    kept = [cell for cell in cells if not is_missing(cell)]
    return bool(kept) and all(_CELL.fullmatch(cell) for cell in kept)


def is_it(
    plan: TimePlan, cells: Sequence[str], path: Path, encoding: Encoding, rules: RowRules, size: int
) -> bool:
    """Whether the rows at places all over the file are times of day as well.

    Of numbers that count seconds, 64 % of those with six digits have a minute or second above 59: a dozen that lie apart
    and have none are no accident. Where a log is too short for a dozen seconds, both ways tell the same steps but for the
    minute that it may pass. Raises OSError where the file cannot be read.
    """
    if encoding.wide:
        return False
    place = plan.columns[0]
    rows = [row for row in rows_all_over(path, encoding, rules, size) if place < len(row)]
    found = dict.fromkeys(row[place] for row in rows if not is_missing(row[place]))
    seconds = {cell[:6] for cell in (*found, *cells)}
    return len(seconds) >= _LEAST and _all_clocks([*found])


def as_time_of_day(plan: TimePlan, *, said: bool) -> TimePlan:
    """The plan with the column's numbers read as HHMMSS. said: the mapping file says so."""
    name = plan.clock.split('"')[1]
    notes = (
        f'column "{name}" holds the time of day as HHMMSS without a date: taken as a time that runs on over midnight',
    )
    if not said:
        notes = (notes[0] + '; if it counts seconds, state that in the map file: [time] unit = "s"',)
    return replace(plan, kind="hhmmss", clock=f'time of day (column "{name}")', notes=notes, guessed=False)
