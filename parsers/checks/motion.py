"""What the satellites, the wheels and the springs say of a vehicle's motion: references for other signals."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import CELL_S, Grid

EARTH_RADIUS_M = 6_371_000.0
MIN_SPEED = 3.0
"""m/s: below it a path has no direction, and reversing is usual."""


def smooth(values: FloatArray, cells: int = 5) -> FloatArray:
    """Running mean over an odd number of cells; NaN where any of them is NaN."""
    if len(values) < cells:
        return np.full(len(values), np.nan)
    valid = np.isfinite(values)
    kernel = np.full(cells, 1.0 / cells)
    means = np.convolve(np.where(valid, values, 0.0), kernel, mode="same")
    whole = np.convolve(valid.astype(np.float64), kernel, mode="same") > 1 - 0.5 / cells
    return np.where(whole, means, np.nan)


def path_velocity(grid: Grid) -> tuple[FloatArray, FloatArray] | None:
    """East and north velocity from latitude and longitude, m/s, or None without them."""
    latitude, longitude = grid.get("latitude"), grid.get("longitude")
    if latitude is None or longitude is None:
        return None
    radians = np.deg2rad(latitude)
    east = grid.rate(smooth(np.deg2rad(longitude)))
    north = grid.rate(smooth(radians))
    return east * EARTH_RADIUS_M * np.cos(radians), north * EARTH_RADIUS_M


def path_speed(grid: Grid) -> FloatArray | None:
    """Speed over ground from the satellites' positions, m/s."""
    velocity = path_velocity(grid)
    return None if velocity is None else np.hypot(*velocity)


def path_turn_rate(grid: Grid) -> FloatArray | None:
    """Turn rate of the path, rad/s, positive to the left; NaN below `MIN_SPEED`."""
    velocity = path_velocity(grid)
    if velocity is None:
        return None
    east, north = velocity
    speed2 = east**2 + north**2
    turning = (east * grid.rate(north) - north * grid.rate(east)) / np.where(speed2 > 0, speed2, np.nan)
    return np.where(speed2 > MIN_SPEED**2, turning, np.nan)


def speed_names(grid: Grid) -> tuple[str, ...]:
    """The signals that `vehicle_speed` is, or is the mean of; none where it is the path's."""
    for name in ("speed", "gps_speed_2d", "gps_speed_3d"):
        if name in grid.columns:
            return (name,)
    wheels = ("wheel_speed_rl", "wheel_speed_rr")
    return wheels if all(name in grid.columns for name in wheels) else ()


def vehicle_speed(grid: Grid) -> FloatArray | None:
    """The best speed that is there: wheels or bus, satellites, path."""
    names = speed_names(grid)
    if len(names) == 1:
        return grid.columns[names[0]]
    return np.mean([grid.columns[name] for name in names], axis=0) if names else path_speed(grid)


def right_minus_left(grid: Grid, quantity: str) -> FloatArray | None:
    """Right wheel less left wheel of the rear axle, else of the front one."""
    for axle in ("r", "f"):
        left, right = grid.get(f"{quantity}_{axle}l"), grid.get(f"{quantity}_{axle}r")
        if left is not None and right is not None:
            return right - left
    return None


def seconds(mask: FloatArray | np.ndarray[tuple[int], np.dtype[np.bool_]]) -> float:
    """How long a condition holds."""
    return float(np.count_nonzero(mask)) * CELL_S
