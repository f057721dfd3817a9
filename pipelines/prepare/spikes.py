"""Single wild samples that survived the import: found against their neighbours and left out."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from parsers.channels import FloatArray
from parsers.drive import Signal

WIDTH = 5
LIMIT = 15.0
MOVING, MOVED = 13, 4.0
"""A wild sample lies more than MOVED times the usual step of so many around it from its neighbours: a jolt's peak does not."""
BACK = 2.0
"""And more than so many times as far as those before it lie from those after it: brakes that bite do not go back to where they were."""


def without_spikes(signal: Signal) -> tuple[Signal, int]:
    """The signal without samples that stand out of the median of five neighbours, and how many they were.

    The measure is 15 times the usual (99th percentile) distance from that median: real motion at any sensible
    rate never gets there, a bit error does. A log without noise is so quiet between its manoeuvres that the first bite of the
    brakes does as well: so a wild sample is one that its neighbours' own motion does not explain either. Samples are
    dropped, not replaced: the gap rules decide what follows.
    """
    values = signal.values
    if len(values) < 4 * WIDTH:
        return signal, 0
    distance = np.abs(values - median_filter(values, size=WIDTH, mode="nearest"))
    usual = float(np.quantile(distance, 0.99))
    if usual <= 0:
        usual = float(np.std(values)) / LIMIT
    keep = distance <= np.maximum(LIMIT * max(usual, 1e-12), _moving(values))
    dropped = int(len(values) - keep.sum())
    if dropped == 0 or dropped > 0.005 * len(values) + 3:
        return signal, 0
    return Signal(signal.name, signal.time_ns[keep], values[keep], signal.source, signal.measured), dropped


def _moving(values: FloatArray) -> FloatArray:
    """(n,) how far each sample may lie from its neighbours by what these do themselves."""
    steps = np.abs(np.diff(values, append=values[-1]))
    middle = np.pad(median_filter(values, size=3, mode="nearest"), 2, mode="edge")
    change = np.abs(middle[4:] - middle[:-4])
    return np.maximum(MOVED * median_filter(steps, size=MOVING, mode="nearest"), BACK * change)


def interpolable(time_ns: np.ndarray) -> FloatArray:
    """Seconds from the first sample, for interpolation without loss of digits."""
    return np.asarray(time_ns - time_ns[0], dtype=np.float64) / 1e9
