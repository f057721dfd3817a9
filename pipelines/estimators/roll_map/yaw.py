"""What yaw acceleration does to roll, as a distance along the vehicle that the accelerometer seems to be off by.

An accelerometer d ahead of the CG reads d times the yaw acceleration r' on top of the CG's. And r' itself rolls the body: by the
product of inertia, I_xz r', and by the roll axis' slope, as the axles push apart with ± I_zz r'/L at roll centres of unequal
height: I_zz (h_r - h_f)/L r'. Both over m h, with I_zz = m x (1 - x) L² (the CG x L behind the front axle), are a distance

    d - x (1 - x) L² (I_xz/I_zz + (h_r - h_f)/L) / h

whose last part is of some 0.1 m to either side: ordinary cars are low in front, which turns them into the bend less (I_xz below
zero in axes forward and up), and their roll axis rises to the rear, which does the opposite; with a pickup's both act alike (0.2 m).
There, left out, c of quick steering comes out 20-30 % too small and the natural frequency 8 % too high.
"""

from __future__ import annotations

import math

from pipelines.vehicles.priors import measured_cg_height, measured_product
from pipelines.vehicles.usual import usual_roll_axis
from pipelines.vehicles.vehicle import Vehicle

REAR_HIGHER = 0.06
"""m: roll centre of the rear over that of the front axle, where the vehicle file tells neither."""

USUAL_SHARE, USUAL_BASE, USUAL_HEIGHT = 0.45, 2.7, 0.58
LEAST_ARM = 0.2

OPEN = 0.09
"""m: what the product's spread and roll centres known to 2 cm leave open. It is not left to the fit, in which a free distance takes up
tyres and filters (it moved away from the truth), but counted as open besides (a consider parameter)."""


def _rolled(vehicle: Vehicle) -> float:
    """m: x (1 - x) L² (I_xz/I_zz + (h_r - h_f)/L)/h from what the vehicle file tells and what is usual."""
    base = vehicle.get("wheelbase_m")
    length = USUAL_BASE if base is None else base.value
    behind = vehicle.get("cg_to_front_axle_m")
    share = USUAL_SHARE if behind is None else min(max(behind.value / length, 0.2), 0.8)
    front, rear = (vehicle.get(f"roll_center_height_{axle}_m") for axle in ("front", "rear"))
    known = front is not None and rear is not None
    slope = (rear.value - front.value if front is not None and rear is not None else REAR_HIGHER) / length
    axis = (
        (1 - share) * front.value + share * rear.value
        if known and front and rear
        else usual_roll_axis(vehicle)[0]
    )
    stated, usual = vehicle.get("cg_height_m"), measured_cg_height(vehicle.body, None, vehicle.powertrain)
    height = stated.value if stated is not None else usual.value if usual is not None else USUAL_HEIGHT
    product = measured_product(vehicle.body)[0]
    return share * (1 - share) * length * length * (product + slope) / max(height - axis, LEAST_ARM)


def yaw_lever(vehicle: Vehicle) -> tuple[float, float] | None:
    """The distance and how well the accelerometer's part of it is known, in m; None where its place is not."""
    behind, axle = vehicle.sensors.get("imu_behind_front_axle_m"), vehicle.get("cg_to_front_axle_m")
    if behind is None:
        return None
    if axle is not None:
        return axle.value - behind.value - _rolled(vehicle), math.hypot(behind.std, axle.std)
    wheelbase = vehicle.get("wheelbase_m")
    length = USUAL_BASE if wheelbase is None else wheelbase.value
    return USUAL_SHARE * length - behind.value - _rolled(vehicle), math.hypot(behind.std, 0.07 * length)
