"""Loads that come axle by axle in one channel, a place beside each: which axles there are, and the sum over them.

A place counts axles from the front in its upper four bits and from the left in its lower four, as J1939 does.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.timebase import NS

PLACES = 16
"""Places of one axle."""

MAX_AGE_NS = 3 * NS
"""A load older than this is no part of a sum: J1939 sends them once a second."""

RARE = 0.01
"""A place that comes less than this as often as the commonest one is a damaged frame's."""


class _Rows:
    """The rows whose place lies in [low, high], piece by piece in order of time; each axle's last one is carried on.

    only: the places that count of those; None for all.
    """

    def __init__(self, low: float, high: float, only: tuple[int, ...] | None = None) -> None:
        self._low, self._high, self._only = low, high, only
        self._time: IntArray = np.zeros(0, dtype=np.int64)
        self._axle: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._load: FloatArray = np.zeros(0)

    def joined(
        self, time_ns: IntArray, place: FloatArray, load: FloatArray
    ) -> tuple[IntArray, NDArray[np.int64], FloatArray, int, FloatArray]:
        """Stamps, axles and loads (m,) with what was carried on before them, how many those are, and the new places."""
        used = np.isfinite(load) & (place >= self._low) & (place <= self._high)
        if self._only is not None:
            used &= np.isin(place, self._only)
        places = place[used]
        carried = len(self._time)
        stamps = np.concatenate([self._time, time_ns[used]])
        axle = np.concatenate([self._axle, places.astype(np.int64) // PLACES])
        loads = np.concatenate([self._load, load[used]])
        _, from_end = np.unique(axle[::-1], return_index=True)
        last = np.sort(len(axle) - 1 - from_end)
        self._time, self._axle, self._load = stamps[last], axle[last], loads[last]
        return stamps, axle, loads, carried, places


def _latest(
    at_ns: IntArray, stamps: IntArray, axle: NDArray[np.int64], loads: FloatArray, which: int
) -> tuple[IntArray, FloatArray]:
    """Of one axle the age of its latest load at some stamps, MAX_AGE_NS + 1 where there is none, and that load, (n,)."""
    rows = np.flatnonzero(axle == which)
    if len(rows) == 0:
        return np.full(len(at_ns), MAX_AGE_NS + 1), np.full(len(at_ns), np.nan)
    before = np.searchsorted(stamps[rows], at_ns, side="right") - 1
    row = rows[np.maximum(before, 0)]
    age = np.where(before < 0, MAX_AGE_NS + 1, at_ns - stamps[row])
    return np.minimum(age, MAX_AGE_NS + 1), loads[row]


@dataclass(frozen=True)
class AxlePlan:
    """What is summed. axles: counted from 0 at the front. reference: at whose rows the sum is made. places: all that were
    taken. rare: places that were seen too seldom to be an axle's."""

    axles: tuple[int, ...]
    reference: int
    places: tuple[int, ...]
    rare: tuple[int, ...] = ()

    @property
    def one_a_place(self) -> bool:
        """Whether each axle has one load, and not several side by side."""
        return len(self.axles) == len(self.places)


class AxleSurvey:
    """Finds out which axles a channel tells of, piece by piece."""

    def __init__(self, low: float, high: float) -> None:
        """low, high: the places that count."""
        self._rows = _Rows(low, high)
        self._places: Counter[int] = Counter()
        self._ages: Counter[tuple[int, int]] = Counter()
        self._counts: Counter[int] = Counter()

    def add(self, time_ns: IntArray, place: FloatArray, load: FloatArray) -> None:
        """Take the next rows, (n,) each, in order of time."""
        stamps, axle, loads, carried, places = self._rows.joined(time_ns, place, load)
        codes, counts = np.unique(places.astype(np.int64), return_counts=True)
        self._places.update(dict(zip(codes.tolist(), counts.tolist(), strict=True)))
        for one in np.unique(axle).tolist():
            at_ns = stamps[carried:][axle[carried:] == one]
            self._counts[one] += len(at_ns)
            for other in np.unique(axle).tolist():
                age, _ = _latest(at_ns, stamps, axle, loads, other)
                self._ages[one, other] += int(age.sum())

    def plan(self) -> AxlePlan:
        """Which axles there are. The sum is made where the others' loads are youngest: at the end of a round of frames,
        at the slowest axle's."""
        most = max(self._places.values(), default=0)
        places = sorted(code for code, count in self._places.items() if count >= RARE * most)
        axles = tuple(sorted({code // PLACES for code in places}))
        reference = min(axles, key=lambda one: self._mean_age(one, axles), default=0)
        rare = tuple(sorted(set(self._places) - set(places)))
        return AxlePlan(axles, reference, tuple(places), rare)

    def _mean_age(self, one: int, axles: tuple[int, ...]) -> float:
        return sum(self._ages[one, other] for other in axles) / max(self._counts[one], 1)


class AxleSum:
    """Sums an axle plan's loads, piece by piece."""

    def __init__(self, plan: AxlePlan, low: float, high: float) -> None:
        """low, high: the places that count."""
        self._plan = plan
        self._rows = _Rows(low, high, plan.places)

    def add(self, time_ns: IntArray, place: FloatArray, load: FloatArray) -> tuple[IntArray, FloatArray]:
        """The stamps and sums that the next rows give; none where an axle's latest load is missing or too old."""
        stamps, axle, loads, carried, _ = self._rows.joined(time_ns, place, load)
        at_ns = stamps[carried:][axle[carried:] == self._plan.reference]
        total = np.zeros(len(at_ns))
        whole = np.ones(len(at_ns), dtype=np.bool_)
        for each in self._plan.axles:
            age, value = _latest(at_ns, stamps, axle, loads, each)
            whole &= age <= MAX_AGE_NS
            total += value
        return at_ns[whole], total[whole]
