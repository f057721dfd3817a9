"""A circuit that leans into its one direction all the way round: what is felt less of the bends is no offset of the accelerometer.

f = a - g,    |f|² = g² + (v r)²   on a road that leans and neither rises nor falls
"""

from __future__ import annotations

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray

ONE_WAY, STEADY = 1.0, 0.9
"""m/s² of turning in the mean, and of what is felt less than that, from which on a circuit of one direction leans all the way round: no offset of
an accelerometer, and no unit askew that is not said, is as large; a body that leans outwards feels more, not less."""


def banked_all_round(curve: FloatArray, side: FloatArray) -> bool:
    """Whether bends of one direction lean throughout. curve: speed times yaw rate (n,), side: lateral specific force (n,), m/s², both finite."""
    if not len(curve):
        return False
    turning = float(curve.mean())
    less = float((curve - side).mean()) * (1 if turning > 0 else -1)
    return abs(turning) > ONE_WAY and less > STEADY


def pressed_on(curve: FloatArray, side: FloatArray) -> float:
    """m/s² upright in the body in the mean of such a circuit, gravity's and the bend's. curve, side: as above."""
    return float(np.mean(np.sqrt(np.maximum(GRAVITY**2 + curve**2 - side**2, 0.0))))
