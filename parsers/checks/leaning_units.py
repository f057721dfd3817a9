"""Accelerometers that read more at rest than any road makes them: the unit leans, or has that offset."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray, Grid
from parsers.checks.motion import seconds, smooth
from parsers.drive import Decision
from parsers.quantiles import median
from parsers.units import STANDARD_GRAVITY

_LEAST = 0.5
"""m/s²: a road's crossfall of 5 %, seldom more than half of it; brackets and boards are held to 2 degrees."""
_MIN_STILL_S = 3.0
_MIN_MOVING_S = 15.0
_MOVING = 3.0
LEANS = "the unit leans by"
"""Words of what is found, by which a later step that levels the unit takes it back."""
_KEPT = "left in: estimators take it as a parameter, but expect less; say how the unit is turned, or level it"


@dataclass(frozen=True)
class Reading:
    """What a horizontal accelerometer reads that no motion explains, m/s²: at rest, over rest_s, and on the move."""

    rest: float
    moving: float
    rest_s: float


def leaning_units(grid: Grid, speed: FloatArray | None, still: BoolArray) -> list[Decision]:
    """What is said of each horizontal acceleration. speed: (n,) m/s; still: (n,) where the vehicle stands."""
    return [_said(name, reading) for name, reading in readings(grid, speed, still).items()]


def readings(grid: Grid, speed: FloatArray | None, still: BoolArray) -> dict[str, Reading]:
    """Of each horizontal acceleration that reads more at rest than any road makes it.

    At rest a single place may slope. So the same must be left on the move, where yaw rate and the change of speed are taken off.
    """
    if speed is None:
        return {}
    yaw = grid.get("yaw_rate")
    parts = (("accel_y", None if yaw is None else yaw * speed), ("accel_x", grid.rate(smooth(speed))))
    found = ((name, _reading(grid.get(name), motion, speed, still)) for name, motion in parts)
    return {name: reading for name, reading in found if reading is not None}


def _reading(
    column: FloatArray | None, motion: FloatArray | None, speed: FloatArray, still: BoolArray
) -> Reading | None:
    if column is None or motion is None:
        return None
    rest = column[still & np.isfinite(column)]
    left = (column - motion)[np.abs(speed) > _MOVING]
    left = left[np.isfinite(left)]
    rest_s = seconds(np.isfinite(rest))
    if len(rest) == 0 or rest_s < _MIN_STILL_S or seconds(np.isfinite(left)) < _MIN_MOVING_S:
        return None
    reads, moving = median(rest), median(left)
    if min(abs(reads), abs(moving)) < _LEAST or reads * moving < 0:
        return None
    return Reading(reads, moving, rest_s)


def _said(name: str, reading: Reading) -> Decision:
    angle = math.degrees(math.asin(min(abs(reading.rest) / STANDARD_GRAVITY, 1.0)))
    return Decision(
        signal=name,
        kind="offset",
        found=f"{name} reads {reading.rest:.2f} m/s² at rest: {LEANS} {angle:.1f}°, or has that offset",
        action=_KEPT,
        evidence=f"over {reading.rest_s:.0f} s at rest; {reading.moving:.2f} m/s² are left on the move, so it is no slope",
        applied=False,
    )
