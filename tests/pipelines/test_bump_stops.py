"""Bump stops that braking touches: an unknown of the balances by deflections, where wheels go deep enough."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from parsers.drive import Drive, Signal
from pipelines.analyze import run_estimator
from pipelines.estimators.load_balance.data import STOPS_M, collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.joint.vehicle import suspension
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Quantity

CAR = Car(load=250.0, load_at=(0.9, 0.0, 0.8), friction=20.0, stop_rate=4e6)


def drive_of(car: Car) -> Drive:
    rng = np.random.default_rng(3)
    return logged(simulate(car, demand(240.0, rng), rng, rough_m=0.002), rng, "suspension_force")


def height(car: Car, drive: Drive) -> ParameterEstimate:
    estimator = LoadBalance()
    settings = {setting.name: setting.default for setting in estimator.settings}
    return run_estimator(estimator, drive, vehicle_file(car, None), settings, 1).parameters["cg_height_m"]


def wrong(found: ParameterEstimate, car: Car) -> tuple[float, float]:
    """Relative error, and in standard deviations."""
    assert found.value is not None
    assert found.std is not None
    off = found.value - car.truth()["cg_height_m"]
    return off / car.truth()["cg_height_m"], off / found.std


def test_stops_that_braking_touches_do_not_lower_the_height(monkeypatch: pytest.MonkeyPatch) -> None:
    car = replace(CAR, stop_at=0.045)
    drive = drive_of(car)
    error, z = wrong(height(car, drive), car)
    assert abs(error) < 0.035
    assert abs(z) < 1.0
    # springs alone take the stop for weight that was not there, where nothing else is doubted either
    monkeypatch.setattr(suspension, "STOP_A_METRE", 1e-6)
    monkeypatch.setattr("pipelines.estimators.load_balance.by_springs.doubts_of", lambda fit, vehicle: ())
    error, z = wrong(height(car, drive), car)
    assert error < -0.05
    assert z < -1.5


def test_without_stops_their_unknown_costs_little(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = drive_of(CAR)
    found = height(CAR, drive)
    monkeypatch.setattr(suspension, "STOP_A_METRE", 1e-6)
    sure = height(CAR, drive)
    assert abs(wrong(found, CAR)[1]) < 1.0
    assert found.std is not None
    assert sure.std is not None
    assert sure.std < found.std < 1.3 * sure.std


def test_no_stop_is_looked_for_where_wheels_hardly_move() -> None:
    rng = np.random.default_rng(3)
    calm = simulate(replace(CAR, load=0.0), demand(120.0, rng, brake=1.0, turn=1.0), rng, rough_m=0.001)
    assert max(float(calm[f"suspension_deflection_{w}"].max()) for w in ("fl", "fr", "rl", "rr")) < STOPS_M
    estimator = LoadBalance()
    prepared = estimator.prepare(
        logged(calm, rng, noise=0.1), {setting.name: setting.default for setting in estimator.settings}
    )
    columns = collect(prepared, before_the_log(vehicle_file(CAR, None)), 2.0).columns
    assert all(np.nanmax(np.abs(columns[f"stop_{w}"])) == 0.0 for w in ("fl", "fr", "rl", "rr"))


def test_brakes_that_only_noise_presses_are_off() -> None:
    """In a drive without braking a sensor's noise is its largest value."""
    rng = np.random.default_rng(5)
    columns = simulate(replace(CAR, load=0.0), demand(60.0, rng, brake=1.5), rng, rough_m=0.001)
    n = len(columns["speed"])
    del columns["brake_torque"]
    drive = logged(columns, rng)
    noise = 2e4 * rng.standard_normal(n) + 1e4
    stamps = drive.signals["speed"].time_ns
    quiet = Drive(
        {**drive.signals, "brake_pressure": Signal("brake_pressure", stamps, noise, "simulated")},
        drive.record,
    )
    estimator = LoadBalance()
    prepared = estimator.prepare(quiet, {setting.name: setting.default for setting in estimator.settings})
    file = vehicle_file(CAR, None)
    told = replace(file, quantities={**file.quantities, "brake_gain_nmppa": Quantity(4e-4, 1e-5, "test")})
    found = collect(prepared, before_the_log(told), 2.0).columns
    assert np.nanmax(found["on"]) == 0.0
    assert np.nanmax(np.abs(found["fx_brake"])) == 0.0
