"""Single wild samples that survived the import: found against their neighbours and left out."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from parsers.channels import FloatArray, IntArray
from parsers.drive import Signal

WIDTH = 5
LIMIT, USUAL = 15.0, 0.97
MOST = 0.02
"""Of a signal may be wild: where more stands out, it is how the signal moves."""
MOVING, MOVED = 13, 4.0
"""A wild sample lies more than MOVED times the usual step of so many around it from its neighbours: a jolt's peak does not."""
BACK = 2.0
"""And more than so many times as far as those before it lie from those after it: brakes that bite do not go back to where they were."""


def without_spikes(signal: Signal) -> tuple[Signal, int]:
    """The signal without samples that stand out of the median of five neighbours, and how many they were.

    The measure is 15 times the usual (97th percentile) distance from that median: real motion at any sensible
    rate never gets there, a bit error does. A log without noise is so quiet between its manoeuvres that the first bite of the
    brakes does as well: so a wild sample is one that its neighbours' own motion does not explain either. Samples are
    dropped, not replaced: the gap rules decide what follows.
    """
    values = signal.values
    if len(values) < 4 * WIDTH:
        return signal, 0
    distance = np.abs(values - median_filter(values, size=WIDTH, mode="nearest"))
    usual = float(np.quantile(distance, USUAL))
    if usual <= 0:
        usual = float(np.std(values)) / LIMIT
    wild = np.flatnonzero(distance > LIMIT * max(usual, 1e-12))
    wild = wild[distance[wild] > _moving(values, wild)]
    keep = np.ones(len(values), dtype=np.bool_)
    keep[wild] = False
    dropped = len(wild)
    if dropped == 0 or dropped > MOST * len(values) + 3:
        return signal, 0
    return Signal(signal.name, signal.time_ns[keep], values[keep], signal.source, signal.measured), dropped


def _around(values: FloatArray, rows: IntArray, width: int) -> FloatArray:
    """(rows, width) the samples around some rows; beyond the ends the end ones again."""
    at = rows[:, None] + np.arange(width) - width // 2
    return np.asarray(values[np.clip(at, 0, len(values) - 1)])


def _moving(values: FloatArray, rows: IntArray) -> FloatArray:
    """(rows,) how far a sample may lie from its neighbours by what these do themselves."""
    steps = np.abs(np.diff(values, append=values[-1]))
    usual = np.median(_around(steps, rows, MOVING), axis=1)
    last = len(values) - 1
    before, after = (np.median(_around(values, np.clip(rows + side, 0, last), 3), axis=1) for side in (-2, 2))
    return np.asarray(np.maximum(MOVED * usual, BACK * np.abs(after - before)))
