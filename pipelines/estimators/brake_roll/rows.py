"""Rows near others, and means over a window, for columns of any length."""

from __future__ import annotations

import numpy as np

from pipelines.prepare.prepared import BoolArray
from pipelines.results import FloatArray


def window_sum(values: FloatArray, reach: int) -> FloatArray:
    """(n,) sum over the rows from `reach` before to `reach` behind each, as far as there are any."""
    total = np.concatenate(([0.0], np.cumsum(values)))
    rows = np.arange(len(values))
    last = np.minimum(rows + reach + 1, len(values))
    first = np.maximum(rows - reach, 0)
    return np.asarray(total[last] - total[first])


def window_mean(values: FloatArray, reach: int) -> FloatArray:
    """(n,) mean over the same rows."""
    return np.asarray(window_sum(values, reach) / np.maximum(window_sum(np.ones(len(values)), reach), 1.0))


def within(mask: BoolArray, reach: int) -> BoolArray:
    """(n,) rows that have a True among them."""
    return np.asarray(window_sum(mask.astype(np.float64), reach) > 0.5)
