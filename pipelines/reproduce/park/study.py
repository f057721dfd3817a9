"""RMSE, coverage and ratio to the bound over many noise seeds, on the paper's set-up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipelines.estimators.integrated_observer.core import ObserverInput
from pipelines.estimators.integrated_observer.spread import MODEL_ERROR
from pipelines.reproduce.base import StudyRow, study_row
from pipelines.reproduce.park.drives import braking, circle, slalom
from pipelines.reproduce.park.methods import (
    SILENT,
    Told,
    braking_bound,
    companion_braking,
    companion_roll,
    published,
    roll_bound,
)
from pipelines.reproduce.park.plant import ParkCar, ParkRun, drive_park
from pipelines.reproduce.park.sensors import ParkSensors, sense
from pipelines.results import FloatArray

STUDY_SENSORS = ParkSensors(radius=0.003, speed_delay_s=0.003)
"""Rolling radii of the axles off by 0.3 % and the speed by 3 ms, drawn anew for each run, beside noise and offsets."""

Step = Callable[[], None]


def _intervals(values: FloatArray, stds: FloatArray) -> FloatArray:
    return np.stack([values - 1.96 * stds, values + 1.96 * stds], axis=1)


def published_spread(run: ParkRun, car: ParkCar, is_roll: bool, rng: np.random.Generator) -> float:
    """What the drawn constant errors and the model's 5 % can do to the published height, in m.

    The observer is run on the noise-free drive with each error moved by its standard deviation to both sides; its own
    covariance knows nothing of them.
    """
    clean = sense(run, car, SILENT, rng)
    s = STUDY_SENSORS
    left = s.offset_left

    def ended(data: ObserverInput) -> float:
        if is_roll:
            return float(published(data, car, mass=car.mass, brakes=False).height[-1])
        brake = published(data, car).brake
        return float("nan") if brake is None else float(brake.height[-1])

    def moved(sign: float) -> list[ObserverInput]:
        found = [replace(clean, f_y=clean.f_y + sign * 0.07 * left)]
        if clean.roll_rate is not None:
            found.append(replace(clean, roll_rate=clean.roll_rate + sign * 0.004 * left))
        return [
            *found,
            replace(clean, yaw_rate=clean.yaw_rate + sign * 0.003 * left),
            replace(clean, f_x=clean.f_x + sign * 0.1 * left),
            replace(clean, front=clean.front * (1 + sign * s.radius)),
            replace(clean, rear=clean.rear * (1 + sign * s.radius)),
            replace(clean, speed=clean.speed - sign * s.speed_delay_s * clean.f_x),
        ]

    base = ended(clean)
    ends = [
        max(abs(ended(a) - base), abs(ended(b) - base)) for a, b in zip(moved(1.0), moved(-1.0), strict=True)
    ]
    return float(np.sqrt(np.nansum(np.square(ends)) + (MODEL_ERROR * car.height) ** 2))


def _rows(
    setup: str, run: ParkRun, car: ParkCar, runs: int, bound: float, target: float | None, is_roll: bool,
    rng: np.random.Generator,
) -> tuple[StudyRow, StudyRow]:  # fmt: skip
    """The published method and the companion on the same noise. car: as it is, of which both are told all but h."""
    truth = car.height
    heights, stds, theirs = (np.full(runs, np.nan) for _ in range(3))
    for i in range(runs):
        data = sense(run, car, STUDY_SENSORS, rng)
        if is_roll:
            found = companion_roll(data, car, STUDY_SENSORS, car.mass, Told())
            observed = published(data, car, mass=car.mass, brakes=False)
            theirs[i] = observed.height[-1]
            if found is not None:
                heights[i], stds[i] = found
        else:
            fit = companion_braking(data, car, STUDY_SENSORS, Told())
            observed = published(data, car)
            theirs[i] = np.nan if observed.brake is None else observed.brake.height[-1]
            if fit is not None:
                heights[i], stds[i] = fit.height, fit.std
    allowance = np.full(runs, published_spread(run, car, is_roll, rng))
    remark = "interval: 5 % for the model, and what the drawn constant errors do to a noise-free run"
    if is_roll:
        remark += "; told the true mass"
    return (
        study_row(
            setup, "integrated_observer", "cg_height_m", "mm", 1e3 * truth, 1e3 * theirs,
            1e3 * _intervals(theirs, allowance), 1e3 * bound, None, remark,
        ),
        study_row(
            setup, "brake_roll_batch", "cg_height_m", "mm", 1e3 * truth, 1e3 * heights,
            1e3 * _intervals(heights, stds), 1e3 * bound, target,
        ),
    )  # fmt: skip


def study(runs: int, rng: np.random.Generator, step: Step) -> tuple[StudyRow, ...]:
    """Asphalt and basalt stops, circle, slalom."""
    car = ParkCar()
    found: list[StudyRow] = []
    for name, here, demand, target in (
        ("asphalt stop, 80 km/h, 0.6 g", car, braking(car, 80, 0.6), 1.1),
        ("basalt stop, 50 km/h, 0.25 g", replace(car, slip_stiffness=9.5), braking(car, 50, 0.25), None),
    ):
        run = drive_park(here, demand)
        bound = braking_bound(run, here, STUDY_SENSORS, rng)
        found += _rows(name, run, here, runs, bound, target, False, rng)
        step()
    for name, demand, target in (
        ("circle of 35 m, 0 to 50 km/h", circle(), None),
        ("slalom at 0.45 g, U-turns", slalom(), 1.4),
    ):
        run = drive_park(car, demand)
        bound = roll_bound(run, car, STUDY_SENSORS, car.mass, rng)
        found += _rows(name, run, car, runs, bound, target, True, rng)
        step()
    return tuple(found)
