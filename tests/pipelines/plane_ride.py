"""A rigid body on four struts by inverse dynamics: motion first, then the forces that it needs. For roll and pitch plane.

Built otherwise than the plant and the estimators: no springs, no tyres; the struts carry what Newton and Euler ask for, the
warp between the diagonals is drawn. Wheels weigh nothing unless the file says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665
RATE_HZ = 100.0
WHEELS = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True)
class Rigid:
    """The body: CG behind the front axle, left of the middle, above ground; arms above the roll and pitch axes."""

    mass: float = 1700.0
    roll_inertia: float = 650.0
    pitch_inertia: float = 2600.0
    roll_arm: float = 0.55
    pitch_arm: float = 0.5
    behind: float = 1.35
    left: float = 0.02
    height: float = 0.65
    wheelbase: float = 2.8
    track: float = 1.6
    imu: tuple[float, float] = (1.2, 0.45)
    """Behind the front axle, above ground."""


@dataclass(frozen=True)
class Faults:
    """Noise: forces N, accelerations m/s², body accelerometers m/s², gyros rad/s. friction: N a strut not seen by its sensor."""

    force: float = 20.0
    accel: float = 0.03
    corner: float = 0.08
    gyro: float = 0.002
    friction: float = 0.0


@dataclass(frozen=True)
class Push:
    """rms of: lateral, longitudinal and vertical acceleration m/s², roll and pitch acceleration rad/s²."""

    lateral: float = 1.5
    longitudinal: float = 1.2
    heave: float = 0.5
    roll: float = 0.4
    pitch: float = 0.3
    seconds: float = 120.0


def _band(rng: np.random.Generator, n: int, low: float, high: float, rms: float) -> FloatArray:
    """Band-limited noise (n,)."""
    frequency = np.fft.rfftfreq(n, 1 / RATE_HZ)
    inside = (frequency >= low) & (frequency <= high)
    spectrum = inside * (rng.standard_normal(len(frequency)) + 1j * rng.standard_normal(len(frequency)))
    values = np.fft.irfft(spectrum, n)
    return np.asarray(rms * values / max(float(np.std(values)), 1e-12))


def ride(body: Rigid, push: Push, rng: np.random.Generator) -> dict[str, FloatArray]:
    """True signals by name at 100 Hz."""
    n = round(push.seconds * RATE_HZ)
    fy, fx = (_band(rng, n, 0.02, 0.7, rms) for rms in (push.lateral, push.longitudinal))
    roll_acc, pitch_acc = (_band(rng, n, 0.6, 3.5, rms) for rms in (push.roll, push.pitch))
    up = _band(rng, n, 0.6, 3.0, push.heave)
    fz = G + up
    total = body.mass * fz
    roll = body.roll_inertia * roll_acc - body.mass * body.roll_arm * fy + body.left * total
    middle = body.behind - body.wheelbase / 2
    pitch = body.pitch_inertia * pitch_acc + body.mass * body.pitch_arm * fx + middle * total
    rear = 0.5 * total + pitch / body.wheelbase
    front = total - rear
    across = roll / body.track
    share = 0.55 * across + _band(rng, n, 0.1, 3.0, 80.0)
    found = {
        "suspension_force_fl": 0.5 * front + share, "suspension_force_fr": 0.5 * front - share,
        "suspension_force_rl": 0.5 * rear + across - share, "suspension_force_rr": 0.5 * rear - across + share,
    }  # fmt: skip
    ahead, above = body.behind - body.imu[0], body.imu[1] - body.height
    found["accel_x"] = fx + pitch_acc * above
    found["accel_y"] = fy - roll_acc * above
    found["accel_z"] = fz - pitch_acc * ahead
    for wheel in WHEELS:
        x = body.behind - (0.0 if wheel[0] == "f" else body.wheelbase)
        y = (0.5 if wheel[1] == "l" else -0.5) * body.track - body.left
        found[f"accel_z_sprung_{wheel}"] = up + y * roll_acc - x * pitch_acc
    found["roll_rate"] = np.cumsum(roll_acc) / RATE_HZ
    found["pitch_rate"] = np.cumsum(pitch_acc) / RATE_HZ
    found["speed"] = np.full(n, 15.0)
    found["yaw_rate"] = fy / 15.0
    found["brake_pressure"] = np.where(fx < 0, 2e6, 0.0)
    for wheel in WHEELS:
        force = found[f"suspension_force_{wheel}"]
        found[f"suspension_deflection_{wheel}"] = (force - force.mean()) / 30_000.0
    return found


def logged(true: Mapping[str, FloatArray], faults: Faults, rng: np.random.Generator) -> Drive:
    """The log with noise, and struts whose sensors do not see friction."""
    seen = dict(true)
    for wheel in WHEELS:
        moving = np.gradient(true[f"suspension_deflection_{wheel}"]) * RATE_HZ
        name = f"suspension_force_{wheel}"
        seen[name] = true[name] - faults.friction * np.tanh(moving / 0.005)
    noise = {"suspension_f": faults.force, "accel_z_s": faults.corner, "accel": faults.accel}
    noise |= {"roll_rate": faults.gyro, "pitch_rate": faults.gyro, "yaw_rate": faults.gyro}
    for name, values in seen.items():
        std = next((s for start, s in noise.items() if name.startswith(start)), 0.0)
        seen[name] = values + std * rng.standard_normal(len(values))
    return as_drive(seen)


def as_drive(columns: Mapping[str, FloatArray]) -> Drive:
    """Columns at 100 Hz as a drive."""
    n = len(next(iter(columns.values())))
    time_ns = np.arange(n, dtype=np.int64) * round(1e9 / RATE_HZ)
    signals = {name: Signal(name, time_ns, values, "made") for name, values in columns.items()}
    return Drive(signals, ImportRecord("made", (), "", "complete", 0, {}, (), "clock", None, 0.0, ()))


def vehicle_file(body: Rigid) -> Vehicle:
    """Exact lengths; wheels without mass; roll and pitch axes where the arms put them."""
    exact = {
        "wheelbase_m": body.wheelbase, "track_front_m": body.track, "track_rear_m": body.track, "wheel_radius_m": 0.33,
        "unsprung_mass_front_kg": 0.001, "unsprung_mass_rear_kg": 0.001, "wheel_inertia_kgm2": 1e-6,
        "roll_center_height_front_m": body.height - body.roll_arm, "roll_center_height_rear_m": body.height - body.roll_arm,
        "pitch_center_height_m": body.height - body.pitch_arm, "mass_kg": body.mass,
    }  # fmt: skip
    places = {"imu_behind_front_axle_m": body.imu[0], "imu_left_m": 0.0, "imu_above_ground_m": body.imu[1]}
    return Vehicle(
        quantities={k: Quantity(v, 0.001 * abs(v), "exact") for k, v in exact.items()},
        sensors={k: Quantity(v, 0.005, "exact") for k, v in places.items()},
        reference=truth(body),
    )


def truth(body: Rigid) -> dict[str, float]:
    """By parameter name; with massless wheels the body is the vehicle."""
    return {
        "sprung_mass_kg": body.mass, "roll_inertia_kgm2": body.roll_inertia, "pitch_inertia_kgm2": body.pitch_inertia,
        "roll_arm_m": body.roll_arm, "pitch_arm_m": body.pitch_arm, "cg_lateral_offset_m": body.left,
        "cg_to_front_axle_m": body.behind,
    }  # fmt: skip
