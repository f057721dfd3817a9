"""A vehicle in one plane, written apart from cogest's relation: body on a roll axis, stiff tyres, forces from moments.

The body (m_s, own inertia I_s, CG at h_s) turns about an axis at height h_c; the wheels (m_u at h_u) do not lean. Roll comes from
I phi'' = m_s z f - K phi - D phi', tyre loads from the moments of every mass about the ground point in the middle.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665
RATE = 100.0


@dataclass(frozen=True)
class Plane:
    """SI. offset: of both masses, left of the middle."""

    sprung: float = 1600.0
    unsprung: float = 200.0
    high: float = 0.72
    hub: float = 0.33
    axis: float = 0.10
    inertia: float = 560.0
    stiffness: float = 82_000.0
    damping: float = 6_500.0
    track: float = 1.58
    offset: float = 0.012
    imu_high: float = 0.50
    front_share: float = 0.55

    @property
    def mass(self) -> float:
        return self.sprung + self.unsprung

    @property
    def height(self) -> float:
        return (self.sprung * self.high + self.unsprung * self.hub) / self.mass

    @property
    def arm(self) -> float:
        return self.high - self.axis

    @property
    def gradient_degpg(self) -> float:
        """Of roll against the sensed acceleration (gravity's part is in that)."""
        return float(np.degrees(self.sprung * G * self.arm / self.stiffness))

    def truth(self) -> dict[str, float]:
        above = self.high - self.height
        hubs = self.unsprung * ((self.track / 2) ** 2 + (self.height - self.hub) ** 2)
        return {
            "cg_height_m": self.height, "mass_kg": self.mass, "cg_lateral_offset_m": self.offset,
            "roll_gradient_degpg": self.gradient_degpg, "roll_inertia_kgm2": self.inertia + self.sprung * above**2 + hubs,
            "cg_to_front_axle_m": 1.2,
        }  # fmt: skip


def verdict(plane: Plane, share: float = 0.01, **changes: ParameterEstimate) -> dict[str, ParameterEstimate]:
    """The truth, each with this relative standard deviation (the offset: 4 mm)."""
    found = {}
    for name, value in plane.truth().items():
        std = 0.004 if name == "cg_lateral_offset_m" else share * value
        found[name] = ParameterEstimate(
            name, value, std, value - 1.96 * std, value + 1.96 * std, "identified", ""
        )
    return found | changes


def vehicle(plane: Plane, **more: float) -> Vehicle:
    """A vehicle file that knows the geometry."""
    known = {
        "track_front_m": plane.track, "track_rear_m": plane.track, "wheelbase_m": 2.7, "unsprung_mass_front_kg": plane.unsprung / 2,
        "unsprung_mass_rear_kg": plane.unsprung / 2, "roll_center_height_front_m": plane.axis, "roll_center_height_rear_m": plane.axis,
        "wheel_radius_m": plane.hub, "wheel_inertia_kgm2": 1e-6, "spring_rate_front_npm": 1e7, "spring_rate_rear_npm": 1e7,
        "tire_vertical_rate_npm": 1e9, "tire_lateral_rate_npm": 1e9,
    }  # fmt: skip
    quantities = {k: Quantity(v, 1e-3 * v, "vehicle file") for k, v in (known | more).items()}
    sensors = {
        "imu_behind_front_axle_m": Quantity(1.2, 0.001, "vehicle file"), "imu_left_m": Quantity(0.0, 0.001, "vehicle file"),
        "imu_above_ground_m": Quantity(plane.imu_high, 0.001, "vehicle file"),
    }  # fmt: skip
    return Vehicle(quantities=quantities, sensors=sensors)


def slalom(peak_g: float, seconds: float = 24.0, hertz: float = 0.5, still_s: float = 4.0) -> FloatArray:
    """Lateral acceleration of the roll axis in m/s²: rest, a sine that swells and dies, rest."""
    time = np.arange(round(seconds * RATE)) / RATE
    window = np.clip((time - still_s) / 3, 0, 1) * np.clip((seconds - still_s - time) / 3, 0, 1)
    return np.asarray(peak_g * G * window**2 * np.sin(2 * np.pi * hertz * (time - still_s)))


def turn(left_g: float, right_g: float) -> FloatArray:
    """Two long turns, the first to the left."""
    time = np.arange(round(30 * RATE)) / RATE
    first = np.clip((time - 5) / 1.5, 0, 1) * np.clip((12 - time) / 1.5, 0, 1)
    second = np.clip((time - 16) / 1.5, 0, 1) * np.clip((23 - time) / 1.5, 0, 1)
    smooth = [0.5 - 0.5 * np.cos(np.pi * part) for part in (first, second)]
    return np.asarray(G * (left_g * smooth[0] - right_g * smooth[1]))


@dataclass(frozen=True)
class Ride:
    """True motion, (n,) each. coefficient: (F_l - F_r) / sum. force: wheel -> N, never below 0."""

    time_s: FloatArray
    lateral: FloatArray
    roll: FloatArray
    rate: FloatArray
    accel_y: FloatArray
    accel_z: FloatArray
    coefficient: FloatArray
    force: dict[str, FloatArray]


def ride(plane: Plane, lateral: FloatArray, bank: FloatArray | None = None) -> Ride:
    """lateral: of the roll axis along the road, without gravity's part on a bank; bank: + left side higher."""
    slope = np.zeros(len(lateral)) if bank is None else bank
    across, normal = lateral + G * np.sin(slope), G * np.cos(slope)
    moment = plane.inertia + plane.sprung * plane.arm**2
    roll, rate, turned = np.zeros(len(lateral)), np.zeros(len(lateral)), np.zeros(len(lateral))
    step, fine = 1 / RATE, 20
    p = q = 0.0
    for i in range(len(lateral)):
        pull = plane.sprung * plane.arm
        for _ in range(fine):
            # the body turns with the road under it: the bank's own acceleration is small and left out
            acting = (
                pull * (across[i] * np.cos(p) + normal[i] * np.sin(p))
                - plane.stiffness * p
                - plane.damping * q
            ) / moment
            q += step / fine * acting
            p += step / fine * q
        roll[i], rate[i], turned[i] = p, q, acting
    y_body = plane.offset - plane.arm * np.sin(roll)
    z_body = plane.axis + plane.arm * np.cos(roll)
    across_body = across - plane.arm * turned
    about = (
        plane.sprung * (y_body * normal - z_body * across_body) + plane.unsprung * (plane.offset * normal - plane.hub * across)
        + plane.inertia * turned
    )  # fmt: skip
    coefficient = about / (plane.mass * normal * plane.track / 2)
    share = np.clip(coefficient, -1, 1)
    force = {}
    for wheel in ("fl", "fr", "rl", "rr"):
        part = plane.front_share if wheel.startswith("f") else 1 - plane.front_share
        side = 1.0 if wheel.endswith("l") else -1.0
        force[wheel] = 0.5 * plane.mass * normal * part * (1 + side * share)
    unit = plane.imu_high - plane.axis
    point = across - unit * turned
    return Ride(
        np.arange(len(lateral)) / RATE, across / normal, roll, rate, point * np.cos(roll) + normal * np.sin(roll),
        normal * np.cos(roll) - point * np.sin(roll), coefficient, force,
    )  # fmt: skip


def record(duration_s: float) -> ImportRecord:
    return ImportRecord("test", (Path("log"),), "0" * 64, "complete", 0, {}, (), "test", None, duration_s, ())


def drive(signals: dict[str, FloatArray], rate: float = RATE) -> Drive:
    """Signals at one rate, all from one start."""
    made = {}
    for name, values in signals.items():
        stamps = np.asarray(np.round(np.arange(len(values)) * 1e9 / rate), dtype=np.int64)
        there = np.isfinite(values)
        made[name] = Signal(name, stamps[there], values[there], "test", True)
    return Drive(made, record(len(next(iter(signals.values()))) / rate))


def log_of(
    found: Ride,
    *,
    noise: float = 0.0,
    forces: bool = True,
    roll: bool = True,
    bank: FloatArray | None = None,
    seed: int = 1,
) -> Drive:
    """What sensors give: a navigation unit, at rest from time to time, and measuring wheels."""
    rng = np.random.default_rng(seed)
    moving = (found.time_s > 3.0) & (found.time_s < found.time_s[-1] - 3.0)
    slope = np.zeros(len(found.roll)) if bank is None else bank
    signals = {
        "accel_y": found.accel_y + noise * 0.05 * rng.standard_normal(len(found.roll)),
        "accel_z": found.accel_z + noise * 0.05 * rng.standard_normal(len(found.roll)),
        "roll_rate": found.rate + np.gradient(slope) * RATE,
        "yaw_rate": np.zeros(len(found.roll)), "speed": np.where(moving, 15.0, 0.0),
    }  # fmt: skip
    if roll:
        signals["roll"] = found.roll + slope
    if forces:
        for wheel, values in found.force.items():
            signals[f"tire_normal_force_{wheel}"] = values + noise * 40 * rng.standard_normal(len(values))
    return drive(signals)
