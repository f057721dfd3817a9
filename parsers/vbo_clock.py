"""How a VBO log tells time: of which day its times of day are, and whether its time column is HHMMSS at all.

Other programs write seconds into the column. Of numbers that count seconds, many have a minute or second above 59.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta

import numpy as np

from parsers.channels import FloatArray
from parsers.importer import ImportLog
from parsers.table_lines import DECIMALS, HHMMSS, Clock
from parsers.vbo_header import VboHead

_SECOND_NS = 1_000_000_000
_CLOCKS: dict[bool, Clock] = {
    False: (HHMMSS, 0, 1, _SECOND_NS, 0),
    True: (DECIMALS, 0, 1, _SECOND_NS, 0),
}
_DAY_S = 86_400.0
_LEAST = 12
"""Seconds that are looked at, at least."""
_NO_CLOCKS = 0.1
"""A log of which as many seconds are no HHMMSS has another clock; damage spoils fewer."""
_IN_ORDER = 0.95
_OFF_S = 300.0
"""A head's date is written some minutes from the first row at the most, in any time zone."""


@dataclass(frozen=True)
class VboClock:
    """seconds: the times count seconds, where the format has HHMMSS. midnight: nanoseconds since 1970 of the midnight before the
    first row; None where the log has no date, or its seconds count from a zero of their own."""

    seconds: bool
    midnight: int | None

    @property
    def rule(self) -> Clock:
        """The time, for the kernel."""
        return _CLOCKS[self.seconds]


def of_day(times: FloatArray) -> FloatArray:
    """Seconds of the day of numbers that spell HHMMSS."""
    return np.asarray(times // 10000 * 3600 + times // 100 % 100 * 60 + times % 100)


def counts_seconds(times: FloatArray) -> bool:
    """Whether the times of rows at a few places, in the file's order, are no HHMMSS but seconds of a day or drive."""
    times = times[np.isfinite(times)]
    # numpy's unique would load masked arrays
    whole = np.sort(np.floor(times))
    whole = whole[np.diff(whole, prepend=-1.0) != 0]
    if len(whole) < _LEAST or times.min() < 0 or times.max() >= 2 * _DAY_S:
        return False
    odd = (whole % 100 >= 61) | (whole // 100 % 100 >= 60)
    return bool(odd.mean() > _NO_CLOCKS and (np.diff(times) >= 0).mean() >= _IN_ORDER)


def find_clock(
    head: VboHead, rows: Sequence[Sequence[str]], time_at: int, times: FloatArray, log: ImportLog
) -> VboClock:
    """How the rows tell time; what had to be decided is noted. rows: the first ones. times: of rows at a few places of the file."""
    cells = [row[time_at] for row in rows if time_at < len(row)]
    # before the unit knows the time it writes zero
    first = next((cell for cell in cells if cell.strip("0.,")), "")
    try:
        number = float(first.replace(",", "."))
    except ValueError:
        number = 0.0
    if not counts_seconds(times):
        return VboClock(False, _midnight(head, float(of_day(np.array([number]))[0]), log))
    said = f"the time column is no HHMMSS (it runs over {_odd(times)}): read as seconds"
    if head.created is None or not _is_of_day(head, number):
        log.note(f"{said} from a zero of the log's own, of which it does not say the moment")
        return VboClock(True, None)
    log.note(f"{said} of the day")
    return VboClock(True, _midnight(head, number, log))


def _odd(times: FloatArray) -> str:
    """The first time that is no HHMMSS, as text."""
    odd = times[(times % 100 >= 61) | (times // 100 % 100 >= 60)]
    return f"{odd[0]:.2f}"


def _is_of_day(head: VboHead, first_s: float) -> bool:
    """Whether the first row's seconds are the head's time of day, but for a time zone of whole half hours."""
    if head.created is None or first_s < _OFF_S:
        return False
    created = head.created.hour * 3600 + head.created.minute * 60 + head.created.second
    off = (first_s - created + 900) % 1800 - 900
    return abs(off) <= _OFF_S


def _midnight(head: VboHead, first_s: float, log: ImportLog) -> int | None:
    """Nanoseconds since 1970 of the midnight before the first row, at `first_s` of its day; None where the log has no date."""
    created = head.created
    if created is None:
        log.note("the log has no date of creation: its times count from midnight UTC of an unknown day")
        return None
    day = created.replace(hour=0, minute=0, second=0)
    if day + timedelta(seconds=first_s) > created + timedelta(hours=12):
        day -= timedelta(days=1)
    said = "as month/day/year, since the month would else be above 12; " if head.swapped_date else ""
    log.note(
        f"the date {day:%Y-%m-%d} is from 'File created on {created:%d/%m/%Y %H:%M}' ({said}the unit's clock may show "
        "local time, so near midnight the day can be off by one); the time of day is UTC"
    )
    return round(day.timestamp()) * _SECOND_NS
