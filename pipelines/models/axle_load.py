"""Axle loads in straight driving (Wu et al., equations (1)-(6)), and how well CG height and position can be known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.filters.whiten import whiten
from pipelines.results import FloatArray

GRAVITY = 9.80665
GRAVITY_SHARE = 0.001
"""Standard deviation of gravity over that: 9.78 m/s² at the equator, 9.83 at the poles. A mass that is weighed is no surer."""

BLOCK_S = 5.0
"""Stretches whose means err independently."""


def mean_error(values: FloatArray, rate_hz: float) -> float:
    """Standard deviation of the mean of (n,) values by the scatter of stretches; that of the values where there are not two."""
    blocks = int(len(values) / (BLOCK_S * rate_hz))
    if blocks < 2:
        return float(np.std(values))
    means = np.array([np.mean(part) for part in np.array_split(values, blocks)])
    return float(np.std(means, ddof=1) / math.sqrt(blocks))


def axle_loads(
    mass: float,
    wheelbase: float,
    axle: float,
    height: float,
    acceleration: FloatArray,
    grade: FloatArray,
    rolling_arm: float,
) -> tuple[FloatArray, FloatArray]:
    """Front and rear axle load in N, (1) and (2). axle: CG behind the front axle, m. rolling_arm: r f in m.

    acceleration (n,) m/s² along the road, grade (n,) rad + uphill.
    """
    weight = mass * GRAVITY
    transfer = weight * height * np.sin(grade) + mass * acceleration * height
    transfer = transfer + weight * rolling_arm * np.cos(grade)
    front = (weight * (wheelbase - axle) * np.cos(grade) - transfer) / wheelbase
    rear = (weight * axle * np.cos(grade) + transfer) / wheelbase
    return front, rear


def acceleration_from_load(
    load: FloatArray, grade: FloatArray, mass: float, wheelbase: float, rolling_arm: float, height: float, axle: float
) -> FloatArray:  # fmt: skip
    """dv/dt from the rear axle load, (3) and (6); (n,) in m/s²."""
    return acceleration_jacobian(load, grade, mass, wheelbase, rolling_arm, height, axle)[0]


def acceleration_jacobian(
    load: FloatArray, grade: FloatArray, mass: float, wheelbase: float, rolling_arm: float, height: float, axle: float
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """dv/dt of (6) and its derivatives by height and axle distance: -N / (m h²) and -g cos / h."""
    moment = load * wheelbase - mass * GRAVITY * (axle + rolling_arm) * np.cos(grade)
    slope = moment / (mass * height)
    return (
        np.asarray(slope - GRAVITY * np.sin(grade)),
        np.asarray(-slope / height),
        np.asarray(-GRAVITY * np.cos(grade) / height),
    )


@dataclass(frozen=True)
class Noise:
    """Standard deviations of one sample: speed in m/s (white), load in N (white)."""

    speed: float
    load: float


def bound(
    load: FloatArray,
    grade: FloatArray,
    dt: float,
    mass: float,
    wheelbase: float,
    rolling_arm: float,
    height: float,
    axle: float,
    noise: Noise,
) -> tuple[float, float]:
    """Cramér-Rao bound of the standard deviations of height and axle distance in m, from speed and rear load.

    Numerical: sensitivities of the speed by (14), with the load's noise as a random walk of the speed and the starting
    speed unknown. load, grade (n,): without noise, at the true parameters; mass, grade and r f exactly known.
    """
    _, by_height, by_axle = acceleration_jacobian(load, grade, mass, wheelbase, rolling_arm, height, axle)
    columns = np.zeros((len(load), 2))
    columns[1:, 0] = np.cumsum(by_height[:-1]) * dt
    columns[1:, 1] = np.cumsum(by_axle[:-1]) * dt
    starts = np.zeros(len(load))
    starts[0] = 1.0
    walk = (wheelbase * dt * noise.load / (mass * height)) ** 2
    white, _ = whiten(columns, starts, 1.0, walk, np.full(len(load), noise.speed**2))
    covariance = np.linalg.inv(white.T @ white)
    return math.sqrt(covariance[0, 0]), math.sqrt(covariance[1, 1])


USUAL_SQUASH_M = 0.018
"""How far a tyre is pressed in at rest, where its rate is not known."""


def patch_shift(mass_kg: float | None, tire_rate_npm: float | None) -> tuple[float, float]:
    """What tyre loads show beside the CG height in m, mean and standard deviation.

    Torque becomes force on the rolling radius, but the axle stands lower: by up to two thirds of the tyre's deflection. Where no
    power comes from nowhere, a braked tyre's patch lags behind its axle by that share of force over load, which reads as
    height. How much of it a tyre shows is not known: half of it, give or take.
    """
    squash = USUAL_SQUASH_M
    if mass_kg is not None and tire_rate_npm is not None:
        squash = min(mass_kg * GRAVITY / (4 * tire_rate_npm), 0.05)
    return squash / 3, squash / 3
