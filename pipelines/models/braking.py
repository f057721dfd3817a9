"""Forces, slips and axle loads of a braking vehicle, as Park & Choi write them. Braking forces and slips are positive.

Pure functions on arrays of one shape (n,), SI. v, vf, vr: speed and circumferential wheel speeds of the axles;
f_x: longitudinal specific force in the road plane (negative under braking), which is acceleration on a flat road.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray

AIR_DENSITY = 1.204
"""kg/m³ at 20 °C at sea level."""


@dataclass(frozen=True)
class LongitudinalCar:
    """What (1)-(13) take as known. mass_kg: m0. inertia: of one wheel. drag_area_m2: C_d A."""

    mass_kg: float
    front_m: float
    rear_m: float
    wheel_radius_m: float
    wheel_inertia_kgm2: float
    drag_area_m2: float

    @property
    def wheelbase_m(self) -> float:
        """l_f + l_r."""
        return self.front_m + self.rear_m


def axle_braking_force(
    torque: FloatArray, wheel_acceleration: FloatArray, radius: float, inertia: float
) -> FloatArray:
    """Braking force of an axle's two tyres in N, (1): brake torque of both wheels less what slows them down.

    torque: N·m, both wheels. wheel_acceleration: m/s² at the circumference, negative under braking.
    """
    return np.asarray((torque + 2 * inertia * wheel_acceleration / radius) / radius)


def drag(speed: FloatArray, area: float) -> FloatArray:
    """Aerodynamic drag in N, (10b)."""
    return np.asarray(0.5 * AIR_DENSITY * area * speed**2)


def front_load_share(
    front_force: FloatArray, rear_force: FloatArray, speed: FloatArray, front: FloatArray, rear: FloatArray
) -> FloatArray:
    """F_zf / (m g) by (7)-(8): the tyres of both axles have one normalised slip stiffness.

    front, rear: wheel speeds. NaN where neither axle brakes.
    """
    ahead = front_force * (speed - rear)
    total = ahead + rear_force * (speed - front)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = ahead / total
    return np.where(np.isfinite(share), share, np.nan)


def lrls_terms(
    share: FloatArray, f_x: FloatArray, speed: FloatArray, car: LongitudinalCar
) -> tuple[FloatArray, FloatArray]:
    """y (n,) of (12) and the terms (n, 3) of (13) for θ = (m_add, h): y = a θ1 + b θ2 + c θ1 θ2."""
    moment = GRAVITY * share * car.wheelbase_m
    y = car.mass_kg * (moment - GRAVITY * car.rear_m)
    a = GRAVITY * car.rear_m - moment
    b = -(car.mass_kg * f_x + drag(speed, car.drag_area_m2))
    return np.asarray(y), np.stack([a, b, -f_x], axis=1)
