"""What the sensors read when nothing leans: of straight driving where there is some, else of a standstill.

A standstill's reading holds the slope of the place: three degrees of a kerb are 0.05 g of lateral acceleration, and an angle
against the horizon reads them whole. A road's crown is a third of that, and half of most drives has it on the other side.
"""

from __future__ import annotations

import math

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.results import FloatArray

DRIVEN_STD_G, PLACE_STD_G, UNKNOWN_STD_G = 0.015, 0.03, 0.04
"""What is left of the accelerometer's offset in g: over straight driving (crowns), read at a standstill (the place's slope), not at all
(sensor and mounting)."""
MOVING_MPS = 3.0
STRAIGHT_RADPS = 0.05
STRAIGHT_G = 0.05
STEEPEST_G = 0.12
LEAST_DRIVEN_S, LEAST_S = 20.0, 1.0
"""Seconds of straight driving from which its reading is taken, and of anything else."""


def accel_zero(prepared: Prepared) -> tuple[float, float, str]:
    """Offset of the lateral acceleration m/s², what it may still be in g, and how it was found."""
    values, rest = prepared.columns["accel_y"], prepared.standstill_offset.get("accel_y")
    speed, yaw = prepared.columns.get("speed"), prepared.columns.get("yaw_rate")
    if speed is not None and yaw is not None:
        turning = yaw - prepared.standstill_offset.get("yaw_rate", (0.0, 0.0))[0]
        apart = values - speed * turning
        rows = _driving(prepared) & np.isfinite(apart) & (np.abs(turning) < STRAIGHT_RADPS)
        zero = float(np.median(apart[rows])) if rows.sum() >= LEAST_DRIVEN_S * prepared.rate_hz else math.nan
        # no vehicle parks on a slope beyond that: a yaw rate that shows no bend, in bends, would be taken for straight driving
        if abs(zero - (zero if rest is None else rest[0])) < STEEPEST_G * GRAVITY:
            return zero, DRIVEN_STD_G, "offset of the lateral acceleration taken from straight driving"
    if rest is not None:
        error = math.hypot(PLACE_STD_G, rest[1] / GRAVITY)
        return rest[0], error, "offset of the lateral acceleration read at standstill, with the place's slope"
    return 0.0, UNKNOWN_STD_G, "offset of the lateral acceleration not known: none taken off"


def angle_zero(prepared: Prepared, accel: FloatArray, values: FloatArray) -> tuple[float, bool]:
    """The reading of an angle (rad, (n,)) when the vehicle goes straight, and whether the slope of a standstill's place is in it.

    accel: (n,) lateral acceleration less its offset, m/s².
    """
    straight = np.abs(accel) < STRAIGHT_G * GRAVITY
    driven = straight & _driving(prepared)
    for rows, least_s, at_rest in (
        (driven, LEAST_DRIVEN_S, False),
        (prepared.standstill, LEAST_S, True),
        (straight, LEAST_S, False),
        (np.isfinite(accel), LEAST_S, False),
    ):
        known = values[rows & np.isfinite(values)]
        if len(known) >= least_s * prepared.rate_hz:
            return float(np.median(known)), at_rest
    return 0.0, False


def _driving(prepared: Prepared) -> BoolArray:
    """(n,) rows on the move: by speed, else all that is no standstill."""
    speed = prepared.columns.get("speed")
    if speed is None:
        return ~prepared.standstill
    return np.asarray(np.nan_to_num(np.abs(speed)) > MOVING_MPS)
