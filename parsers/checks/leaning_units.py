"""Accelerometers that read more at rest than any road makes them: the unit leans, or has that offset."""

from __future__ import annotations

import math
from collections.abc import Iterator

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
_KEPT = "left in: estimators take it as a parameter, but expect less; say how the unit is turned, or level it"


def leaning_units(grid: Grid, speed: FloatArray | None, still: BoolArray) -> list[Decision]:
    """What is said of each horizontal acceleration. speed: (n,) m/s; still: (n,) where the vehicle stands.

    At rest a single place may slope. So the same must be left on the move, where yaw rate and the change of speed are taken off.
    """
    if speed is None:
        return []
    yaw = grid.get("yaw_rate")
    parts = (("accel_y", None if yaw is None else yaw * speed), ("accel_x", grid.rate(smooth(speed))))
    return [each for name, part in parts for each in _said(grid, name, part, speed, still)]


def _said(
    grid: Grid, name: str, motion: FloatArray | None, speed: FloatArray, still: BoolArray
) -> Iterator[Decision]:
    column = grid.get(name)
    if column is None or motion is None:
        return
    rest = column[still & np.isfinite(column)]
    left = (column - motion)[np.abs(speed) > _MOVING]
    left = left[np.isfinite(left)]
    if (
        len(rest) == 0
        or seconds(np.isfinite(rest)) < _MIN_STILL_S
        or seconds(np.isfinite(left)) < _MIN_MOVING_S
    ):
        return
    reads, moving = median(rest), median(left)
    if min(abs(reads), abs(moving)) < _LEAST or reads * moving < 0:
        return
    angle = math.degrees(math.asin(min(abs(reads) / STANDARD_GRAVITY, 1.0)))
    yield Decision(
        signal=name,
        kind="offset",
        found=f"{name} reads {reads:.2f} m/s² at rest: the unit leans by {angle:.1f}°, or has that offset",
        action=_KEPT,
        evidence=f"over {seconds(np.isfinite(rest)):.0f} s at rest; {moving:.2f} m/s² are left on the move, so it is no slope",
        applied=False,
    )
