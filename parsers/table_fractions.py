"""Times of day whose milliseconds lack the zeros before them: what stands behind the seconds is no decimal fraction."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

_SECONDS = re.compile(r"(\d{1,2}):(\d{1,2}):(\d{1,2})(?:[.,:](\d+))?")
_DAY_MS = 86_400_000
_LEAST_BACK = 2
"""Decimals that are none make the clock go back once in most seconds: once alone can be a row out of order."""


def unpadded(cells: Sequence[str]) -> bool:
    """Whether times of day go on only if their one to three digits behind the seconds are whole milliseconds.

    cells: of one column, in the log's order.
    """
    found = [match for cell in cells if (match := _SECONDS.search(cell))]
    digits = [match[4] or "" for match in found]
    if len({len(each) for each in digits if each}) < 2 or max(map(len, digits)) > 3:
        return False
    seconds = np.array([(int(m[1]) * 60 + int(m[2])) * 60 + int(m[3]) for m in found]) * 1000
    whole = seconds + np.array([int(each or 0) for each in digits])
    decimal = seconds + np.array([int(each.ljust(3, "0")) if each else 0 for each in digits])
    back = _steps_back(decimal)
    return back >= _LEAST_BACK and _steps_back(whole) * 10 < back


def _steps_back(milliseconds: np.ndarray) -> int:
    """How often times of day go back, over midnight or not."""
    step = (np.diff(milliseconds) + _DAY_MS // 2) % _DAY_MS - _DAY_MS // 2
    return int(np.count_nonzero(step < 0))
