"""Limits of the lateral acceleration and the rollover coefficient: pure functions, on numbers or on arrays of draws.

Axes ISO 8855: in a left turn A_y > 0 and roll phi > 0 (right side down), and the LEFT wheels lose their load. Moments about
the ground point in the middle of the track B, with the CG at height h, y0 left of the middle and moved to the right by
the lean of the body (h_r: what the whole vehicle's CG moves to the right a radian of roll),

    B/2 (F_l - F_r) = m f_z (y0 - h_r phi) - m f_y h + I phi''                                        (*)

f_y, f_z: specific force along and across the road surface, so that bank and grade drop out; A_y = f_y / f_z. With r - l = 2 y0
(r, l: from the CG to the right and the left track) and phi'' = 0 this is (159)-(160) of the dissertation, with h in place
of h_r in the acceleration's term where the load at the road and not that in the springs is meant, as in (156) and (163).
phi keeps its sign. All accelerations in g.
"""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.rollover_results import TurnSide

Number = FloatArray | float
_ROUNDS, _ROLL_ROUNDS = 40, 12
SIDES: tuple[tuple[TurnSide, float], ...] = (("left", 1.0), ("right", -1.0))
"""Turns, and the sign of their lateral acceleration; the wheels of the same name lift."""


def static_stability_factor(track: Number, height: Number) -> Number:
    """B / (2 h): (151), (152), and (157) for a CG in the middle and no roll."""
    return track / (2 * height)


def suspension_limit(side: float, track: Number, offset: Number, lever: Number, roll: Number) -> Number:
    """A_y at which the springs of a side carry nothing, (155), (161), (162): side B / (2 h_r) - phi + (r - l) / (2 h_r).

    side: +1 left turn, -1 right turn. roll: rad, signed. The result is signed too. lever: h_r, m.
    """
    return side * track / (2 * lever) - roll + offset / lever


def contact_limit(
    side: float, track: Number, offset: Number, height: Number, lever: Number, roll: Number
) -> Number:
    """A_y at which the wheels of a side carry nothing, (156), (163): side B / (2 h) - phi h_r / h + (r - l) / (2 h)."""
    return side * track / (2 * height) - roll * lever / height + offset / height


def rollover_coefficient(
    lateral: Number, roll: Number, track: Number, offset: Number, height: Number, lever: Number
) -> Number:
    """(F_l - F_r) / sum F, (160), at the wheels: (r - l)/B - 2 A_y h / B - 2 h_r phi / B. -1: the left wheels lift."""
    return 2 * (offset - lateral * height - lever * roll) / track


def coefficient_of_forces(fl: Number, fr: Number, rl: Number, rr: Number) -> Number:
    """(F_l - F_r) / sum F, (158), from the four tyre normal forces; NaN where their sum is not positive."""
    total = np.asarray(fl + fr + rl + rr, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(total > 0, (fl + rl - fr - rr) / total, np.nan))


def sensed(lateral: Number, roll: Number) -> Number:
    """What an accelerometer on a body that leans by roll reads, in units of f_z: A cos(roll) + sin(roll)."""
    return np.asarray(lateral * np.cos(roll) + np.sin(roll))


def level(sensed_y: Number, sensed_z: Number, roll: Number) -> FloatArray:
    """A_y = f_y / f_z along the road from a leaning body's specific forces (any one unit): tan(atan2(y, z) - roll).

    Held to 60 degrees, 1.7 g: beyond it a vehicle is falling.
    """
    return np.asarray(np.tan(np.clip(np.arctan2(sensed_y, sensed_z) - roll, -1.05, 1.05)))


def steady_roll(lateral: Number, gradient: Number) -> FloatArray:
    """Roll in rad in a steady turn: gradient (rad a sensed g) times what the leaning body senses."""
    roll = gradient * np.asarray(lateral, dtype=np.float64)
    for _ in range(_ROLL_ROUNDS):
        roll = np.clip(gradient * sensed(lateral, roll), -0.6, 0.6)
    return np.asarray(roll)


def quasi_static_threshold(
    side: float, track: Number, offset: Number, height: Number, lever: Number, gradient: Number,
    jacking: Number = 0.0, axis: Number = 0.0, tilt: Number = 0.0, give: Number = 0.0,
) -> FloatArray:  # fmt: skip
    """(163) with the roll that the limit itself brings: the size of A_y at which the wheels of a side lift in a slow turn.

    gradient: rad a sensed g. jacking: rise of the body in m a g once all side force is at one side's wheels (it leads
    through the roll centres, `axis` above ground, and so lifts the body, and draws the wheels inwards by 2 axis / B of it).
    tilt: m that the CG moves because the axles lean on their tyres, beyond lever times the whole roll: (h - h_r) 2 sag / B.
    give: m a g that the loads of all four tyres go with their patches to the inside of the bend; two that carry it all go twice as far.
    """
    half = 0.5 * np.asarray(track, dtype=np.float64)
    limit = np.asarray((half + side * offset) / height, dtype=np.float64)
    roll = steady_roll(limit, gradient)
    for _ in range(_ROUNDS):
        # halfway: jacking and roll grow with the limit, and a full step could swing
        roll = np.clip(gradient * sensed(limit, roll), -0.6, 0.6)
        rise = jacking * limit
        moment = half + side * offset - tilt - lever * roll - rise * axis / half
        next_ = moment / (height + rise + 2 * give)
        limit = np.maximum(0.5 * (limit + next_), 0.01)
    return limit
