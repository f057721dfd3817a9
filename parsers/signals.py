"""The canonical signals: what every log is brought into. SI units, ISO 8855 axes, wheels fl, fr, rl, rr."""

from __future__ import annotations

from dataclasses import dataclass

WHEELS: tuple[str, ...] = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True)
class SignalSpec:
    """One canonical signal.

    name: as in a mapping file ("accel_y", "wheel_speed_fl"). column: name and unit, as in the store.
    quantity: what `parsers.units` converts ("acceleration"). low, high: beyond these no road vehicle goes, so that
    a sample there is an error of the log (SI).
    """

    name: str
    column: str
    quantity: str
    description: str
    low: float
    high: float


def _one(
    name: str, suffix: str, quantity: str, description: str, low: float, high: float
) -> list[SignalSpec]:
    column = f"{name}_{suffix}" if suffix else name
    return [SignalSpec(name, column, quantity, description, low, high)]


def _wheels(
    name: str, suffix: str, quantity: str, description: str, low: float, high: float
) -> list[SignalSpec]:
    return [
        SignalSpec(f"{name}_{w}", f"{name}_{w}_{suffix}", quantity, f"{description}, wheel {w}", low, high)
        for w in WHEELS
    ]


_TABLE: list[SignalSpec] = [
    *_one("accel_x", "mps2", "acceleration", "longitudinal specific force, + forward", -160, 160),
    *_one("accel_y", "mps2", "acceleration", "lateral specific force, + left", -160, 160),
    *_one("accel_z", "mps2", "acceleration", "vertical specific force, +9.81 at rest", -160, 160),
    *_one("roll_rate", "radps", "angular_rate", "roll rate, + right side down", -10, 10),
    *_one("pitch_rate", "radps", "angular_rate", "pitch rate, + nose down", -10, 10),
    *_one("yaw_rate", "radps", "angular_rate", "yaw rate, + turning left", -10, 10),
    *_one("roll", "rad", "angle", "roll angle of the body, + right side down", -1.6, 1.6),
    *_one("pitch", "rad", "angle", "pitch angle of the body, + nose down", -1.6, 1.6),
    *_one("speed", "mps", "speed", "vehicle speed", -30, 110),
    *_one("gps_speed_2d", "mps", "speed", "horizontal speed from satellites", -1, 110),
    *_one("gps_speed_3d", "mps", "speed", "speed in space from satellites", -1, 110),
    *_one("latitude", "deg", "geographic_angle", "latitude, + north", -90, 90),
    *_one("longitude", "deg", "geographic_angle", "longitude, + east", -180, 180),
    *_one("altitude", "m", "length", "height above sea level or ellipsoid", -500, 9000),
    *_one("satellites", "", "count", "satellites in use", 0, 100),
    *_one("hdop", "", "ratio", "horizontal dilution of precision", 0, 100),
    *_wheels("wheel_speed", "mps", "speed", "circumferential wheel speed", -30, 140),
    *_one("steering_wheel_angle", "rad", "angle", "steering-wheel angle, + left", -35, 35),
    *_one("brake_pressure", "pa", "pressure", "brake pressure in the master cylinder", -2e6, 3.5e7),
    *_wheels(
        "accel_z_sprung",
        "mps2",
        "acceleration",
        "vertical acceleration of the body over the wheel",
        -500,
        500,
    ),
    *_wheels("accel_z_unsprung", "mps2", "acceleration", "vertical acceleration of the hub", -2000, 2000),
    *_wheels("suspension_deflection", "m", "length", "compression at the wheel, + compressed", -0.6, 0.6),
    *_wheels("suspension_force", "n", "force", "vertical force of the suspension on the body", -2e5, 2e5),
    *_one("axle_load_front", "n", "force", "load on the front axle", 0, 4e5),
    *_one("axle_load_rear", "n", "force", "load on the rear axle or axles", 0, 4e5),
    *_wheels("tire_normal_force", "n", "force", "normal force between tyre and road", -1e4, 2e5),
    *_one("road_grade", "rad", "slope", "slope of the road, + uphill", -0.8, 0.8),
    *_one("brake_torque", "nm", "torque", "brake torque, sum over the wheels", -1e5, 1e5),
    *_one("drive_torque", "nm", "torque", "drive torque, sum over the wheels", -1e5, 1e5),
    *_wheels("brake_torque", "nm", "torque", "brake torque", -5e4, 5e4),
    *_wheels("drive_torque", "nm", "torque", "drive torque", -5e4, 5e4),
]

SIGNALS: dict[str, SignalSpec] = {spec.name: spec for spec in _TABLE}
"""By name ("accel_y"); `COLUMNS` by column ("accel_y_mps2")."""

COLUMNS: dict[str, SignalSpec] = {spec.column: spec for spec in _TABLE}

WHEEL_SPEEDS: tuple[str, ...] = tuple(f"wheel_speed_{w}" for w in WHEELS)
SUSPENSION_DEFLECTIONS: tuple[str, ...] = tuple(f"suspension_deflection_{w}" for w in WHEELS)
