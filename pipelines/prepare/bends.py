"""Which bends may be a road's: roads lean into theirs, and a body's angle against the horizon then shows the road's lean too."""

from __future__ import annotations

import math

import numpy as np

from parsers.channels import IntArray
from pipelines.results import FloatArray

MOST_TURNED = 1.25 * 2 * math.pi
"""rad: no road turns further one way (a ramp's loop is three quarters of a turn); test pads do, and they are planes."""
LEAST_YAW = 0.02
"""rad/s: slower is straight on."""
LEANING_STD = 0.2
"""Share of a body's steady roll that roads' lean takes off it in their bends, its spread. Roads are built with 2 to 7 % of lean for
2 m/s², more than a body rolls; most bends of towns and tracks have next to none."""


def road_share(yaw_rate: FloatArray | None, lateral: FloatArray, step_s: float, starts: IntArray) -> float:
    """Share of a lateral acceleration's power that a road's bends may have made, 0-1; 1 where there is no yaw rate.

    yaw_rate (n,) rad/s, lateral (n,) m/s², one sample every step_s. starts: rows at which a stretch begins.
    """
    power = lateral * lateral
    whole = float(np.sum(power))
    if yaw_rate is None or whole <= 0 or not np.isfinite(yaw_rate).all():
        return 1.0
    way = np.where(np.abs(yaw_rate) < LEAST_YAW, 0.0, np.sign(yaw_rate))
    fresh = np.concatenate(([False], np.diff(way) != 0))
    fresh[starts] = True
    bend = np.cumsum(fresh)
    turned = np.abs(np.bincount(bend, yaw_rate * step_s))
    return 1 - float(np.sum(power[turned[bend] > MOST_TURNED])) / whole
