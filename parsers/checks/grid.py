"""Signals of different rates on one coarse clock, and how two of them go together.

Checks look at seconds, not at samples: all signals are averaged into cells of 0.1 s, which also takes noise away.
Only seconds in which some signal has samples are on the clock, so that its length is bounded by the data.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.drive import Signal

CELL_NS = 100_000_000
CELL_S = CELL_NS / 1e9
BRIDGE_S = 0.5
"""Between two samples further apart than this nothing is interpolated (a slow signal: than 1.6 of its periods)."""
_SLOWEST_BRIDGE_S = 2.2
_MAX_LAG = 3
MIN_CELLS = 20

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Grid:
    """Cells. time_s: (n,) from the drive's start. columns: signal -> (n,), NaN where it has no value."""

    time_s: FloatArray
    columns: Mapping[str, FloatArray]

    def get(self, name: str) -> FloatArray | None:
        """A signal's column, or None where the drive has no such signal."""
        return self.columns.get(name)

    def rate(self, values: FloatArray) -> FloatArray:
        """Time derivative over two cells, NaN at the borders of what is contiguous."""
        result = np.full(len(values), np.nan)
        if len(values) > 2:
            span = self.time_s[2:] - self.time_s[:-2]
            whole = np.abs(span - 2 * CELL_S) < CELL_S / 2
            steps = (values[2:] - values[:-2]) / np.where(whole, span, 1.0)
            result[1:-1] = np.where(whole, steps, np.nan)
        return result


def make_grid(signals: Mapping[str, Signal]) -> Grid:
    """Bring signals onto cells of 0.1 s."""
    signals = {name: signal for name, signal in signals.items() if len(signal.time_ns)}
    if not signals:
        return Grid(np.empty(0), {})
    start = min(int(signal.time_ns[0]) for signal in signals.values())
    per_second = 10**9 // CELL_NS
    seconds = _union((signal.time_ns - start) // 10**9 for signal in signals.values())
    cells = (seconds[:, None] * per_second + np.arange(per_second)).reshape(-1)
    columns = {name: _fill(signal, start, cells) for name, signal in signals.items()}
    return Grid(np.asarray((cells + 0.5) * CELL_S, dtype=np.float64), columns)


def _union(parts: Iterable[IntArray]) -> IntArray:
    return np.unique(np.concatenate([np.unique(part) for part in parts]))


def _fill(signal: Signal, start: int, cells: IntArray) -> FloatArray:
    """Means of the samples in each cell; between them linear, where the samples are near enough."""
    at = np.searchsorted(cells, (signal.time_ns - start) // CELL_NS)
    count = np.bincount(at, minlength=len(cells)).astype(np.float64)
    total = np.bincount(at, weights=signal.values, minlength=len(cells))
    filled = count > 0
    values = np.full(len(cells), np.nan)
    values[filled] = total[filled] / count[filled]
    have = np.flatnonzero(filled)
    if len(have) < 2:
        return values
    steps = np.diff(signal.time_ns)
    usual = float(np.median(steps)) / 1e9
    bridge = max(BRIDGE_S, min(1.6 * usual, _SLOWEST_BRIDGE_S))
    after = np.minimum(np.searchsorted(have, np.arange(len(cells)), side="left"), len(have) - 1)
    before = np.maximum(np.searchsorted(have, np.arange(len(cells)), side="right") - 1, 0)
    left, right = have[before], have[after]
    span = (cells[right] - cells[left]) * CELL_S
    near = ~filled & (right > left) & (span <= bridge)
    share = (cells[near] - cells[left[near]]) * CELL_S / span[near]
    values[near] = values[left[near]] + share * (values[right[near]] - values[left[near]])
    return values


@dataclass(frozen=True)
class Together:
    """How two columns go together. correlation: at the best lag of up to 0.3 s, sign included. seconds: how long both
    are there and moving. ratio: spread of the first over spread of the second (a slope free of noise bias)."""

    correlation: float
    seconds: float
    ratio: float

    @property
    def sign(self) -> int:
        """+1 or -1."""
        return 1 if self.correlation > 0 else -1


def compare(
    first: FloatArray, second: FloatArray, where: BoolArray | None = None, *, centred: bool = True
) -> Together | None:
    """Compare two columns where both have values. None where there is too little or one stands still.

    centred: take the means away first (for angles with a mounting offset); not for turn rates, where a steady circle
    has no variation but a clear sign.
    """
    best: Together | None = None
    for lag in range(-_MAX_LAG, _MAX_LAG + 1):
        found = _at_lag(first, second, where, lag, centred)
        if found is not None and (best is None or abs(found.correlation) > abs(best.correlation) + 0.01):
            best = found
    return best


def _at_lag(
    first: FloatArray, second: FloatArray, where: BoolArray | None, lag: int, centred: bool
) -> Together | None:
    if len(first) <= 2 * _MAX_LAG:
        return None
    mask = np.isfinite(first) if where is None else np.isfinite(first) & where
    a = np.where(mask, first, np.nan)[_MAX_LAG : len(first) - _MAX_LAG]
    b = second[_MAX_LAG + lag : len(second) - _MAX_LAG + lag]
    both = np.isfinite(a) & np.isfinite(b)
    if int(both.sum()) < MIN_CELLS:
        return None
    a, b = clip(a[both]), clip(b[both])
    if centred:
        a, b = a - a.mean(), b - b.mean()
    norm_a, norm_b = float(np.sqrt(np.mean(a * a))), float(np.sqrt(np.mean(b * b)))
    if norm_a <= 0 or norm_b <= 0:
        return None
    return Together(float(np.mean(a * b)) / norm_a / norm_b, len(a) * CELL_S, norm_a / norm_b)


def clip(values: FloatArray) -> FloatArray:
    """Bring the outermost half per cent on either side to the border, so that stray values do not decide."""
    low, high = np.quantile(values, [0.005, 0.995])
    return np.clip(values, low, high)


def size(values: FloatArray, share: float = 0.99) -> float:
    """How large a column gets, stray values aside: a quantile of its magnitude; 0 where it is empty."""
    finite = values[np.isfinite(values)]
    return float(np.quantile(np.abs(finite), share)) if len(finite) else 0.0
