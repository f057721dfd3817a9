"""Rows of a VBO log without a position fix: the unit goes on writing zeros, or what it knew last, where there is nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import FloatArray
from parsers.importer import ImportLog
from parsers.table_stamps import BoolArray

PLACE = ("lat", "long")
TOLD_BY = ("sats", *PLACE, "velocity")
"""Columns that tell a row without a fix."""
NAVIGATION = ("velocity", *PLACE, "heading", "height", "vert-vel")
"""Columns that hold nothing then."""
FLAGGED_NOUGHT = (0.0, 64.0, 128.0, 192.0)
"""No satellite, as the count has it beside its flags."""


@dataclass
class NoFix:
    """Follows the rows of a log. places: row of each of TOLD_BY among the numbers, of those that are there; to_empty: of NAVIGATION."""

    log: ImportLog
    places: dict[str, int]
    to_empty: Sequence[int]
    _last: FloatArray = field(default_factory=lambda: np.full(3, np.nan))

    def apply(self, numbers: FloatArray) -> FloatArray:
        """The numbers (n, rows) with NaN where the unit had no fix: at 0° 0', or without satellites at one place and one speed above 0."""
        if not all(name in self.places for name in PLACE) or not self.to_empty or not numbers.shape[1]:
            return numbers
        lost = self._lost(numbers)
        count = int(np.count_nonzero(lost))
        if not count:
            return numbers
        self.log.reject("speed and place of a row without a position fix", count)
        numbers = numbers.copy()
        numbers[np.ix_(np.asarray(self.to_empty), np.flatnonzero(lost))] = np.nan
        return numbers

    def _lost(self, numbers: FloatArray) -> BoolArray:
        lat, long = (numbers[self.places[name]] for name in PLACE)
        lost = (lat == 0) & (long == 0)
        if "sats" in self.places and "velocity" in self.places:
            told = np.stack((lat, long, numbers[self.places["velocity"]]))
            before = np.column_stack((self._last, told[:, :-1]))
            self._last = told[:, -1].copy()
            blind = np.isin(numbers[self.places["sats"]], FLAGGED_NOUGHT)
            lost |= blind & (told == before).all(axis=0) & (told[2] != 0)
        return np.asarray(lost)
