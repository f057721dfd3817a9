"""The vertical specific force, levelled: along the road's normal, and without the accelerometer's offset and scale error.

A vehicle does not rise for ever, so that the mean of what it feels upright is gravity. Upright is not along the road's normal where roads bank into
their bends: what the accelerometer feels less of the bends tells that lean.
"""

from __future__ import annotations

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.prepare.banked import banked_all_round
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray

LEAST_MPS = 3.0
LEAST_ROWS = 200
LEANS, MOST = 0.15, 0.6
"""Share of yaw rate times speed that is not felt: from it on roads lean, whatever honest sensors' scales do; beyond it, channels are wrong."""
FOLLOWS = 0.8
STEEPEST = 0.6
"""Sine of a lean that no road has."""


def lean_of_roads(prepared: Prepared, speed: FloatArray | None) -> FloatArray | None:
    """Sine of the body's roll against the horizon, (n,), by f_y = v r + g sin(roll). None where roads do not clearly lean into bends.

    On level roads the springs' lean is the better one: it has no part of the sideslip and of differing scales.
    """
    side, yaw = prepared.columns.get("accel_y"), prepared.columns.get("yaw_rate")
    if side is None or yaw is None or speed is None:
        return None
    curve = speed * yaw
    rows = np.isfinite(side) & np.isfinite(curve) & (np.abs(speed) > LEAST_MPS)
    if np.count_nonzero(rows) < LEAST_ROWS:
        return None
    of, felt = curve[rows] - curve[rows].mean(), side[rows] - side[rows].mean()
    square, both = float(of @ of), float(of @ felt)
    if square == 0 or both < FOLLOWS * np.sqrt(square * float(felt @ felt)):
        return None
    if not banked_all_round(curve[rows], side[rows]) and not LEANS <= 1 - both / square <= MOST:
        return None
    return np.asarray(np.clip((side - curve) / GRAVITY, -STEEPEST, STEEPEST))


def tilted(prepared: Prepared, angles: tuple[FloatArray, FloatArray]) -> FloatArray:
    """What has to be added to f_z in body axes for that along the road's normal, (n,). angles: pitch and roll, (n,) each."""
    nothing = np.zeros(len(prepared.time_s))
    side, ahead = (prepared.columns.get(f"accel_{axis}", nothing) for axis in "yx")
    return np.asarray(side * angles[1] - ahead * angles[0])


def levelled(
    prepared: Prepared, angles: tuple[FloatArray, FloatArray], speed: FloatArray | None
) -> FloatArray:
    """The vertical specific force with gravity as the mean of its upright part, (n,).

    Takes out offset and scale error of the accelerometer, which would else pass into the mass; what presses a vehicle onto a road that
    banks is no such error. angles: pitch and roll (n,) against the road. speed: (n,) m/s.
    """
    f = prepared.columns["accel_z"]
    rows = np.zeros(len(f), dtype=bool)
    for s in prepared.segments:
        rows[s.start : s.stop] = True
    upright = f + tilted(prepared, angles)
    sine = lean_of_roads(prepared, speed)
    if sine is not None:
        sideways = f * np.sqrt(1 - sine**2) + prepared.columns["accel_y"] * sine
        upright = sideways + tilted(prepared, (angles[0], np.zeros(len(f))))
    there = upright[rows & np.isfinite(upright)]
    if len(there) == 0:
        return f
    return np.asarray(f + (GRAVITY - float(np.mean(there))))
