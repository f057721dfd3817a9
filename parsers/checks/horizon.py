"""A roll angle against the horizon, told by the gravity that the lateral accelerometer feels with it: on any road, however it banks.

In a leaning body `accel_y` is yaw rate times speed and g sin(roll), with +1 before the latter, whatever leans: the body on its springs, or the
road beneath it. That is asked in two ways. What is left of `accel_y` less yaw rate times speed goes with roll, by about 1; and it
still does where as much of yaw rate times speed is taken out of both as goes with it. The first alone would be misled by a scale that is off by
some per cent, and by a roll angle against the road (it goes with bends, and what is left is mostly the bank, which goes against them): in the
second that angle has a factor of ten and more. Accelerations without gravity have neither.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import CELL_S, Grid, Together, compare
from parsers.checks.leaning import quick, swift_tells, told_by
from parsers.checks.motion import MIN_SPEED, smooth, vehicle_speed
from parsers.units import STANDARD_GRAVITY

_CELLS = 31
"""Slow enough that drifting sideways and the sensors' delays stay out."""
_SECONDS = 60.0
_NEAR_ONE = 1.6
_SCALE = 1.25
"""How far a factor may be from 1: gravity's by noise in either, that of yaw rate times speed by scales."""
_GOES_ALONG, _LEAST = 0.6, 0.55
"""Least correlations: of what is left with roll, and of both without bends. Simulated drives on banked roads have 0.95 and 0.65 to 0.9."""
PART = "what accel_y is beyond yaw_rate × speed, gravity's part"


@dataclass(frozen=True)
class Gravity:
    """How roll goes with gravity's part of the lateral acceleration. left: of what is left beyond yaw rate times speed; sure: of both
    without bends as well, where that bears it out."""

    left: Together
    sure: Together | None


def gravity_with_roll(grid: Grid) -> Gravity | None:
    """What gravity says of the sign of roll, against accel_y's; None where the lateral acceleration does not show it."""
    roll, lateral, yaw, speed = (
        grid.get("roll"),
        grid.get("accel_y"),
        grid.get("yaw_rate"),
        vehicle_speed(grid),
    )
    if roll is None or lateral is None or yaw is None or speed is None:
        return None
    moving = np.where(np.abs(speed) > MIN_SPEED, speed, np.nan)
    rows = np.array(
        [smooth(each, _CELLS) for each in (yaw * moving, STANDARD_GRAVITY * np.sin(roll), lateral)]
    )
    rows = rows[:, np.isfinite(rows).all(axis=0)]
    seconds = rows.shape[1] * CELL_S
    if seconds < _SECONDS:
        return None
    # a damaged log may hold numbers whose squares no float can hold
    with np.errstate(over="ignore", invalid="ignore"):
        spread = np.cov(rows)
    if not (np.isfinite(spread).all() and (np.diagonal(spread) > 0).all()):
        return None
    return _judged(spread.tolist(), seconds)


def _judged(spread: list[list[float]], seconds: float) -> Gravity | None:
    """spread: (3, 3) covariances of yaw rate times speed, gravity by roll and the lateral acceleration."""
    (bb, br, by), (_, rr, ry), (_, _, yy) = spread
    own, along, joint = bb * rr - br * br, bb * yy - by * by, bb * ry - br * by
    if not (own > 0 and along > 0):
        return None
    bends, gravity = (rr * by - br * ry) / own, joint / own
    side = math.copysign(1.0, by)
    rest = yy - 2 * side * by + bb
    if not rest > 0:
        return None
    with_roll = ry - side * br
    left = Together(with_roll / math.sqrt(rest * rr), seconds, math.sqrt(rest / rr))
    if abs(left.correlation) < _GOES_ALONG or not _near_one(with_roll / rr, _NEAR_ONE):
        return None
    both = Together(joint / math.sqrt(own * along), seconds, math.sqrt(along / own))
    sure = (
        abs(both.correlation) >= _LEAST
        and both.sign == left.sign
        and _near_one(gravity, _NEAR_ONE)
        and _near_one(bends, _SCALE)
    )
    return Gravity(left, left if sure else None)


def _near_one(factor: float, most: float) -> bool:
    return 1 / most < abs(factor) < most


def roll_tells(
    grid: Grid, plain: Together | None, changes: tuple[FloatArray, FloatArray], least: tuple[float, float]
) -> tuple[Together | None, str]:
    """How a roll angle goes with the lateral acceleration, whatever the roads do, and by which part of that one (empty: by all of it).

    plain: of both as they are. changes: (n,) each, the rates of change of both. least: the correlations from which both as they are, and
    their quick changes, tell.
    """
    gravity = gravity_with_roll(grid)
    sudden = compare(quick(changes[0]), quick(changes[1]))
    told = sudden if sudden is not None and abs(sudden.correlation) >= least[1] else None
    if gravity is not None and gravity.sure is not None and (told is None or told.sign == gravity.sure.sign):
        return gravity.sure, PART
    if plain is None or abs(plain.correlation) < least[0]:
        return swift_tells(*changes), ""
    if told is None and gravity is not None and gravity.left.sign != plain.sign:
        return None, ""  # bends alone would turn an angle that gravity bears out
    return told_by(grid, plain, changes, least[1]), ""
