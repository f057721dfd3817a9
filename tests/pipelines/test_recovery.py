"""A motor that charges in stops, its torque in no log: the brakes' torque is then less than the vehicle's force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from pipelines.estimators.load_balance.along import along_relation
from pipelines.estimators.load_balance.data import collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.solve import solve
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray

ESTIMATOR = LoadBalance()


@pytest.fixture(scope="module")
def stops() -> tuple[Car, dict[str, FloatArray]]:
    rng = np.random.default_rng(5)
    car = Car()
    return car, simulate(car, demand(180.0, rng), rng)


@pytest.mark.parametrize(("share", "constant_mps2"), [(0.0, 0.0), (0.0, 0.8), (0.3, 0.4), (0.4, 0.0)])
def test_brake_torque_alone_contradicts_no_battery_vehicles_mass(
    stops: tuple[Car, dict[str, FloatArray]], share: float, constant_mps2: float
) -> None:
    car, columns = stops
    taken = share * columns["brake_torque"] + constant_mps2 * car.mass * car.radius
    held = columns | {"brake_torque": np.maximum(columns["brake_torque"] - taken, 0.0)}
    drive = logged(
        held, np.random.default_rng(3), "suspension_force", "suspension_deflection", "drive_torque"
    )
    prepared = ESTIMATOR.prepare(drive, {})
    widened = {}
    for powertrain in ("battery", "combustion"):
        known = before_the_log(replace(vehicle_file(car, None), powertrain=powertrain))
        relation = along_relation(collect(prepared, known, 2.0), known)
        assert relation is not None
        fit = solve([relation], known)
        widened[powertrain] = fit.inflation
        assert abs(fit.u[known.index("empty_mass")]) < 0.5
    assert widened["battery"] < 1.05
    # an engine holds back by 0.05 ± 0.12 m/s²: what that does not hold contradicts the vehicle's mass
    assert widened["combustion"] > 1.2 or share + constant_mps2 == 0.0
