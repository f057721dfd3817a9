"""The paper's bench: one terrain, cars, noise, and both methods run on what the accelerometers read."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.base_excitation.batch_corner import Corner, CornerFit, Nuisance, fit_corner
from pipelines.filters.least_squares import recursive_least_squares
from pipelines.filters.second_order import second_order_filters
from pipelines.results import FloatArray
from pipelines.simulation.quarter_car import (
    QuarterCar,
    QuarterRun,
    Terrain,
    drive_quarter_car,
    off_road_terrain,
    scaled_terrain,
)

DURATION_S = 200.0
SPEED_MPS = 8.0
NOISE_MPS2 = 0.37
NOISE_DB = 25.0
"""Table II: the standard deviation of the noise, and the signal-to-noise ratio that it is said to be."""

HUB_RMS_MPS2 = NOISE_MPS2 * 10 ** (NOISE_DB / 20)
NATURAL_RADPS, DAMPING_RATIO = 6.0, 0.1
INITIAL_COVARIANCE = 1000.0
LINEAR_NSPM = 7000.0
SPEEDS = (2.0, 4.0, 8.0, 12.0, 16.0)
EXACT_SENSORS = Nuisance(0.0, 0.0, 0.0)
"""Accelerometers as the paper has them: alike, at one instant; no friction."""


@dataclass(frozen=True)
class Bench:
    """The terrain, the car of Table I with both damper slopes, and the runs that several tables need."""

    terrain: Terrain
    car: QuarterCar
    linear: QuarterRun
    nominal: QuarterRun
    by_speed: tuple[QuarterRun, ...]


@dataclass(frozen=True)
class Published:
    """The published method on one run: mass and damping at the end, and every second on the way (t, 2)."""

    mass_kg: float
    damping_nspm: float
    track: FloatArray


def bench(rng: np.random.Generator) -> Bench:
    """Make the terrain from `rng` and drive all runs without noise."""
    car = QuarterCar()
    raw = off_road_terrain(max(SPEEDS) * DURATION_S + 20, rng)
    terrain = scaled_terrain(raw, car, SPEED_MPS, DURATION_S, HUB_RMS_MPS2)
    linear = replace(car, extension_nspm=LINEAR_NSPM, compression_nspm=LINEAR_NSPM)
    runs = tuple(drive_quarter_car(car, terrain, speed, DURATION_S) for speed in SPEEDS)
    return Bench(
        terrain,
        car,
        drive_quarter_car(linear, terrain, SPEED_MPS, DURATION_S),
        runs[SPEEDS.index(SPEED_MPS)],
        runs,
    )


def off_ground_of_terrains(speeds: tuple[float, ...], draws: int) -> FloatArray:
    """(draws, speeds) share of the time in % that the tyre is off the ground, on other terrains of the same spectrum and size."""
    car, found = QuarterCar(), []
    for draw in range(draws):
        raw = off_road_terrain(max(speeds) * DURATION_S + 20, np.random.default_rng([16, draw]))
        terrain = scaled_terrain(raw, car, SPEED_MPS, DURATION_S, HUB_RMS_MPS2)
        found.append([100 * drive_quarter_car(car, terrain, v, DURATION_S).off_ground for v in speeds])
    return np.array(found)


def at_ratio(run: QuarterRun, decibel: float) -> float:
    """The noise's standard deviation for a signal-to-noise ratio of the hub's acceleration."""
    return float(np.std(run.accel_unsprung)) / 10 ** (decibel / 20)


def noisy(run: QuarterRun, noise_mps2: float, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """What the body's and the hub's accelerometers read, with white noise."""
    n = len(run.accel_sprung)
    body = run.accel_sprung + noise_mps2 * rng.standard_normal(n)
    return np.asarray(body), np.asarray(run.accel_unsprung + noise_mps2 * rng.standard_normal(n))


def published(
    body: FloatArray,
    hub: FloatArray,
    run: QuarterRun,
    natural_radps: float = NATURAL_RADPS,
    damping_ratio: float = DAMPING_RATIO,
) -> Published:
    """Equations (3)-(7) as the paper sets them: from rest, with no mean taken out."""
    of_body = second_order_filters(body, run.step_s, natural_radps, damping_ratio)
    apart = second_order_filters(body - hub, run.step_s, natural_radps, damping_ratio)
    phi = np.column_stack((of_body[:, 2], apart[:, 1]))
    track, theta, _ = recursive_least_squares(
        phi,
        -run.car.spring_npm * apart[:, 0],
        np.zeros(2),
        INITIAL_COVARIANCE * np.eye(2),
        every=round(1 / run.step_s),
    )
    return Published(float(theta[0]), float(theta[1]), track)


def companion(
    body: FloatArray, hub: FloatArray, run: QuarterRun, nuisance: Nuisance = EXACT_SENSORS
) -> CornerFit:
    """The batch fit of the same readings."""
    corner = Corner(body, hub, [(0, len(body))], 1 / run.step_s, run.car.spring_npm)
    fit = fit_corner(corner, nuisance)
    assert fit is not None, "200 s hold twenty blocks"
    return fit
