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


def share_by_gyro(grid: Grid, rest: FloatArray, load: FloatArray, others: FloatArray) -> BlockSlopes | None:
    """Slope of `rest` (n,), f_y - v r where it is looked at, on gravity's part by the gyro, beside `others` (n, k).

    grid: with roll_rate, yaw_rate, accel_x and a speed as far as they are there; load: as in `gravity.share_of`. None where they
    are not, or the body turns too little.
    """
    rate, yaw, forward, speed = (grid.get(n) for n in ("roll_rate", "yaw_rate", "accel_x", "speed"))
    if rate is None or yaw is None:
        return None
    turning = rate
    if forward is not None and speed is not None:
        turning = rate - yaw * (smooth(forward) - grid.rate(smooth(speed))) / GRAVITY
    drift = np.column_stack([_leaky(yaw), *(_passed(column) for column in others.T)])
    looked_at = np.where(np.isfinite(rest) & np.isfinite(turning), 1.0, np.nan)
    gravity = GRAVITY * _leaky(turning) * looked_at
    return block_slopes(gravity, (_passed(rest), _passed(load) * looked_at), drift, LEAST_TURN * GRAVITY)
