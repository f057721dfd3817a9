"""What the record says of stamps - how many, from when to when, how often, gaps - gathered window by window."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.channels import IntArray
from parsers.step_counts import StepCounts
from parsers.timebase import MAX_GAPS, gap_limit_ns

_MOST_SPANS = 8 * MAX_GAPS
_SURE = 0.5
"""Steps longer than this share of a gap are noted, as what is usual is only known in the end."""


class TimeFigures:
    """Figures of one time vector, whose parts come in order of time. samples: how many stamps; first, last: in ns."""

    def __init__(self, usual_ns: float | None = None) -> None:
        """usual_ns: about how long a step is, from an earlier look; without it no gaps are noted."""
        self.samples = 0
        self.first = self.last = 0
        self._steps = StepCounts()
        self._least = np.inf if usual_ns is None else _SURE * gap_limit_ns(usual_ns)
        self._spans = np.zeros((2, 0), dtype=np.int64)
        self._dropped = 0

    def copy(self) -> TimeFigures:
        """The same figures, to go on separately."""
        other = TimeFigures()
        other.__dict__.update(self.__dict__)
        other._steps = self._steps.copy()
        return other

    def add(self, time_ns: IntArray) -> None:
        """Take (n,) stamps, increasing and after all earlier ones."""
        if len(time_ns) == 0:
            return
        stamps = np.concatenate([[self.last], time_ns]) if self.samples else time_ns
        steps = np.diff(stamps)
        self._steps.add(steps)
        if len(steps) and int(steps.max()) > self._least:
            at = np.flatnonzero(steps > self._least)
            self._note(np.stack([stamps[at], stamps[at + 1]]))
        self.first = self.first if self.samples else int(time_ns[0])
        self.last = int(time_ns[-1])
        self.samples += len(time_ns)

    def _note(self, spans: IntArray) -> None:
        spans = np.concatenate([self._spans, spans], axis=1)
        if spans.shape[1] > 2 * _MOST_SPANS:
            longest = np.sort(np.argsort(spans[0] - spans[1], kind="stable")[:_MOST_SPANS])
            self._dropped += spans.shape[1] - len(longest)
            spans = spans[:, longest]
        self._spans = spans

    @property
    def median_ns(self) -> float:
        """The usual step; 0 for fewer than two stamps."""
        return self._steps.median_ns

    @property
    def resolution_ns(self) -> int:
        """To how much the usual step is known: 1 where exactly."""
        return self._steps.resolution_ns

    @property
    def dropped(self) -> int:
        """How many spans are not in `gaps` any more, the shortest ones of very many."""
        return self._dropped

    def gaps(self) -> tuple[IntArray, IntArray]:
        """Starts and ends of steps much longer than usual, (m,) each."""
        starts, ends = self._spans
        if self.samples < 3:
            return starts[:0], ends[:0]
        long = ends - starts > gap_limit_ns(self.median_ns)
        return starts[long], ends[long]


class SharedFigures:
    """Figures of several time vectors, of which most are the same one: that is looked at once as long as it is so."""

    def __init__(self, usual_ns: Mapping[str, float | None]) -> None:
        """usual_ns: name -> about how long a step is, or None (see `TimeFigures`)."""
        known = [each for each in usual_ns.values() if each is not None]
        self._base = TimeFigures(min(known) if known else None)
        self._own: dict[str, TimeFigures] = {}
        self._following = dict.fromkeys(usual_ns)

    def add(self, base: IntArray, stamps: Mapping[str, IntArray]) -> None:
        """Take the next stamps of each name; those that are the very array `base` stay with the others."""
        for name, time_ns in stamps.items():
            if name in self._following and time_ns is not base:
                del self._following[name]
                self._own[name] = self._base.copy()
            if name in self._own:
                self._own[name].add(time_ns)
        if self._following:
            self._base.add(base)

    def of(self, name: str) -> TimeFigures:
        """The figures of one name."""
        return self._own.get(name, self._base)
