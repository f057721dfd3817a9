"""Quantiles of long columns without sorting them: a sample says between which values to look. All results are exact."""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray

T = TypeVar("T", np.int64, np.float64)

_SAMPLE = 1009
_FEW = 4096
_ASIDE = 0.025


def _sample(values: NDArray[Any]) -> NDArray[Any]:
    """Some of the values, in order. Blocks of neighbours would do worse: a signal rests at times."""
    return np.sort(values[:: max(1, len(values) // _SAMPLE)])


def quantile(values: NDArray[Any], share: float) -> float:
    """The quantile of finite values at `share` (0-1), as `numpy.quantile` has it. values: (n,), at least one."""
    return quantiles(values, share)[0]


def quantiles(values: NDArray[Any], *shares: float) -> tuple[float, ...]:
    """Several of `quantile`."""
    ordered = _sample(values) if len(values) >= _FEW else values
    return tuple(_quantile(values, ordered, share) for share in shares)


def _quantile(values: NDArray[Any], ordered: NDArray[Any], share: float) -> float:
    """ordered: some of the values, in order."""
    n = len(values)
    place = (n - 1) * share
    first = math.floor(place)
    last = min(first + 1, n - 1)
    below, middle = 0, values
    if n >= _FEW:
        below, middle = _between(values, ordered, share)
        if first < below or last - below >= len(middle):
            below, middle = 0, values
    part = np.partition(middle, (first - below, last - below))
    a, b = float(part[first - below]), float(part[last - below])
    # numpy's own way to interpolate, to the last bit; numpy's quantile itself would load its masked arrays first
    way = place - first
    return a + (b - a) * way if way < 0.5 else b - (b - a) * (1 - way)


def _between(values: NDArray[Any], ordered: NDArray[Any], share: float) -> tuple[int, NDArray[Any]]:
    """The values around where a quantile should be, and how many are below them."""
    low = ordered[max(int((share - _ASIDE) * len(ordered)), 0)]
    high = ordered[min(int((share + _ASIDE) * len(ordered)), len(ordered) - 1)]
    if share <= _ASIDE:
        return 0, values[values <= high]
    if share >= 1 - _ASIDE:
        above = values[values >= low]
        return len(values) - len(above), above
    return int(np.count_nonzero(values < low)), values[(values >= low) & (values <= high)]


def median(values: FloatArray) -> float:
    """The median of those that are not NaN, NaN where none is (`numpy.median` would load numpy's masked arrays first)."""
    known = values[~np.isnan(values)]
    return quantile(known, 0.5) if len(known) else math.nan


def medians(rows: FloatArray) -> FloatArray:
    """The median of each column of (m, n), NaN where one of its values is NaN (`numpy.median` would load numpy's masked arrays)."""
    ordered = np.sort(rows, axis=0)
    middle = 0.5 * (ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2])
    # NaN comes last in order
    return np.asarray(np.where(np.isnan(ordered[-1]), np.nan, middle))


def distinct(values: NDArray[T]) -> NDArray[T]:
    """The different values in order (`numpy.unique` would load numpy's masked arrays first)."""
    ordered = np.sort(values)
    return ordered[np.append(True, ordered[1:] != ordered[:-1])] if len(ordered) else ordered


def median_step(time_ns: IntArray) -> float:
    """The median difference of two neighbours, ns. time_ns: (n,) increasing, at least two."""
    return quantile(np.diff(time_ns), 0.5)


def at_least(values: FloatArray, share: float) -> float:
    """Something that the quantile at `share` is not below, and usually not far from it; -inf where none is found."""
    ordered = _sample(values)
    guess = float(ordered[max(int((share - 0.05) * len(ordered)), 0)])
    # so many values are at or above the guess that the quantile, between two of them, cannot be below it
    enough = np.count_nonzero(values >= guess) >= (1 - share) * len(values) + 2
    return guess if enough else -np.inf


def spread_at_least(values: FloatArray, outside: float) -> float:
    """Something that the distance of the quantiles at `outside` and 1 - `outside` is not below; -inf for none."""
    ordered = _sample(values)
    aside = int((outside + 0.05) * len(ordered))
    low, high = float(ordered[aside]), float(ordered[-1 - aside])
    enough = outside * len(values) + 2
    if np.count_nonzero(values <= low) < enough or np.count_nonzero(values >= high) < enough:
        return -np.inf
    return high - low
