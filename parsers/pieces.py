"""What one log has of a signal, and what two logs' samples over the same time say of each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, Self

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.timebase import NS

OVERLAP_NS = NS
"""Parts in a row may overlap by this much; by more, they are recorders of the same span or hold the same samples."""

_PROBE_NS = 60 * NS
"""Of a long overlap its first and its last minute are compared."""

_SAME_STAMP_NS = NS // 1000
"""File headers tell the moment of their zero to a millisecond: to so much may stamps of one and the same sample differ."""

_SAME_SHARE = 0.9
"""Recorders lose a frame now and then: so many of the samples must be in both logs."""

_LEAST_SAMPLES = 10

Span = tuple[int, int]


class Piece(Protocol):
    """What one log has of a signal, wherever its samples are."""

    @property
    def span(self) -> Span:
        """First and last stamp."""
        ...

    @property
    def samples(self) -> int:
        """How many samples it has."""
        ...

    @property
    def source(self) -> str:
        """Where it is from, as a record says it."""
        ...

    def load(self, start: int, stop: int) -> tuple[IntArray, FloatArray]:
        """Stamps and values in [start, stop), (n,) each."""
        ...

    def outside(self, spans: Sequence[Span]) -> Self | None:
        """The samples that lie in none of the spans (their ends are inside); None where there are none."""
        ...


def inside(first: Span, second: Span) -> bool:
    """Whether the first span lies within the second."""
    return second[0] <= first[0] and first[1] <= second[1]


def overlap_ns(first: Span, second: Span) -> int:
    """How long both run; negative where they are apart. One inside the other is more than any allowed overlap."""
    if inside(first, second) or inside(second, first):
        return OVERLAP_NS + 1
    return min(first[1], second[1]) - max(first[0], second[0])


def _probes(first: Span, second: Span) -> list[Span]:
    """Spans [start, stop) of the overlap in which samples are compared."""
    start, stop = max(first[0], second[0]), min(first[1], second[1]) + 1
    if stop - start <= 2 * _PROBE_NS:
        return [(start, stop)]
    return [(start, start + _PROBE_NS), (stop - _PROBE_NS, stop)]


def same_samples(first: Piece, second: Piece) -> bool:
    """Whether two pieces hold the same samples where they overlap: equal values at equal stamps."""
    found = total = 0
    for start, stop in _probes(first.span, second.span):
        a = first.load(start - _SAME_STAMP_NS, stop + _SAME_STAMP_NS)
        b = second.load(start - _SAME_STAMP_NS, stop + _SAME_STAMP_NS)
        if not len(a[0]) or not len(b[0]):
            return False
        for one, other in ((a, b), (b, a)):
            counted = (one[0] >= start) & (one[0] < stop)
            found += int(np.count_nonzero(_held_by(other, one) & counted))
            total += int(np.count_nonzero(counted))
    return total >= 4 and found >= _SAME_SHARE * total


def _held_by(other: tuple[IntArray, FloatArray], one: tuple[IntArray, FloatArray]) -> np.ndarray:
    """Which samples of `one` the other has as well, (n,)."""
    times, values = other
    after = np.clip(np.searchsorted(times, one[0]), 1, len(times) - 1) if len(times) > 1 else np.zeros(1, int)
    before = np.maximum(after - 1, 0)
    nearest = np.where(one[0] - times[before] < times[after] - one[0], before, after)
    near = np.abs(times[nearest] - one[0]) <= _SAME_STAMP_NS
    return np.asarray(near & (values[nearest] == one[1]))


def tell_different_things(first: Piece, second: Piece) -> bool | None:
    """Whether two pieces of one channel cannot be of one moment; None where too little moves to say it.

    Two recorders of one moment differ by their noise and by a shift of their clocks. Here the difference holds more than half
    of the variance (twice of it is what unrelated samples give).
    """
    change, spread, seen = 0.0, [], 0
    for start, stop in _probes(first.span, second.span):
        (ta, va), (tb, vb) = first.load(start, stop), second.load(start, stop)
        if len(ta) < 2 or len(tb) < 2:
            continue
        expected = np.interp((tb - ta[0]) / NS, (ta - ta[0]) / NS, va)
        change += float(((vb - expected) ** 2).sum())
        seen += len(tb)
        spread += [va, vb]
    if seen < _LEAST_SAMPLES:
        return None
    variance = float(np.concatenate(spread).var())
    return change > 0.5 * variance * seen if variance > 0 else None
