"""A lorry on a straight road as a log: for the estimators from axle loads. Steps of 0.01 s, written as signals."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665


@dataclass(frozen=True)
class Lorry:
    """Truth. gain: g times pitch per force; the body's pitch moves the CG and tilts the accelerometer."""

    mass: float = 5762.0
    height: float = 1.03
    axle: float = 1.5
    wheelbase: float = 5.0
    rolling: float = 0.004
    spin: float = 110.0
    gain: float = 0.015


@dataclass(frozen=True)
class Sensors:
    """Sizes of errors. rate: of the axle loads in Hz. outliers: share of wild samples in loads and speed."""

    speed: float = 0.05
    load: float = 100.0
    accel: float = 0.1
    accel_offset: float = 0.0
    load_scale: float = 1.0
    load_offset: float = 0.0
    grade: float = 0.002
    rate: float = 50.0
    outliers: float = 0.0
    delay: float = 0.0


@dataclass(frozen=True)
class Motion:
    """time (n,), acceleration, grade, speed."""

    time: FloatArray
    acceleration: FloatArray
    grade: FloatArray
    speed: FloatArray
    extra: dict[str, float] = field(default_factory=dict)


def motion(seconds: float = 90.0, size: float = 1.3, hill: float = 0.03) -> Motion:
    """Accelerating and braking around 12 m/s over gentle hills."""
    t = np.arange(round(seconds * 100)) * 0.01
    acceleration = size * (np.sin(0.5 * t) + 0.4 * np.sin(1.3 * t + 1))
    speed = 14 + np.concatenate(([0.0], np.cumsum(0.5 * (acceleration[1:] + acceleration[:-1])) * 0.01))
    return Motion(t, acceleration, hill * np.sin(0.05 * t), speed)


def loads(lorry: Lorry, m: Motion) -> tuple[FloatArray, FloatArray]:
    """Front and rear axle load."""
    force = m.acceleration + G * np.sin(m.grade)
    bend = np.gradient(m.grade) * 100 * m.speed
    down = G * np.cos(m.grade) + bend
    moment = lorry.mass * (lorry.height * (1 + lorry.gain) * force + lorry.axle * down + lorry.rolling * G)
    moment = moment + lorry.spin * m.acceleration
    rear = moment / lorry.wheelbase
    return lorry.mass * down - rear, rear


def record(lorry: Lorry, m: Motion, sensors: Sensors, names: tuple[str, ...], seed: int = 0) -> Drive:
    """The named signals of a drive, each on its own clock."""
    rng = np.random.default_rng(seed)
    front, rear = loads(lorry, m)
    force = m.acceleration + G * np.sin(m.grade)
    truth = {
        "speed": (m.speed, 50.0, sensors.speed, 0.0, 1.0),
        "road_grade": (m.grade, 20.0, sensors.grade, 0.0, 1.0),
        "accel_x": (force * (1 + lorry.gain), 100.0, sensors.accel, sensors.accel_offset, 1.0),
        "axle_load_front": (front, sensors.rate, sensors.load, sensors.load_offset, sensors.load_scale),
        "axle_load_rear": (rear, sensors.rate, sensors.load, sensors.load_offset, sensors.load_scale),
        "tire_normal_force_rl": (rear / 2, sensors.rate, sensors.load, 0.0, 1.0),
        "tire_normal_force_rr": (rear / 2, sensors.rate, sensors.load, 0.0, 1.0),
        "suspension_force_rl": (rear / 2 - 150 * G, sensors.rate, sensors.load, 0.0, 1.0),
        "suspension_force_rr": (rear / 2 - 150 * G, sensors.rate, sensors.load, 0.0, 1.0),
        "altitude": (np.cumsum(m.speed * np.sin(m.grade)) * 0.01, 10.0, 0.1, 0.0, 1.0),
    }
    signals = {}
    for name in names:
        values, rate, noise, offset, scale = truth[name]
        at = np.arange(m.time[0], m.time[-1], 1 / rate)
        late = sensors.delay if name == "speed" else 0.0
        seen = scale * np.interp(at - late, m.time, values) + offset + noise * rng.standard_normal(len(at))
        if sensors.outliers:
            wild = rng.random(len(at)) < sensors.outliers
            seen = seen + np.where(wild, 30 * noise * rng.standard_normal(len(at)), 0.0)
        signals[name] = Signal(name, (at * 1e9).astype(np.int64), np.asarray(seen), name)
    record_ = ImportRecord("csv", (Path("log"),), "", "complete", 0, {}, (), "t", None, float(m.time[-1]), ())
    return Drive(signals, record_)


def vehicle(
    lorry: Lorry, *, load: float | None = 0.0, mass: float | None = None, **changes: float
) -> Vehicle:
    """A vehicle file: figures to 1 %, the load told (kg) or not (None), axle loads by what the tyres carry."""
    values = {
        "mass_kg": lorry.mass if mass is None else mass, "wheelbase_m": lorry.wheelbase, "wheel_radius_m": 0.52,
        "wheel_inertia_kgm2": lorry.spin * 0.52 / 4, "rolling_resistance": 0.0077, "drag_area_m2": 0.001,
    }  # fmt: skip
    values |= changes
    quantities = {k: Quantity(v, 0.01 * v, "vehicle file") for k, v in values.items() if v > 0}
    reference = {"cg_height_m": lorry.height, "cg_to_front_axle_m": lorry.axle, "mass_kg": lorry.mass}
    told = {} if load is None else {"mass_kg": Quantity(load, 10.0, "vehicle file")}
    return Vehicle(name="lorry", quantities=quantities, load=told, reference=reference, axle_load_by="tires")
