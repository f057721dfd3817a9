"""How often values occur in a column of any length, in bounded memory: for quantiles of what is never in memory whole."""

from __future__ import annotations

import math
from copy import copy

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel

_SLOTS = 1 << 14
_MOST = _SLOTS // 2
_FREE = -1
_FLOAT_SHIFT = 36
"""Of a float's 52 digits after the point 16 are looked at: 1 part in 65 000."""


@kernel
def count_keys(
    keys: IntArray, shift: int, slots: IntArray, counts: IntArray, used: int, most: int
) -> tuple[int, int]:
    """Count keys >> shift (not below 0) in a hash table; how many keys were counted before it was full, slots in use."""
    mask = slots.size - 1
    for i in range(keys.size):
        key = keys[i] >> shift
        at = ((key * 0x9E3779B97F4A7C1) >> 20) & mask
        while slots[at] != key and slots[at] != _FREE:
            at = (at + 1) & mask
        if slots[at] == _FREE:
            if used >= most:
                return i, used
            slots[at] = key
            used += 1
        counts[at] += 1
    return keys.size, used


class Counts:
    """Whole numbers from 0 on and how often each occurs: exact up to some thousand different ones, then rounded to 2**shift.

    total: how many were counted.
    """

    def __init__(self, shift: int = 0) -> None:
        """shift: digits that are not looked at from the start."""
        self.shift = shift
        self.total = 0
        self._clear()

    def _clear(self) -> None:
        self._slots = np.full(_SLOTS, _FREE, dtype=np.int64)
        self._counts = np.zeros(_SLOTS, dtype=np.int64)
        self._used = 0

    def copy(self) -> Counts:
        """The same counts, to go on separately."""
        other = copy(self)
        other._slots, other._counts = self._slots.copy(), self._counts.copy()
        return other

    def add(self, keys: IntArray) -> None:
        """Count (n,) numbers."""
        self.total += len(keys)
        while len(keys):
            done, self._used = count_keys(keys, self.shift, self._slots, self._counts, self._used, _MOST)
            keys = keys[done:]
            if len(keys):
                self._coarsen()

    def _coarsen(self) -> None:
        """Look at fewer digits, until half of the room is free again."""
        values, counts = self._sorted()
        while len(values) > _MOST // 2:
            self.shift += 1
            values, back = np.unique(values >> 1, return_inverse=True)
            counts = np.bincount(back, weights=counts).astype(np.int64)
        self._clear()
        # each value stands once for all of its kind: the counts are put right afterwards
        count_keys(values, 0, self._slots, self._counts, 0, _SLOTS)
        place = np.flatnonzero(self._slots != _FREE)
        self._counts[place] = counts[np.searchsorted(values, self._slots[place])]
        self._used = len(values)

    def _sorted(self) -> tuple[IntArray, IntArray]:
        used = np.flatnonzero(self._slots != _FREE)
        order = used[np.argsort(self._slots[used])]
        return self._slots[order], self._counts[order]

    def neighbours(self, share: float) -> tuple[int, int, float]:
        """The two numbers between which the quantile at `share` lies, and how far along the way."""
        values, counts = self._sorted()
        place = (self.total - 1) * share
        first = math.floor(place)
        ends = np.cumsum(counts)
        at = np.searchsorted(ends, [first, min(first + 1, self.total - 1)], side="right")
        half = (1 << self.shift) // 2
        low, high = ((int(values[k]) << self.shift) + half for k in at)
        return low, high, place - first


class StepCounts:
    """Steps between stamps, in ns."""

    def __init__(self) -> None:
        self._counts = Counts()

    def copy(self) -> StepCounts:
        """The same counts, to go on separately."""
        other = StepCounts()
        other._counts = self._counts.copy()
        return other

    def add(self, steps: IntArray) -> None:
        """Count (n,) positive steps."""
        self._counts.add(steps)

    @property
    def resolution_ns(self) -> int:
        """To how much the steps are known: 1 where exactly."""
        return 1 << self._counts.shift

    @property
    def median_ns(self) -> float:
        """The median step; 0 where there is none."""
        if self._counts.total == 0:
            return 0.0
        low, high, way = self._counts.neighbours(0.5)
        return low + (high - low) * way


class SizeCounts:
    """Sizes of numbers (floats from 0 on), to 1 part in 65 000 or, where they differ widely, a few times that."""

    def __init__(self) -> None:
        self._counts = Counts(_FLOAT_SHIFT)

    def add(self, sizes: FloatArray) -> None:
        """Count (n,) sizes."""
        # the bits of floats that are not negative are in the order of their values; +0.0 for -0.0
        bits: NDArray[np.int64] = np.ascontiguousarray(sizes + 0.0).view(np.int64)
        self._counts.add(bits)

    def quantile(self, share: float) -> float:
        """The quantile at `share` (0-1); 0 where there is none."""
        if self._counts.total == 0:
            return 0.0
        low, high, way = self._counts.neighbours(share)
        first, last = np.array([low, high], dtype=np.int64).view(np.float64)
        return float(first + (last - first) * way)
