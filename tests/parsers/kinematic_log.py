"""A log made of a speed, a yaw rate and a grade over time: what a vehicle on springs then feels, at 50 Hz."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from check_drives import DEFLECTIONS, NS, G

from parsers.channels import FloatArray
from parsers.drive import Signal

HZ = 50.0
SIDE = {"fl": -1.0, "fr": 1.0, "rl": -1.0, "rr": 1.0}
END = {"fl": 1.0, "fr": 1.0, "rl": -1.0, "rr": -1.0}


def times(seconds: float) -> FloatArray:
    return np.arange(round(seconds * HZ)) / HZ


def kinematic(
    speed: FloatArray, yaw: FloatArray, grade: FloatArray | float = 0.0, noise: float = 1.0
) -> dict[str, Signal]:
    """Signals of SI and ISO 8855 from a speed (n,), m/s, yaw rate (n,), rad/s, and grade (n,), rad, + uphill. noise: times the usual one."""
    rng = np.random.default_rng(3)
    grade = np.broadcast_to(np.asarray(grade, np.float64), speed.shape)
    pushed, across = np.gradient(speed) * HZ + G * grade, speed * yaw
    roll, nod = 0.006 * across, -0.003 * pushed
    made = {
        "speed": (speed, 0.02),
        "yaw_rate": (yaw, 0.003),
        "accel_x": (pushed - G * nod, 0.1),
        "accel_y": (across + G * roll, 0.1),
        "accel_z": (np.full(len(speed), G), 0.2),
        "roll_rate": (np.gradient(roll) * HZ, 0.004),
        "pitch_rate": (np.gradient(nod - grade) * HZ, 0.004),
        "roll": (roll, 0.001),
        "pitch": (nod - grade, 0.001),
    }
    for name in DEFLECTIONS:
        wheel = name[-2:]
        made[name] = 0.01 + 0.78 * SIDE[wheel] * roll + 1.35 * END[wheel] * nod, 0.0005
    stamps = (times(len(speed) / HZ) * NS).astype(np.int64)
    return {
        name: Signal(
            name, stamps, values + noise * sigma * rng.standard_normal(len(values)), name, group="bus"
        )
        for name, (values, sigma) in made.items()
    }


def rolling_hills(made_up: float, *, pedals: bool = True, steep: float = 1.0) -> dict[str, Signal]:
    """A motorway at 23 m/s for a quarter of an hour over grades up to 8 %, times steep. made_up: share of the grade that the pedal makes up for; pedals: one
    push and one brake besides."""
    t = times(900)
    waves = (
        np.sin(2 * np.pi * t / 55 + 1) + 0.6 * np.sin(2 * np.pi * t / 97) + 0.4 * np.sin(2 * np.pi * t / 31)
    )
    grade = 0.04 * steep * waves
    change = (made_up - 1) * G * grade
    if pedals:
        change += 0.8 * (np.exp(-(((t - 120) / 2.5) ** 2)) - np.exp(-(((t - 200) / 2.5) ** 2)))
    speed = np.cumsum(change) / HZ
    return kinematic(23 + speed - speed.mean(), 0.06 * np.sin(2 * np.pi * t / 30), grade)


def beside(signals: dict[str, Signal], name: str, values: FloatArray | float) -> dict[str, Signal]:
    """The signals with one more, on the stamps of accel_x."""
    like = signals["accel_x"]
    full = np.broadcast_to(np.asarray(values, np.float64), like.values.shape).copy()
    return signals | {name: replace(like, name=name, source=name, values=full)}
