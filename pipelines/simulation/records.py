"""What the plant is given and what it gives: the driver's demand, the road, and the true motion.

Every part of the simulation speaks through these records: manoeuvres and roads make a Demand and a Road, the plant
turns them into a PlantRun, sensors turn that into a log.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import FloatArray

GRAVITY = 9.80665


@dataclass(frozen=True)
class Demand:
    """What the driver does, over time, at even steps of step_s from 0.

    All shape (n,). steering_wheel_angle_rad: open loop, + left; the driver's curvature following is added where the
    road has curvature. target_speed_mps: what the driver's speed control aims at with drive and brake torque; NaN =
    both feet off. brake_pressure_pa: master-cylinder pressure by the foot; while it is above 0 the speed control rests.
    drive_torque_nm: sum over the driven wheels, by the foot, + forward; added to the speed control's.
    steady_at_start: the run begins at target_speed_mps[0] in equilibrium (a standing start needs a target of 0).
    """

    step_s: float
    steering_wheel_angle_rad: FloatArray
    target_speed_mps: FloatArray
    brake_pressure_pa: FloatArray
    drive_torque_nm: FloatArray

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        return self.step_s * (len(self.target_speed_mps) - 1)


@dataclass(frozen=True)
class Road:
    """The road under the vehicle, over the distance travelled, at even steps of step_m from 0. All shape (m,).

    curvature_1pm: + left, followed by the driver (0 = straight or free field). grade_rad: + uphill. bank_rad: + left
    side higher. left_m, right_m: height of the two wheel tracks above the smooth road (roughness); the rear wheels meet
    them a wheelbase later. friction_left, friction_right: peak friction coefficients. Beyond its end the last row holds.
    """

    step_m: float
    curvature_1pm: FloatArray
    grade_rad: FloatArray
    bank_rad: FloatArray
    left_m: FloatArray
    right_m: FloatArray
    friction_left: FloatArray
    friction_right: FloatArray


def straight_road(length_m: float, friction: float = 0.95, step_m: float = 1.0) -> Road:
    """A flat, smooth, straight road: what most test manoeuvres stand on."""
    rows = int(np.ceil(length_m / step_m)) + 2
    zero = np.zeros(rows)
    grip = np.full(rows, friction)
    return Road(step_m, zero, zero, zero, zero, zero, grip, grip)


@dataclass(frozen=True)
class Air:
    """What the vehicle drives through. density in kg/m³; wind in m/s, constant: toward where the drive's start heads, and left of that.

    Raises ValueError, naming the field, where one cannot be.
    """

    density_kgpm3: float = 1.2
    wind_ahead_mps: float = 0.0
    wind_left_mps: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        for name, low, high in (
            ("density_kgpm3", 0.5, 2.0),
            ("wind_ahead_mps", -30.0, 30.0),
            ("wind_left_mps", -30.0, 30.0),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f"{name} is {value:g}: expected {low:g} to {high:g}")


_BODY: tuple[str, ...] = (
    "distance_m", "x_m", "y_m", "altitude_m", "heading_rad", "speed_mps", "velocity_x_mps", "velocity_y_mps",
    "roll_rad", "pitch_rad", "roll_against_road_rad", "pitch_against_road_rad", "heave_m",
    "roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps",
    "roll_acceleration_radps2", "pitch_acceleration_radps2", "yaw_acceleration_radps2",
    "accel_x_mps2", "accel_y_mps2", "accel_z_mps2",
    "steering_wheel_angle_rad", "brake_pressure_pa", "road_grade_rad", "road_bank_rad", "energy_j",
)  # fmt: skip
_WHEEL: tuple[tuple[str, str], ...] = (
    ("wheel_spin", "radps"), ("wheel_steer", "rad"), ("suspension_deflection", "m"), ("suspension_velocity", "mps"),
    ("suspension_force", "n"), ("tire_normal_force", "n"), ("tire_longitudinal_force", "n"), ("tire_lateral_force", "n"),
    ("accel_z_sprung", "mps2"), ("accel_z_unsprung", "mps2"), ("brake_torque", "nm"), ("drive_torque", "nm"), ("road", "m"),
)  # fmt: skip

RUN_COLUMNS: tuple[str, ...] = (
    *_BODY,
    *(f"{name}_{wheel}_{unit}" for name, unit in _WHEEL for wheel in WHEELS),
)
"""The columns of every PlantRun, in order."""


@dataclass(frozen=True)
class PlantRun:
    """The true motion at an even rate, before any sensor. columns: every name of RUN_COLUMNS -> (n,), SI, ISO 8855.

    velocity_x/y: of the whole vehicle's CG, in the road plane, along and across the heading; speed is their length.
    roll, pitch: of the body against the horizon; …_against_road: against the road plane under the vehicle.
    heave: sprung CG's displacement from rest, normal to the road. Rates are those of a gyro fixed in the body.
    accel: specific force at the sprung CG in body axes (+9.81 in z at rest), so that a sensor at r from there reads
    accel + alpha x r + omega x (omega x r). suspension_deflection: compression at the wheel from the EMPTY vehicle at
    rest; suspension_velocity its rate; suspension_force: vertical force on the body, with the bar's and the friction's
    part. accel_z_sprung/unsprung: vertical acceleration of the body over the wheel and of the hub, 0 at rest (no
    gravity). road: height of the road surface under the wheel (roughness). energy: kinetic plus potential, for tests.

    truth: parameter name (pipelines.parameters) -> value of the LOADED vehicle. sprung_cg_m: place of the sprung CG
    from the middle of the front axle's ground point: behind it, left of the middle, above the ground at rest.
    """

    rate_hz: float
    time_s: FloatArray
    columns: Mapping[str, FloatArray]
    truth: Mapping[str, float]
    sprung_cg_m: tuple[float, float, float]
