"""A drive split into manoeuvres by what excites it, so that forms compete on manoeuvres that they have not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray
from pipelines.suspension_mapping.data import MapData, rate_of, stretches

KINDS: tuple[str, ...] = ("standing", "cruising", "driving", "braking", "left", "right", "swerving")
SMOOTH_HZ = 0.5
LATERAL, LONGITUDINAL, SWERVE = 1.0, 0.8, 2.0
"""m/s², m/s², m/s³ from which a stretch is a bend, a braking or driving one, a swerve."""
LONGEST_S = 10.0
"""A longer manoeuvre counts as several."""
FOLDS = 5


@dataclass(frozen=True)
class Manoeuvres:
    """kind (n,): index into KINDS. piece (n,): number of the manoeuvre. fold (n,): 0..FOLDS-1, whole manoeuvres."""

    kind: np.ndarray
    piece: np.ndarray
    fold: np.ndarray


def _smooth(values: FloatArray, data: MapData) -> FloatArray:
    out = np.array(values)
    for first, past in stretches(data.starts):
        out[first:past] = lowpass(values[first:past], data.rate_hz, SMOOTH_HZ)
    return out


def split(data: MapData) -> Manoeuvres:
    """Label every row by its excitation; whole manoeuvres go round-robin into folds, kind by kind."""
    zero = np.zeros(data.size)
    a_y, a_x = data.columns.get("accel_y", zero), data.columns.get("accel_x", zero)
    slow_y, slow_x = _smooth(a_y, data), _smooth(a_x, data)
    quick = np.sqrt(np.maximum(_smooth(rate_of(a_y, data.starts, data.rate_hz) ** 2, data), 0.0))
    kind = np.full(data.size, KINDS.index("cruising"))
    kind[slow_x > LONGITUDINAL] = KINDS.index("driving")
    kind[slow_x < -LONGITUDINAL] = KINDS.index("braking")
    kind[slow_y > LATERAL] = KINDS.index("left")
    kind[slow_y < -LATERAL] = KINDS.index("right")
    kind[quick > SWERVE] = KINDS.index("swerving")
    kind[data.still] = KINDS.index("standing")
    new = (np.diff(kind, prepend=kind[:1]) != 0) | (data.starts > 0.5)
    since = np.arange(data.size) - np.maximum.accumulate(np.where(new, np.arange(data.size), 0))
    new |= (since > 0) & (since % max(round(LONGEST_S * data.rate_hz), 1) == 0)
    new[:1] = True
    piece = np.cumsum(new) - 1
    first = np.flatnonzero(new)
    fold_of = np.zeros(len(first), dtype=np.int64)
    for number in range(len(KINDS)):
        own = np.flatnonzero(kind[first] == number)
        # another beginning for every kind, so that no fold gets all the firsts
        fold_of[own] = (np.arange(len(own)) + number) % FOLDS
    return Manoeuvres(kind, piece, fold_of[piece])
