"""The paper's car as a drive: what a log of it would hold, for the tests of the observer and its companion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.reproduce.park.plant import ParkCar, ParkDemand, ParkRun, drive_park
from pipelines.vehicles.vehicle import Quantity, Vehicle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """What the sensors do wrong: standard deviations, offsets, and a late satellite speed at its own rate."""

    noise: float = 1.0
    accel_x: float = 0.0
    accel_y: float = 0.0
    roll_rate: float = 0.0
    speed_delay_s: float = 0.0
    speed_hz: float = 100.0
    radius_front: float = 0.0
    radius_rear: float = 0.0


def _signal(name: str, time_s: Array, values: Array) -> Signal:
    return Signal(name, np.round(time_s * 1e9).astype(np.int64), values, f"simulated {name}")


def park_drive(
    car: ParkCar, demand: ParkDemand, errors: Errors, seed: int = 0, without: tuple[str, ...] = ()
) -> Drive:
    """A run as a log: IMU, wheels and pressure at 100 Hz, satellite speed at its rate and late."""
    rng = np.random.default_rng(seed)
    run: ParkRun = drive_park(car, demand)
    t = run.time

    def noisy(values: Array, std: float, offset: float = 0.0) -> Array:
        return np.asarray(values + offset + errors.noise * std * rng.standard_normal(len(values)))

    front, rear = run.front * (1 + errors.radius_front), run.rear * (1 + errors.radius_rear)
    slow = t[:: round(100 / errors.speed_hz)]
    v = np.interp(slow - errors.speed_delay_s, t, run.v)
    table = {
        "accel_x": noisy(run.f_x, 0.05, errors.accel_x),
        "accel_y": noisy(run.f_y, 0.05, errors.accel_y),
        "roll_rate": noisy(run.roll_rate, 0.003, errors.roll_rate),
        "yaw_rate": noisy(run.yaw_rate, 0.003),
        "wheel_speed_fl": noisy(front, 0.02),
        "wheel_speed_fr": noisy(front, 0.02),
        "wheel_speed_rl": noisy(rear, 0.02),
        "wheel_speed_rr": noisy(rear, 0.02),
        "brake_pressure": np.maximum(noisy(run.pressure, 2e4), 0.0),
        "drive_torque": noisy(run.drive_force * car.wheel_radius, 5.0),
        "steering_wheel_angle": noisy(run.curvature * 2.573 * 15.0, 0.005),
    }
    signals = {n: _signal(n, t, values) for n, values in table.items() if n not in without}
    if "gps_speed_2d" not in without:
        signals["gps_speed_2d"] = _signal("gps_speed_2d", slow, noisy(v, 0.02))
    record = ImportRecord("simulated", (), "", "complete", 0, {}, (), "clock", None, float(t[-1]), ())
    return Drive(signals, record, 0)


def park_vehicle(car: ParkCar, *, load_std: float = 5.0, brake_std: float = 0.01, **stds: float) -> Vehicle:
    """Table I as a vehicle file with the load told; stds: relative standard deviations by quantity."""
    table = {
        "mass_kg": car.nominal_kg,
        "wheelbase_m": car.front_m + car.rear_m,
        "cg_to_front_axle_m": car.front_m,
        "cg_height_m": 0.563,
        "wheel_radius_m": car.wheel_radius,
        "wheel_inertia_kgm2": car.wheel_inertia,
        "drag_area_m2": car.drag_area,
        "brake_gain_nmppa": car.brake_gain,
        "brake_front_share": car.brake_front,
        "roll_stiffness_nmprad": car.roll_stiffness,
        "roll_damping_nmsprad": car.roll_damping,
        "roll_inertia_kgm2": car.roll_inertia,
        "roll_center_height_front_m": car.roll_centre,
        "roll_center_height_rear_m": car.roll_centre,
        "track_front_m": 1.56,
        "track_rear_m": 1.56,
        # the paper's k_t is of the body against the road: tyres that hardly give leave it as it is
        "tire_vertical_rate_npm": 2.0e7,
        "rolling_resistance": 1e-6,
    }
    relative = {"brake_gain_nmppa": brake_std, "brake_front_share": brake_std, **stds}
    quantities = {n: Quantity(v, abs(v) * relative.get(n, 0.003), "vehicle file") for n, v in table.items()}
    if "cg_height_m" not in stds:
        quantities["cg_height_m"] = replace(quantities["cg_height_m"], std=0.05)
    return Vehicle(
        "park",
        None,
        quantities,
        {"mass_kg": Quantity(car.added_kg, load_std, "vehicle file")},
        {},
        {"cg_height_m": car.height, "mass_kg": car.mass},
    )


def joined(*demands: ParkDemand) -> ParkDemand:
    """Demands one after the other; the first one's start."""

    def together(name: str) -> Array:
        return np.concatenate([getattr(d, name) for d in demands])

    return ParkDemand(
        together("curvature"),
        together("speed"),
        together("grade"),
        together("pressure"),
        demands[0].start_mps,
    )
