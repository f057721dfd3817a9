"""Signals of different rates on one coarse clock, and how two of them go together.

Checks look at seconds, not at samples: all signals are averaged into cells of 0.1 s, which also takes noise away.
Only seconds in which some signal has samples are on the clock, so that its length is bounded by the data.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.checks.far_lags import better_elsewhere
from parsers.drive import Signal
from parsers.quantiles import distinct, median_step, quantile, quantiles

CELL_NS = 100_000_000
CELL_S = CELL_NS / 1e9
BRIDGE_S = 0.5
"""Between two samples further apart than this nothing is interpolated (a slow signal: than 1.6 of its periods)."""
_SLOWEST_BRIDGE_S = 2.2
_MAX_LAG = 3
MIN_CELLS = 20
_SAYS, _NO_SIGN = 0.3, 1e-9
"""Least correlation that any check looks at; what is left of one that has no sign."""
EITHER_WAY = 0.8
"""Share of the best correlation from which on the best of the other sign, at another lag, leaves the sign open."""

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Grid:
    """Cells. time_s: (n,) from the drive's start. columns: signal -> (n,), NaN where it has no value.

    Of a grid that `make_grid` made, made_of: the signals that the columns are the means of; cells: (n,) their numbers.
    """

    time_s: FloatArray
    columns: Mapping[str, FloatArray]
    made_of: Mapping[str, Signal] = field(default_factory=dict)
    cells: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))

    def get(self, name: str) -> FloatArray | None:
        """A signal's column, or None where the drive has no such signal."""
        return self.columns.get(name)

    def scaled(self, factors: Mapping[str, float]) -> Grid:
        """The grid with some columns multiplied."""
        columns = {name: column * factors.get(name, 1.0) for name, column in self.columns.items()}
        return Grid(self.time_s, columns) if factors else self

    def without(self, names: Collection[str]) -> Grid:
        """The grid without some columns."""
        return Grid(self.time_s, {name: column for name, column in self.columns.items() if name not in names})

    def rate(self, values: FloatArray) -> FloatArray:
        """Time derivative over two cells, NaN at the borders of what is contiguous."""
        result = np.full(len(values), np.nan)
        if len(values) > 2:
            span = self.time_s[2:] - self.time_s[:-2]
            whole = np.abs(span - 2 * CELL_S) < CELL_S / 2
            steps = (values[2:] - values[:-2]) / np.where(whole, span, 1.0)
            result[1:-1] = np.where(whole, steps, np.nan)
        return result


def make_grid(signals: Mapping[str, Signal], before: Grid | None = None) -> Grid:
    """Bring signals onto cells of 0.1 s. before: a grid whose columns are taken over where their signals are the same."""
    signals = {name: signal for name, signal in signals.items() if len(signal.time_ns)}
    if not signals:
        return Grid(np.empty(0), {})
    start = min(int(signal.time_ns[0]) for signal in signals.values())
    columns: dict[str, FloatArray] = {}
    new = signals
    if before is not None and _stamps(signals).keys() == _stamps(before.made_of).keys():
        new = {name: signal for name, signal in signals.items() if before.made_of.get(name) is not signal}
        columns = {name: before.columns[name] for name in signals.keys() - new.keys()}
    # signals of one table share their stamps: what hangs on stamps alone is worked out once
    own = {key: (time_ns - start) // CELL_NS for key, time_ns in _stamps(new).items()}
    cells = before.cells if before is not None and new is not signals else _cells(own.values())
    places = {key: _place(time_ns, own[key], cells) for key, time_ns in _stamps(new).items()}
    columns |= {name: places[id(signal.time_ns)].fill(signal.values) for name, signal in new.items()}
    time_s = np.asarray((cells + 0.5) * CELL_S, dtype=np.float64)
    return Grid(time_s, {name: columns[name] for name in signals}, signals, cells)


def _stamps(signals: Mapping[str, Signal]) -> dict[int, IntArray]:
    """The different time vectors of some signals, each under its identity."""
    return {id(signal.time_ns): signal.time_ns for signal in signals.values()}


def _cells(own: Iterable[IntArray]) -> IntArray:
    """The numbers of all cells of the seconds in which there is any sample. own: of each time vector's samples."""
    per_second = 10**9 // CELL_NS
    seconds = _union(cell // per_second for cell in own)
    return (seconds[:, None] * per_second + np.arange(per_second)).reshape(-1)


def _union(parts: Iterable[IntArray]) -> IntArray:
    """What is in any of the parts, each of them in order."""
    return distinct(np.concatenate([part[np.append(True, part[1:] != part[:-1])] for part in parts]))


@dataclass(frozen=True)
class _Place:
    """Where the samples of one time vector fall. at: (n,) cell of each; count: (cells,) samples in it; filled: where
    there are any. near: cells between two filled ones that are near enough, left and right, share of the way."""

    at: IntArray
    count: FloatArray
    filled: IntArray
    near: IntArray
    left: IntArray
    right: IntArray
    share: FloatArray

    def fill(self, samples: FloatArray) -> FloatArray:
        """Means of the samples in each cell; between them linear, where the samples are near enough."""
        total = np.bincount(self.at, weights=samples, minlength=len(self.count))
        values = np.full(len(self.count), np.nan)
        values[self.filled] = total[self.filled] / self.count[self.filled]
        left = values[self.left]
        values[self.near] = left + self.share * (values[self.right] - left)
        return values


def _place(time_ns: IntArray, own: IntArray, cells: IntArray) -> _Place:
    """own: (n,) the cell number of each stamp; cells: the numbers of all cells, in order."""
    whole = int(cells[-1] - cells[0]) + 1 == len(cells)
    at = own - cells[0] if whole else np.searchsorted(cells, own)
    count = np.bincount(at, minlength=len(cells)).astype(np.float64)
    have = np.flatnonzero(count)
    none = np.zeros(0, dtype=np.int64)
    if len(have) < 2:
        return _Place(at, count, have, none, none, none, np.zeros(0))
    bridge = max(BRIDGE_S, min(1.6 * median_step(time_ns) / 1e9, _SLOWEST_BRIDGE_S))
    # the empty cells between two filled ones, each with the numbers of its neighbours in `have`
    empty = np.flatnonzero(count == 0)
    after = np.searchsorted(have, empty)
    inside = (after > 0) & (after < len(have))
    empty, after = empty[inside], after[inside]
    left, right = have[after - 1], have[after]
    span = (cells[right] - cells[left]) * CELL_S
    near = span <= bridge
    empty, left, right, span = empty[near], left[near], right[near], span[near]
    return _Place(at, count, have, empty, left, right, (cells[empty] - cells[left]) * CELL_S / span)


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
    has no variation but a clear sign. What swings so quickly that a lag turns it round has no sign: its correlation is what the
    one is better by than the other. Nor has what goes together better the other way round some seconds apart: there it is next to nought.
    """
    best: Together | None = None
    ends = [0.0, 0.0]
    if len(first) <= 2 * _MAX_LAG:
        return None
    mask = np.isfinite(first) if where is None else np.isfinite(first) & where
    inner = slice(_MAX_LAG, len(first) - _MAX_LAG)
    a, there, clipped = first[inner], mask[inner], np.zeros(0)
    last: BoolArray | None = None
    for lag in range(-_MAX_LAG, _MAX_LAG + 1):
        b = second[_MAX_LAG + lag : len(second) - _MAX_LAG + lag]
        both = there & np.isfinite(b)
        if int(np.count_nonzero(both)) < MIN_CELLS:
            continue
        if last is None or not np.array_equal(both, last):
            last, clipped = both, clip(a[both])
        found = go_together(clipped, clip(b[both]), centred)
        if found is not None:
            ends = [min(ends[0], found.correlation), max(ends[1], found.correlation)]
        if found is not None and (best is None or abs(found.correlation) > abs(best.correlation) + 0.01):
            best = found
    against, along = sorted(abs(end) for end in ends)
    if best is not None and against > EITHER_WAY * along:
        return replace(best, correlation=best.sign * (along - against))
    if best is None or abs(best.correlation) < _SAYS:
        return best
    # all of both, as what was picked by one of them is at another place in the other
    if better_elsewhere(_usual(first), _usual(second), best.sign, _MAX_LAG, centred=centred):
        return replace(best, correlation=best.sign * _NO_SIGN)
    return best


def _usual(values: FloatArray) -> FloatArray:
    """A column with stray values at the border of what is usual."""
    result, there = values.copy(), np.isfinite(values)
    result[there] = clip(values[there])
    return result


def go_together(a: FloatArray, b: FloatArray, centred: bool) -> Together | None:
    """How two columns without gaps go together as they stand; None where one stands still. centred: as in `compare`."""
    # a damaged log may hold numbers whose squares no float can hold: nothing can be said of those
    with np.errstate(over="ignore", invalid="ignore"):
        if centred:
            a, b = a - a.mean(), b - b.mean()
        norm_a, norm_b = float(np.sqrt(np.mean(a * a))), float(np.sqrt(np.mean(b * b)))
    if not (0 < norm_a < np.inf and 0 < norm_b < np.inf):
        return None
    return Together(float(np.mean(a * b)) / norm_a / norm_b, len(a) * CELL_S, norm_a / norm_b)


def clip(values: FloatArray) -> FloatArray:
    """Bring the outermost half per cent on either side to the border, so that stray values do not decide."""
    low, high = quantiles(values, 0.005, 0.995)
    return np.clip(values, low, high)


def size(values: FloatArray, share: float = 0.99) -> float:
    """How large a column gets, stray values aside: a quantile of its magnitude; 0 where it is empty."""
    finite = values[np.isfinite(values)]
    return quantile(np.abs(finite), share) if len(finite) else 0.0
