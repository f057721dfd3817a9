"""What a sensor without errors would read: every canonical signal from the columns of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import FloatArray
from pipelines.simulation.records import PlantRun

METRES_A_DEGREE = 111_320.0
"""Of latitude, and of longitude at the equator."""

SATELLITES, HDOP = 12.0, 0.8
"""In the open."""

Source = Callable[[], FloatArray]


@dataclass(frozen=True)
class Fit:
    """What the sensors know of the vehicle and the place: wheel speeds are spin times a nominal rolling radius.

    origin: latitude and longitude [deg] and height [m] of the start.
    """

    rolling_radius_front_m: float = 0.33
    rolling_radius_rear_m: float = 0.33
    origin: tuple[float, float, float] = (48.137, 11.575, 520.0)


@dataclass(frozen=True)
class Mount:
    """Where and how an inertial unit is fixed to the body: behind the front axle, left of the middle, above ground at rest.

    misalignment_rad: roll, pitch and yaw that turn the body's axes into the unit's (about z, then y, then x);
    misalignment_std_rad: of what is drawn in addition, each angle.
    """

    behind_front_axle_m: float
    left_m: float
    above_ground_m: float
    misalignment_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    misalignment_std_rad: float = 0.0

    def scaled(self, factor: float) -> Mount:
        """The angles times a factor; the place stays."""
        roll, pitch, yaw = (factor * angle for angle in self.misalignment_rad)
        return replace(
            self,
            misalignment_rad=(roll, pitch, yaw),
            misalignment_std_rad=factor * self.misalignment_std_rad,
        )


def rotation(roll: float, pitch: float, yaw: float) -> FloatArray:
    """(3, 3) matrix whose columns are the turned axes in the old ones: turn by yaw about z, pitch about y, roll about x."""
    cr, sr, cp, sp, cy, sy = (f(angle) for angle in (roll, pitch, yaw) for f in (np.cos, np.sin))
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    return np.asarray(about_z @ about_y @ about_x)


def _vectors(run: PlantRun, names: tuple[str, str, str]) -> FloatArray:
    return np.stack([run.columns[name] for name in names])


def _rates(run: PlantRun) -> FloatArray:
    return _vectors(run, ("roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps"))


def specific_force_at(run: PlantRun, place: FloatArray) -> FloatArray:
    """(3, n) specific force in body axes at a place: accel + alpha x r + omega x (omega x r).

    place: (3,) behind the front axle, left, above ground, of the vehicle at rest.
    """
    cg = np.asarray(run.sprung_cg_m)
    # "behind" counts backwards, the body's x forwards
    arm = np.array([cg[0] - place[0], place[1] - cg[1], place[2] - cg[2]])[:, None]
    omega = _rates(run)
    alpha = _vectors(
        run, ("roll_acceleration_radps2", "pitch_acceleration_radps2", "yaw_acceleration_radps2")
    )
    accel = _vectors(run, ("accel_x_mps2", "accel_y_mps2", "accel_z_mps2"))
    turning = np.cross(omega, np.cross(omega, arm, axis=0), axis=0)
    return np.asarray(accel + np.cross(alpha, arm, axis=0) + turning)


def _attitude(run: PlantRun, turn: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Roll and pitch of the unit's axes against the horizon."""
    roll, pitch = run.columns["roll_rad"], run.columns["pitch_rad"]
    # the upward vertical, seen from the body
    up = np.stack([-np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)])
    x, y, z = turn.T @ up
    return np.asarray(np.arctan2(y, z)), np.asarray(-np.arcsin(np.clip(x, -1.0, 1.0)))


def mounted(run: PlantRun, mount: Mount | None) -> dict[str, Source]:
    """Accelerations, rates and angles of an inertial unit, in its own axes. None: at the sprung CG, straight."""
    if mount is None:
        turn, force = np.eye(3), _vectors(run, ("accel_x_mps2", "accel_y_mps2", "accel_z_mps2"))
    else:
        turn = rotation(*mount.misalignment_rad)
        place = np.array([mount.behind_front_axle_m, mount.left_m, mount.above_ground_m])
        force = specific_force_at(run, place)
    accel, rates = turn.T @ force, turn.T @ _rates(run)
    found: dict[str, Source] = {}
    for row, axis in enumerate("xyz"):
        found[f"accel_{axis}"] = partial(np.asarray, accel[row])
    for row, name in enumerate(("roll_rate", "pitch_rate", "yaw_rate")):
        found[name] = partial(np.asarray, rates[row])
    found["roll"] = lambda: _attitude(run, turn)[0]
    found["pitch"] = lambda: _attitude(run, turn)[1]
    return found


def _sum(columns: Mapping[str, FloatArray], names: list[str]) -> FloatArray:
    return np.asarray(np.sum([columns[name] for name in names], axis=0))


def _per_wheel(c: Mapping[str, FloatArray], fit: Fit, wheel: str) -> dict[str, Source]:
    same = {
        "accel_z_sprung": "mps2", "accel_z_unsprung": "mps2", "suspension_deflection": "m", "suspension_force": "n",
        "tire_normal_force": "n", "brake_torque": "nm", "drive_torque": "nm",
    }  # fmt: skip
    found: dict[str, Source] = {
        f"{name}_{wheel}": partial(np.asarray, c[f"{name}_{wheel}_{unit}"]) for name, unit in same.items()
    }
    radius = fit.rolling_radius_front_m if wheel.startswith("f") else fit.rolling_radius_rear_m
    found[f"wheel_speed_{wheel}"] = lambda: c[f"wheel_spin_{wheel}_radps"] * radius
    return found


def true_signals(run: PlantRun, fit: Fit) -> dict[str, Source]:
    """Every signal but those of an inertial unit: name -> a function that gives (n,) at the run's rate."""
    c = run.columns
    latitude, longitude, height = fit.origin
    east = METRES_A_DEGREE * np.cos(np.radians(latitude))
    found: dict[str, Source] = {
        "speed": lambda: c["speed_mps"],
        "gps_speed_2d": lambda: c["speed_mps"] * np.cos(c["road_grade_rad"]),
        "gps_speed_3d": lambda: c["speed_mps"],
        "latitude": lambda: latitude + c["y_m"] / METRES_A_DEGREE,
        "longitude": lambda: longitude + c["x_m"] / east,
        "altitude": lambda: height + c["altitude_m"],
        "satellites": lambda: np.full_like(c["speed_mps"], SATELLITES),
        "hdop": lambda: np.full_like(c["speed_mps"], HDOP),
        "steering_wheel_angle": lambda: c["steering_wheel_angle_rad"],
        "brake_pressure": lambda: c["brake_pressure_pa"],
        "road_grade": lambda: c["road_grade_rad"],
        "axle_load_front": lambda: _sum(c, [f"tire_normal_force_{w}_n" for w in ("fl", "fr")]),
        "axle_load_rear": lambda: _sum(c, [f"tire_normal_force_{w}_n" for w in ("rl", "rr")]),
        "brake_torque": lambda: _sum(c, [f"brake_torque_{w}_nm" for w in WHEELS]),
        "drive_torque": lambda: _sum(c, [f"drive_torque_{w}_nm" for w in WHEELS]),
    }
    for wheel in WHEELS:
        found |= _per_wheel(c, fit, wheel)
    return found
