"""The published observer and its companion on a run of the paper's car, and the bound that no estimator can beat."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.brake_roll.lateral import LateralData, LateralFit, LateralKnown, fit_lateral
from pipelines.estimators.brake_roll.least import Unknown, jacobian
from pipelines.estimators.brake_roll.slip import SlipData, SlipFit, SlipKnown, fit_slip
from pipelines.estimators.integrated_observer.core import Gates, Observed, ObserverInput, observe
from pipelines.filters.linear_response import linear_response
from pipelines.filters.roll_adaptation import AdaptationGains
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise
from pipelines.reproduce.park.plant import ParkCar, ParkRun
from pipelines.reproduce.park.sensors import FILTER_HZ, RATE_HZ, ParkSensors, sense
from pipelines.results import FloatArray

GAMMA, OBSERVER, ADAPTATION = 20.39, 12_000.0, 0.015
"""As printed."""

THIN = 2
"""The batch takes every second sample: 50 Hz for signals below 5 Hz."""

ONSET_ROWS = 40


def gains_of(car: ParkCar) -> AdaptationGains:
    """The printed gains with the car's roll data."""
    return AdaptationGains(
        car.roll_inertia, car.roll_stiffness, car.roll_damping, car.roll_centre, OBSERVER, ADAPTATION, GAMMA
    )


def published(
    data: ObserverInput,
    car: ParkCar,
    *,
    mass: float | None = None,
    brakes: bool = True,
    gains: AdaptationGains | None = None,
    reset: bool = True,
) -> Observed:
    """The observer from the roll centre's height, as the paper starts it. mass: told nominal mass, Table I's m0 else.

    brakes: False leaves the braking part out, as in the steering tests.
    """
    if not brakes:
        data = replace(data, front_torque=None, rear_torque=None)
    told = car.known(mass)
    return observe(
        data, told, gains_of(car) if gains is None else gains, Gates(), height_m=car.roll_centre, reset=reset
    )


@dataclass(frozen=True)
class Told:
    """What the companion knows, as standard deviations. The defaults are the paper's set-up: its vehicle data exact,
    its tyres alike and straight (3), the sensors' constant errors within what the offset estimator leaves."""

    front_m: float = 1e-6
    share_log: float = 1e-6
    bend: tuple[float, float] = (0.0, 1e-6)
    load: tuple[float, float] = (0.0, 1e-6)
    stiffness: float = 0.0
    mass: float = 0.0


def slip_known(car: ParkCar, sensors: ParkSensors, told: Told) -> SlipKnown:
    """The braking part's knowledge."""
    return SlipKnown(
        car.mass, (car.front_m, told.front_m), car.front_m + car.rear_m, car.wheel_radius, car.wheel_inertia,
        car.drag_area, told.share_log, offset=max(0.1 * sensors.offset_left, 1e-6), gain=1e-6,
        delay=max(sensors.speed_delay_s, 1e-6), bend=told.bend, load=told.load, squash=(0.0, 1e-6),
        radius=max(sensors.radius, 1e-6), drive_front=(1.0, 1e-3),
    )  # fmt: skip


def slip_data(data: ObserverInput, car: ParkCar, thin: int = THIN) -> SlipData:
    """The observer's columns as the braking fit takes them."""
    assert data.front_torque is not None
    assert data.rear_torque is not None
    total = data.front_torque + data.rear_torque
    pressed = total > 0.7 * car.nominal_kg * car.wheel_radius
    index = np.arange(len(total))
    held = index - np.maximum.accumulate(np.where(pressed, -1, index))
    braked = pressed & (held >= ONSET_ROWS)
    straight = np.abs(data.yaw_rate) < 0.05
    rows = straight & ((total <= 0.0) | braked) & data.allowed
    s = slice(None, None, thin)
    return SlipData(
        data.rate_hz / thin, FILTER_HZ, data.speed[s], data.f_x[s], data.front[s], data.rear[s],
        data.front_torque[s], data.rear_torque[s], None, rows[s], braked[s],
    )  # fmt: skip


def companion_braking(data: ObserverInput, car: ParkCar, sensors: ParkSensors, told: Told) -> SlipFit | None:
    """The braking part of the companion. car: as it is told (Table I), not as it is."""
    return fit_slip(slip_data(data, car), slip_known(car, sensors, told), 0.6)


def lateral_known(car: ParkCar, sensors: ParkSensors) -> LateralKnown:
    """The lateral part's knowledge: Table I, and sensors that have noise and offsets only."""
    lag, inertia = car.roll_damping / car.roll_stiffness, car.roll_inertia / car.roll_stiffness
    return LateralKnown(
        (lag, 0.02 * lag), (inertia, 0.02 * inertia), (car.rear_m, 0.05), scale=1e-6,
        yaw_offset=max(0.003 * sensors.offset_left, 1e-6), tilt=1e-6, leak=1e-6, delay=1e-6,
    )  # fmt: skip


def lateral_data(data: ObserverInput, thin: int = THIN) -> LateralData:
    """The observer's columns as the roll fit takes them."""
    assert data.roll_rate is not None
    s = slice(None, None, thin)
    rows = len(data.f_y[s])
    whole = (np.array([0]), np.array([rows]))
    return LateralData(
        data.rate_hz / thin, FILTER_HZ, data.f_y[s], data.roll_rate[s], data.yaw_rate[s], data.speed[s], data.f_x[s],
        None, np.ones(rows, dtype=bool), whole,
    )  # fmt: skip


def companion_roll(
    data: ObserverInput, car: ParkCar, sensors: ParkSensors, mass: float, told: Told
) -> tuple[float, float] | None:
    """CG height and its standard deviation from G = m h_lat / k_t, with the mass told."""
    fit: LateralFit | None = fit_lateral(lateral_data(data), lateral_known(car, sensors))
    if fit is None:
        return None
    arm = fit.gain * car.roll_stiffness / mass
    relative = math.hypot(fit.std / fit.gain, math.hypot(told.stiffness, told.mass / mass))
    return car.roll_centre + arm, arm * relative


def _information(columns: FloatArray, noise: FloatArray, unknowns: tuple[Unknown, ...]) -> FloatArray:
    """Fisher's information (k, k) of rows with known noise, with the priors' own."""
    weighted = columns / noise
    prior = [0.0 if not np.isfinite(u.std) else u.std**-2.0 for u in unknowns]
    return np.asarray(weighted @ weighted.T + np.diag(prior))


def _bound(information: FloatArray) -> float:
    """Standard deviation of the first parameter, scaled for its inversion."""
    scale = 1 / np.sqrt(np.diag(information))
    inverse = np.linalg.inv(information * np.outer(scale, scale))
    return float(np.sqrt(inverse[0, 0]) * scale[0])


SILENT = ParkSensors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Sensors without any error: where bounds are taken."""


def braking_bound(run: ParkRun, car: ParkCar, sensors: ParkSensors, rng: np.random.Generator) -> float:
    """Cramér-Rao bound of the height in m from all samples at 100 Hz of one braking run.

    Sensitivities by differences of the model on the noise-free run; noise of wheel speeds and speed as simulated;
    normal priors on the constant errors as these are drawn. Noise of f_x and pressure is taken as none.
    """
    clean = sense(run, car, SILENT, rng)
    captured: list[tuple[FloatArray, tuple[Unknown, ...]]] = []

    def keep(x: FloatArray, model_columns: FloatArray, unknowns: tuple[Unknown, ...]) -> None:
        captured.append((model_columns, unknowns))

    data = replace(slip_data(clean, car, 1), band_hz=RATE_HZ / 2)
    fit = fit_slip(data, slip_known(car, sensors, Told()), car.height, inspect=keep)
    if fit is None:
        return math.nan
    columns, unknowns = captured[-1]
    half = columns.shape[1] // 2
    both = math.sqrt(sensors.wheel**2 / 2 + sensors.speed**2)
    noise = np.concatenate((np.full(half, both), np.full(half, math.sqrt(2) * sensors.wheel)))
    return _bound(_information(columns, noise, unknowns))


def roll_bound(
    run: ParkRun, car: ParkCar, sensors: ParkSensors, mass: float, rng: np.random.Generator
) -> float:
    """Cramér-Rao bound of the height in m from roll rate and gravity in f_y at 100 Hz, offsets and v_y' unknown."""
    clean = sense(run, car, SILENT, rng)
    known = lateral_known(car, sensors)
    whole = (np.array([0]), np.array([len(clean.f_y)]))
    f, v, r = clean.f_y, clean.speed, clean.yaw_rate
    use = v > 1.5
    unknowns = (
        Unknown("gain", car.mass * car.arm / car.roll_stiffness, math.inf, 1e-6),
        Unknown("lag", known.lag_s[0], known.lag_s[1], 1e-5),
        Unknown("inertia", known.inertia_s2[0], known.inertia_s2[1], 1e-6),
        Unknown("rate_offset", 0.0, 0.02, 1e-5),
        Unknown("accel_offset", 0.0, 0.5, 1e-4),
        Unknown("rear_m", known.rear_m[0], known.rear_m[1], 1e-4),
        Unknown("compliance", known.compliance[0], known.compliance[1], 1e-6),
        Unknown("bend", known.bend[0], known.bend[1], 1e-8),
        Unknown("yaw_offset", 0.0, known.yaw_offset, 1e-6),
    )

    def model(x: FloatArray) -> FloatArray:
        phi, before, after = discretise(RollCoefficients(1.0, float(x[1]), float(x[2])), 1 / RATE_HZ)
        roll = linear_response(f, phi, before, after, 1.0, whole)
        slip = x[5] * np.gradient(r) - np.gradient(v * (x[6] * f + x[7] * f**3))
        gravity = GRAVITY * x[0] * roll[:, 0] + x[4] + RATE_HZ * slip - x[8] * v
        return np.concatenate(((x[0] * roll[:, 1] + x[3])[use], gravity[use]))

    start = np.array([u.start for u in unknowns])
    _, columns = jacobian(model, start, np.array([u.step for u in unknowns]))
    leaning = np.sqrt(sensors.acceleration**2 + (v * sensors.gyro) ** 2 + (r * sensors.speed) ** 2)[use]
    noise = np.concatenate((np.full(int(use.sum()), sensors.gyro), leaning))
    return _bound(_information(columns, noise, unknowns)) * car.roll_stiffness / mass
