"""Bump stops of which the vehicle file is silent, found by strut forces beside deflections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from pipelines.analyze import run_estimator
from pipelines.estimators.roll_map.estimator import RollMap
from pipelines.estimators.roll_map.touched_stops import stop_by_force, stops_touched
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

HZ = 32.0
ROWS = np.arange(6000)


def _prepared(stop_npm: float, *, cube: float = 0.0) -> Prepared:
    """A wheel that goes some 70 mm deep, its stop at 50 mm. cube: of its spring's force, N/m³."""
    rng = np.random.default_rng(2)
    t = ROWS / HZ
    left = (
        0.02 + 0.035 * np.sin(0.9 * t) * np.sin(0.05 * t) + 0.008 * np.sin(7.0 * t) + 0.012 * np.sin(2.1 * t)
    )
    right = 0.02 - 0.03 * np.sin(0.9 * t) * np.sin(0.05 * t)
    speed = np.gradient(left) * HZ
    force = (
        3000
        + 22e3 * left
        + cube * left**3
        + 9e3 * (left - right)
        + 1500 * speed
        + stop_npm * np.maximum(left - 0.05, 0)
    )
    force = force + 60.0 * np.sign(speed) + 15.0 * rng.standard_normal(len(t))
    columns: dict[str, FloatArray] = {
        "suspension_deflection_fl": left, "suspension_deflection_fr": right, "suspension_force_fl": force,
    }  # fmt: skip
    return Prepared(
        HZ, 8.0, t, columns, (Segment(0, len(t)),), {}, frozenset(columns), np.zeros(len(t), dtype=bool)
    )


def test_a_stop_is_found_where_it_is_and_its_rows_are_counted() -> None:
    prepared = _prepared(80e3)
    stop = stop_by_force(prepared, ROWS, "fl")
    assert stop is not None
    assert stop == pytest.approx(0.05, abs=0.004)
    beyond = float(np.mean(prepared.columns["suspension_deflection_fl"] > 0.05))
    assert stops_touched(prepared, ROWS, Vehicle()) == pytest.approx(beyond, abs=0.03)


def test_springs_that_stiffen_are_no_stops() -> None:
    assert stop_by_force(_prepared(0.0), ROWS, "fl") is None
    # a fifth stiffer 50 mm up, and as much as that again
    for cube in (6e5, 1.2e6):
        assert stop_by_force(_prepared(0.0, cube=cube), ROWS, "fl") is None
    assert stop_by_force(_prepared(80e3), ROWS, "fr") is None


def _gradient(car: Car) -> ParameterEstimate:
    rng = np.random.default_rng(3)
    drive = logged(simulate(car, demand(240.0, rng), rng, rough_m=0.002), rng)
    estimator = RollMap()
    settings = {setting.name: setting.default for setting in estimator.settings}
    return run_estimator(estimator, drive, vehicle_file(car, None), settings, 1).parameters[
        "roll_gradient_degpg"
    ]


def test_a_gradient_that_unstated_stops_held_is_not_identified() -> None:
    car = Car(load=250.0, load_at=(0.9, 0.0, 0.8), friction=20.0, stop_rate=4e6)
    free = _gradient(car)
    held = _gradient(replace(car, stop_at=0.03))
    assert free.status == "identified"
    assert held.status != "identified"
    assert "bump stops may have been touched" in held.reason
