"""Does the vehicle turn as far as its file says? Steering ratio and wheelbase of another vehicle show in every bend.

    delta v = i L r + i K v² r + c v

with the steering wheel's angle delta, speed v, yaw rate r, steering ratio i, wheelbase L and understeer gradient K: the
steady turn of the linear single-track model. Of i L the log tells the product alone, and variable racks make it vary by a tenth or
more: so it is said where it is far off, and nothing is repaired.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from parsers.checks.grid import make_grid
from parsers.checks.motion import smooth, vehicle_speed
from parsers.drive import Decision, Drive
from pipelines.prepare.block_slope import block_slopes
from pipelines.prepare.decided import decided
from pipelines.vehicles.vehicle import Vehicle

NEEDED = ("steering_wheel_angle", "yaw_rate")
BESIDE = (
    "speed",
    "gps_speed_2d",
    "gps_speed_3d",
    "wheel_speed_fl",
    "wheel_speed_fr",
    "wheel_speed_rl",
    "wheel_speed_rr",
)
SLOW, FAST = 3.0, 25.0
"""m/s between which a vehicle is looked at: slower the angle is large, faster the tyres' slip is."""

LATERAL = 4.0
"""m/s² of v r up to which tyres' slip angles grow in proportion."""

LEAST_RATE = 0.05
"""rad/s, rms beside the other columns: below it next to nothing is turned."""

USUAL, SURE = 0.2, 4.0
"""Share of the file's product by which racks with a variable ratio are off, and standard deviations that it must be off by."""


SHOWN = 0.08
"""Spread of the product over the file's up to which the drive tells whether both are of one vehicle."""


def steering_product(drive: Drive) -> tuple[float, float] | None:
    """Steering ratio times wheelbase by the log, m, and its standard deviation; None where the log does not tell."""
    signals = {
        n: drive.signals[n] for n in (*NEEDED, *BESIDE) if n in drive.signals and len(drive.signals[n].values)
    }
    if not {*NEEDED} <= signals.keys():
        return None
    grid = make_grid(signals)
    speed, angle, yaw = vehicle_speed(grid), grid.get("steering_wheel_angle"), grid.get("yaw_rate")
    if speed is None or angle is None or yaw is None:
        return None
    v, delta, r = (smooth(each) for each in (speed, angle, yaw))
    with np.errstate(invalid="ignore"):
        used = (v > SLOW) & (v < FAST) & (np.abs(v * r) < LATERAL)
    r = np.where(used, r, np.nan)
    found = block_slopes(r, (delta * v,), np.column_stack([v * v * r, v]), LEAST_RATE)
    return None if found is None else (abs(found.values[0]), found.std)


def steered(drive: Drive, vehicle: Vehicle) -> tuple[Drive, Vehicle]:
    """The drive, with a decision in its record where it turns unlike the vehicle file's vehicle, and the vehicle with what was found.

    What is not stated is not asked.
    """
    ratio, length = vehicle.get("steering_ratio"), vehicle.get("wheelbase_m")
    told = steering_product(drive) if ratio is not None and length is not None else None
    if told is None or ratio is None or length is None:
        return drive, vehicle
    product, std = told
    stated = ratio.value * length.value
    own = stated * math.hypot(ratio.std / ratio.value, length.std / length.value)
    if math.hypot(std, own) < SHOWN * stated:
        vehicle = replace(vehicle, turning=product / stated)
    if abs(product - stated) < max(USUAL * stated, SURE * math.hypot(std, own)):
        return drive, vehicle
    text = (
        f"steering ratio times wheelbase is {product:.1f} m by steering angle, yaw rate and speed, and {stated:.1f} m in the "
        "vehicle file"
    )
    action = "left as it is: look whether the file is this vehicle's, or its steering_ratio or wheelbase_m or the angle's unit is wrong"
    evidence = f"{product:.1f} ± {std:.1f} m; {product / stated:.2f} of the file's"
    decision = Decision("steering_wheel_angle", "vehicle", text, action, evidence, applied=False)
    return decided(drive, [decision]), vehicle
