"""Rows of a table that share a stamp: a clock in coarser steps than the rows come in, or one row for each signal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.importer import ImportLog
from parsers.quantiles import quantile

LEAST_SHARE = 0.02
"""Where fewer rows repeat the stamp before, the last of equal ones is kept, as for any log."""
_COARSE_SHARE = 0.3
_TWICE, _CHANGING = 0.95, 0.5
"""Rows are written twice where nearly all that share a stamp are equal, and most that do not are different: of a vehicle at rest both are equal."""
_APART, _ALONE, _AS_THEY_ARE = "apart", "alone", "as they are"


def repeat_share(cells: Sequence[str]) -> float:
    """Share of the rows whose time cells are those of the row before."""
    pairs = [a == b for a, b in pairwise(cells) if a and b]
    return sum(pairs) / len(pairs) if pairs else 0.0


@dataclass
class RepeatedStamps:
    """Follows blocks of rows; the rows of the last stamp wait for the next block.

    Where each of the rows with one stamp fills other columns, they become one row. Where they are samples, and so many
    that the clock must be too coarse for them, they are spread evenly up to the next stamp: what a column of whole seconds
    says of 50 rows a second.
    """

    log: ImportLog
    _how: str = ""
    _twice: bool | None = None
    _first: bool = True
    _usual: tuple[float, float] = (0.0, 1.0)
    _time_ns: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    _numbers: FloatArray | None = None

    def take(self, time_ns: IntArray, numbers: FloatArray) -> tuple[IntArray, FloatArray]:
        """Rows that are settled. time_ns: (rows,); numbers: (n, rows)."""
        time_ns, numbers = self._once(*self._joined(time_ns, numbers))
        starts = _starts(time_ns)
        if not self._how:
            self._how = self._chosen(time_ns, numbers, starts)
        if self._how == _AS_THEY_ARE:
            return time_ns, numbers
        held = int(starts[-1])
        self._time_ns, self._numbers = time_ns[held:].copy(), numbers[:, held:].copy()
        return self._settle(time_ns[:held], numbers[:, :held], int(time_ns[held]))

    def finish(self) -> tuple[IntArray, FloatArray] | None:
        """The rows that still wait."""
        if self._numbers is None or not len(self._time_ns):
            return None
        time_ns, numbers = self._time_ns, self._numbers
        self._time_ns, self._numbers = time_ns[:0], None
        return self._settle(time_ns, numbers, None)

    def _once(self, time_ns: IntArray, numbers: FloatArray) -> tuple[IntArray, FloatArray]:
        """Without the rows that say what the row before says, stamp and all, where the log was written so."""
        if self._twice is False:
            return time_ns, numbers
        same = np.diff(time_ns) == 0
        equal = np.ones(len(same), dtype=np.bool_)
        for column in numbers:
            before, after = column[:-1], column[1:]
            equal &= (before == after) | (np.isnan(before) & np.isnan(after))
        if self._twice is None:
            self._twice = bool(
                len(numbers)
                and same.any()
                and not same.all()
                and float(np.mean(equal[same])) >= _TWICE
                and float(np.mean(equal[~same])) < _CHANGING
            )
            if not self._twice:
                return time_ns, numbers
        again = np.concatenate([[False], same & equal])
        self.log.reject("row that repeats the row before, stamp and all", int(again.sum()))
        return time_ns[~again], numbers[:, ~again]

    def _joined(self, time_ns: IntArray, numbers: FloatArray) -> tuple[IntArray, FloatArray]:
        if self._numbers is None:
            return time_ns, numbers
        return np.concatenate([self._time_ns, time_ns]), np.concatenate([self._numbers, numbers], axis=1)

    def _chosen(self, time_ns: IntArray, numbers: FloatArray, starts: IntArray) -> str:
        repeated = 1 - len(starts) / len(time_ns)
        if repeated < LEAST_SHARE:
            return _AS_THEY_ARE
        most = [int(np.add.reduceat(np.isfinite(row), starts).max()) for row in numbers]
        if most and max(most) <= 1:
            self.log.note("rows with one stamp fill different columns: they are taken as one row")
            return _ALONE
        if repeated < _COARSE_SHARE or len(starts) < 3:
            return _AS_THEY_ARE
        step = quantile(np.diff(time_ns[starts]), 0.5)
        rows = quantile(np.diff(starts), 0.5)
        self._usual = max(step, 1.0), max(rows, 1.0)
        self.log.note(
            f"the clock's steps of {step / 1e9:g} s are coarser than the rows, of which {rows:g} share a stamp: they are "
            "spread evenly up to the next stamp, so that the time of a row is good to such a step only"
        )
        return _APART

    def _settle(
        self, time_ns: IntArray, numbers: FloatArray, next_ns: int | None
    ) -> tuple[IntArray, FloatArray]:
        if not len(time_ns):
            return time_ns, numbers
        starts = _starts(time_ns)
        if self._how == _ALONE:
            return time_ns[starts], _together(numbers, starts)
        spread = self._spread(time_ns, starts, next_ns)
        self._first = False
        return spread, numbers

    def _spread(self, time_ns: IntArray, starts: IntArray, next_ns: int | None) -> IntArray:
        step, rows = self._usual
        stamps = time_ns[starts].astype(np.float64)
        counts = np.diff(starts, append=len(time_ns))
        ends = np.append(stamps[1:], stamps[-1] + step if next_ns is None else next_ns)
        usual = (ends - stamps > 0) & (ends - stamps < 1.5 * step)
        width = np.where(usual, ends - stamps, step)
        # the first and the last stamp may stand for a part of their rows only
        apart = width / counts
        if self._first:
            apart[0] = min(apart[0], step / rows)
            stamps[0] += width[0] - counts[0] * apart[0]
        if next_ns is None:
            apart[-1] = min(apart[-1], step / rows)
        within = np.arange(len(time_ns)) - np.repeat(starts, counts)
        return np.round(np.repeat(stamps, counts) + within * np.repeat(apart, counts)).astype(np.int64)


def _starts(time_ns: IntArray) -> IntArray:
    """The first row of each stamp."""
    return np.flatnonzero(np.concatenate([[True], np.diff(time_ns) != 0]))


def _together(numbers: FloatArray, starts: IntArray) -> FloatArray:
    """One row for each stamp: in each column the last value that there is."""
    rows = np.arange(numbers.shape[1])
    merged = np.empty((len(numbers), len(starts)))
    for row, column in zip(merged, numbers, strict=True):
        last = np.maximum.reduceat(np.where(np.isfinite(column), rows, -1), starts)
        row[:] = np.where(last >= 0, column[last], np.nan)
    return merged
