"""Gravity's share in a lateral acceleration by the body's turning against the horizon, which bends that bank do not hide.

The springs show the lean against the road. Where a road banks into its bends the body leans outwards on its springs and inwards
with the road, and a true accelerometer shows next to nothing of gravity. A gyro turns with both:

    roll' = p - r (f_x - v') / g,    f_y - v r = s g roll + …

(nose-up is (f_x - v') / g on hills). It drifts, so both sides go through the same high pass, and an offset of the gyro, or of the
longitudinal accelerometer, is a constant and a column beside it.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from parsers.checks.grid import CELL_S, Grid
from parsers.checks.motion import smooth
from pipelines.models.roll import GRAVITY
from pipelines.prepare.block_slope import BlockSlopes, block_slopes
from pipelines.results import FloatArray

HIGH_PASS_S = 6.0
"""Time constant: bends begin and end within some seconds."""

LEAST_TURN = 0.006
"""rad, rms: a lean that changes by less is no more than the gyro's noise and drift."""


def _leaky(values: FloatArray) -> FloatArray:
    """Integral that forgets, of a column (n,); gaps count as nought."""
    keep = 1 - CELL_S / HIGH_PASS_S
    return np.asarray(lfilter([CELL_S], [1.0, -keep], np.nan_to_num(values)))


def _passed(values: FloatArray) -> FloatArray:
    """High pass of a column (n,) to what `_leaky` makes of its derivative; NaN where it is."""
    keep = 1 - CELL_S / HIGH_PASS_S
    there = np.isfinite(values)
    held = np.where(there, values, 0.0)
    return np.where(there, lfilter([1.0, -1.0], [1.0, -keep], held), np.nan)


def _turning(grid: Grid) -> FloatArray | None:
    """rad/s: roll' against the horizon by the gyro; None without one."""
    rate, yaw, forward, speed = (grid.get(n) for n in ("roll_rate", "yaw_rate", "accel_x", "speed"))
    if rate is None or yaw is None:
        return None
    if forward is None or speed is None:
        return rate
    return np.asarray(rate - yaw * (smooth(forward) - grid.rate(smooth(speed))) / GRAVITY)


def lean_by_gyro(grid: Grid, lean: FloatArray) -> BlockSlopes | None:
    """How much the body turns against the horizon as it leans (n,) on its springs: 1 and a little more, tyres, where roads lie level, and
    next to nothing where they bank by as much. None without a gyro, or where the lean changes by too little."""
    turning, yaw = _turning(grid), grid.get("yaw_rate")
    if turning is None or yaw is None:
        return None
    by = GRAVITY * _passed(lean)
    looked_at = np.where(np.isfinite(turning), GRAVITY, np.nan)
    return block_slopes(by, (_leaky(turning) * looked_at,), _leaky(yaw)[:, None], LEAST_TURN * GRAVITY)


def share_by_gyro(grid: Grid, rest: FloatArray, load: FloatArray, others: FloatArray) -> BlockSlopes | None:
    """Slope of `rest` (n,), f_y - v r where it is looked at, on gravity's part by the gyro, beside `others` (n, k).

    grid: with roll_rate, yaw_rate, accel_x and a speed as far as they are there; load: as in `gravity.share_of`. None where they
    are not, or the body turns too little.
    """
    turning, yaw = _turning(grid), grid.get("yaw_rate")
    if turning is None or yaw is None:
        return None
    drift = np.column_stack([_leaky(yaw), *(_passed(column) for column in others.T)])
    looked_at = np.where(np.isfinite(rest) & np.isfinite(turning), 1.0, np.nan)
    gravity = GRAVITY * _leaky(turning) * looked_at
    return block_slopes(gravity, (_passed(rest), _passed(load) * looked_at), drift, LEAST_TURN * GRAVITY)
