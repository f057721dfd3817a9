"""What the paper's sensors read of a run: noise, offsets as printed, wheel speeds with radius errors, filtered speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.estimators.integrated_observer.core import ObserverInput
from pipelines.prepare.lowpass import lowpass
from pipelines.reproduce.park.plant import ParkCar, ParkRun
from pipelines.results import FloatArray

RATE_HZ = 100.0
REST_PA = 5.0e4
"""Pressure below which the foot is off: the filter rings about a stop's ends."""

FILTER_HZ = 5.0
"""All signals pass the same filter: the paper names 5 Hz as what the noise allows."""


@dataclass(frozen=True)
class ParkSensors:
    """Standard deviations of white noise at 100 Hz, SI, and what remains of the constant errors.

    offset_left: share of the printed offsets (-0.1, -0.07 m/s², 0.003, 0.004 rad/s) that the offset estimator leaves,
    drawn; 1 = uncompensated, as printed. radius: relative error of an axle's rolling radius, drawn. speed_delay_s:
    what is left of the delay of the satellite speed after its observer, drawn.
    """

    speed: float = 0.02
    wheel: float = 0.02
    acceleration: float = 0.05
    gyro: float = 0.003
    pressure: float = 2.0e4
    offset_left: float = 0.1
    radius: float = 0.0
    speed_delay_s: float = 0.0


PRINTED_OFFSETS = (-0.1, -0.07, 0.003, 0.004)
"""Of a_x, a_y in m/s², yaw rate and roll rate in rad/s."""


def _offsets(sensors: ParkSensors, rng: np.random.Generator) -> FloatArray:
    printed = np.array(PRINTED_OFFSETS)
    if sensors.offset_left >= 1.0:
        return printed
    return np.asarray(sensors.offset_left * np.abs(printed) * rng.standard_normal(4))


def sense(run: ParkRun, car: ParkCar, sensors: ParkSensors, rng: np.random.Generator) -> ObserverInput:
    """A run as the observer gets it. `car` gives the brake gains that the observer is told."""
    rows = len(run.time)
    offsets = _offsets(sensors, rng)

    def noisy(values: FloatArray, std: float) -> FloatArray:
        return lowpass(values + std * rng.standard_normal(rows), RATE_HZ, FILTER_HZ)

    late = sensors.speed_delay_s * float(rng.standard_normal())
    radius = 1 + sensors.radius * rng.standard_normal(2)
    speed = np.interp(run.time - late, run.time, run.v)
    pressure = np.maximum(noisy(run.pressure, sensors.pressure), 0.0)
    torque = car.brake_gain * np.where(pressure > max(4 * sensors.pressure, REST_PA), pressure, 0.0)
    return ObserverInput(
        rate_hz=RATE_HZ,
        speed=noisy(speed, sensors.speed),
        f_x=noisy(run.f_x + offsets[0], sensors.acceleration),
        f_y=noisy(run.f_y + offsets[1], sensors.acceleration),
        roll_rate=noisy(run.roll_rate + offsets[3], sensors.gyro),
        yaw_rate=noisy(run.yaw_rate + offsets[2], sensors.gyro),
        front=noisy(run.front * radius[0], sensors.wheel),
        rear=noisy(run.rear * radius[1], sensors.wheel),
        apart=np.zeros(rows),
        front_torque=car.brake_front * torque,
        rear_torque=(1 - car.brake_front) * torque,
        steering=np.asarray(run.curvature * car.known().wheelbase_m * 15.0),
        allowed=np.abs(run.grade) < 0.03,
        segments=(np.array([0]), np.array([rows])),
    )
