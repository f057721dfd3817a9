"""Accelerations along and across that are exchanged: a unit that is mounted sideways, or two channels that changed places.

A unit that a quarter turn about the vertical axis has put aside feels bends as braking and braking as bends. What it says is not turned
back here: the channels' names would no longer be true. It is left out, and the sentence says what a mapping file must hold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray, Grid, Together, compare
from parsers.checks.motion import path_turn_rate, smooth, vehicle_speed
from parsers.checks.signs import MIN_LATERAL, excited
from parsers.drive import Decision

_LEAST = 0.7
"""Correlation of both accelerations with the other's motion."""
_CLEARER = 0.3
"""By which that must be above the correlation with their own."""
_MIN_CHANGE = 0.5
_TURNS = ("roll", "pitch", "roll_rate", "pitch_rate")


@dataclass(frozen=True)
class Sideways:
    """names: signals of which none can be used; decision: the sentence about them."""

    names: frozenset[str]
    decision: Decision


def sideways(grid: Grid) -> Sideways | None:
    """Find accelerations that each show the other's motion; None where they do not or the drive has too little of both."""
    speed, turning = vehicle_speed(grid), grid.get("yaw_rate")
    turning = path_turn_rate(grid) if turning is None else turning
    along, across = grid.get("accel_x"), grid.get("accel_y")
    if speed is None or turning is None or along is None or across is None:
        return None
    bends, change = turning * speed, grid.rate(smooth(np.abs(speed)))
    if not (excited(bends, MIN_LATERAL) and excited(change, _MIN_CHANGE)):
        return None
    moving = np.abs(speed) > 1.0
    crossed = _clearer(along, bends, change, moving), _clearer(across, change, bends, moving)
    if crossed[0] is None or crossed[1] is None:
        return None
    signs = crossed[0].sign, crossed[1].sign
    evidence = (
        f"accel_x goes with yaw_rate × speed (correlation {crossed[0].correlation:+.2f}), "
        f"accel_y with the change of speed ({crossed[1].correlation:+.2f}) over {crossed[0].seconds:.0f} s"
    )
    return _exchanged(signs, evidence) if signs[0] == signs[1] else _turned(grid, signs[0], evidence)


def _clearer(values: FloatArray, other: FloatArray, own: FloatArray, moving: BoolArray) -> Together | None:
    """How an acceleration goes with the other direction's motion, if it does so clearly better than with its own."""
    crossed, right = compare(smooth(values), other, moving), compare(smooth(values), own, moving)
    if crossed is None or abs(crossed.correlation) < _LEAST:
        return None
    if right is not None and abs(crossed.correlation) < abs(right.correlation) + _CLEARER:
        return None
    return crossed


def _exchanged(signs: tuple[int, int], evidence: str) -> Sideways:
    sign = "" if signs[0] > 0 else ", both with scale -1"
    return Sideways(
        frozenset({"accel_x", "accel_y"}),
        Decision(
            "accel_x", "sign", "accel_x and accel_y are exchanged",
            f"both left out; a mapping file can give each the other's channel{sign}", evidence, applied=True,
        ),
    )  # fmt: skip


def _turned(grid: Grid, bends: int, evidence: str) -> Sideways:
    """bends: sign with which the unit's x axis shows bends; + where it points to the left."""
    # what the same table holds of turning is the unit's as well, as far as can be told
    group = {name: signal.group for name, signal in grid.made_of.items()}
    turns = tuple(n for n in _TURNS if n in grid.columns and group.get(n) == group.get("accel_x"))
    names = ("accel_x", "accel_y", *turns)
    x, y = ("-1 × accel_y's", "accel_x's") if bends > 0 else ("accel_y's", "-1 × accel_x's")
    return Sideways(
        frozenset(names),
        Decision(
            "accel_x", "sign",
            f"the inertial unit is mounted sideways: its x axis points {'left' if bends > 0 else 'right'}, a quarter turn about the vertical axis",
            f"{', '.join(names[:-1])} and {names[-1]} left out; a mapping file can turn them: accel_x = {x} channel, accel_y = {y} channel, "
            "roll and pitch with their rates in the same way",
            evidence, applied=True,
        ),
    )  # fmt: skip
