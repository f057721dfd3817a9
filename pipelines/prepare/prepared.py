"""What an estimator is given: signals on one clock, in segments without gaps, and how each was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipelines.results import FloatArray

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Segment:
    """A stretch without gaps: rows start..stop of every column."""

    start: int
    stop: int


@dataclass(frozen=True)
class Prepared:
    """Signals at one even rate. Rows between segments do not exist: nothing is interpolated across a gap.

    time_s: (n,) seconds from the drive's start. columns: signal name ("accel_y", "roll") -> (n,) SI, low-passed alike
    (zero phase) at cutoff_hz; NaN never occurs inside a segment for a column listed in `complete`.
    raw_rate_hz: each signal's own mean rate before resampling. sources: signal -> how it was made, in words
    ("measured: Y_Accel", "derived: roll from suspension deflections"). standstill: (n,) rows where the vehicle
    stands still. together: signals that were sampled at the instants of the first wanted one (within 2 ms), hence by one
    unit in all likelihood. standstill_offset: signal -> (offset, standard error) measured at standstill, where there is one.
    """

    rate_hz: float
    cutoff_hz: float
    time_s: FloatArray
    columns: Mapping[str, FloatArray]
    segments: tuple[Segment, ...]
    sources: Mapping[str, str]
    measured: frozenset[str]
    standstill: BoolArray
    raw_rate_hz: Mapping[str, float] = field(default_factory=dict)
    standstill_offset: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    together: frozenset[str] = frozenset()

    @cached_property
    def recorded(self) -> BoolArray:
        """(n,) rows in which any signal is there: a pause, or a clock that jumps, leaves rows in which none is."""
        found = np.zeros(len(self.time_s), dtype=bool)
        for column in self.columns.values():
            found |= np.isfinite(column)
        return found

    def share_of(self, values: FloatArray) -> float:
        """Share of the `recorded` rows in which a column (n,) is there; 0 where nothing is recorded."""
        rows = int(np.count_nonzero(self.recorded))
        return float(np.count_nonzero(np.isfinite(values[self.recorded])) / rows) if rows else 0.0
