"""Counters of time that start again: 16 or 32 bits of milliseconds or microseconds, seconds of a day or week.

Those with a sign go from half their count to the negative half.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from parsers.importer import ImportLog
from parsers.quantiles import quantile
from parsers.table_stamps import DAY_NS

_NEAR_STEPS = 20
_MOST_STEPS_BACK = 1000
_SECOND_NS = 1_000_000_000
HOUR_NS = 3600 * _SECOND_NS
_NEAR_DAY_NS = 23 * HOUR_NS
"""A step back of so much within one date is midnight: a pause there of less than an hour is likelier than a clock that was set so far."""


def turns_of(unit_ns: int) -> tuple[int, ...]:
    """After how many nanoseconds a counter may start again, whose column is in `unit_ns`."""
    turns = {bits * unit for bits in (2**16, 2**24, 2**32) for unit in (unit_ns, 1000, 1_000_000)}
    turns |= {86_400 * _SECOND_NS, 604_800 * _SECOND_NS}
    return tuple(sorted(turn for turn in turns if _SECOND_NS <= turn < 2**61))


@dataclass
class Counter:
    """Follows blocks of stamps, and lets a counter run on where it starts again.

    It does so only where the stamps come close to a counter's end, by some usual steps, and go on as close to where it starts: at zero, or
    with a sign at the negative end.
    """

    turns: tuple[int, ...]
    log: ImportLog
    _turned: int = 0
    _last: int | None = None

    def follow(self, raw: IntArray) -> IntArray:
        """Stamps that run on, (n,), of those that were written."""
        before = raw[:1] if self._last is None else np.array([self._last])
        steps = np.diff(np.concatenate([before, raw]))
        self._last = int(raw[-1])
        back = np.flatnonzero(steps < -_SECOND_NS // 2)
        if 0 < len(back) <= _MOST_STEPS_BACK and (steps > 0).any():
            near = _NEAR_STEPS * int(quantile(steps[steps > 0], 0.5))
            added = np.zeros(len(raw), dtype=np.int64)
            for at in back.tolist():
                turn = self._turn(int(raw[at] - steps[at]), int(raw[at]), near)
                added[at] = turn
            if added.any():
                runs_on = raw + self._turned + np.cumsum(added)
                self._turned += int(added.sum())
                return runs_on
        return raw + self._turned if self._turned else raw

    def _turn(self, last: int, first: int, near: int) -> int:
        """What a counter counted to that showed `last` and then `first`; 0 where it was none."""
        for turn in self.turns:
            for start, where in ((0, "at zero"), (-turn // 2, "at its negative end")):
                end = start + turn
                if end - near <= last <= end and start <= first <= start + near and 4 * near < turn:
                    self.log.note(
                        f"the time column is a counter that starts again {where} after {turn / _SECOND_NS:g} s: it runs on"
                    )
                    return turn
        return 0


@dataclass
class StandingDate:
    """Follows blocks of stamps of a date and a time of day, and lets them run on over midnight where the date stays what it was.

    Loggers write the date of the start all along, or change it some rows late.
    """

    log: ImportLog
    _days: int = 0
    _last: int | None = None

    def follow(self, raw: IntArray) -> IntArray:
        """Stamps that run on, (n,), of those that were written."""
        before = raw[:1] if self._last is None else np.array([self._last])
        whole = np.concatenate([before, raw])
        self._last = int(raw[-1])
        steps = np.diff(whole)
        turns = np.flatnonzero(np.abs(steps) >= _NEAR_DAY_NS)
        if len(turns) > _MOST_STEPS_BACK:
            turns = turns[:0]
        added = np.zeros(len(raw), dtype=np.int64)
        added[0] = self._days
        for at in turns.tolist():
            back = -DAY_NS < steps[at] < 0 and whole[at] // DAY_NS == whole[at + 1] // DAY_NS
            # the date that comes late takes back what was added for it
            late = 0 < steps[at] <= DAY_NS + _SECOND_NS and self._days > 0
            if back or late:
                moved = 1 if back else -1
                self._days += moved
                added[at] += moved
                self.log.note("the date stays the same over midnight: the times run on into the next day")
        return raw + np.cumsum(added) * DAY_NS if added.any() else raw
