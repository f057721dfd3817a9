"""A balance's noise: a wrong file is misfit, which must not silence the balance that contradicts it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from parsers.drive import Drive
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.solve import MISFIT, noise_of
from pipelines.joint.inference import infer
from pipelines.results import Estimate, FloatArray
from pipelines.vehicles.vehicle import Vehicle

LIGHTER = "an empty mass above the laden one"


@pytest.fixture(scope="module")
def driven() -> tuple[Car, Drive]:
    rng = np.random.default_rng(5)
    car = Car()
    return car, logged(simulate(car, demand(330, rng), rng), np.random.default_rng(6), "suspension_force")


def _run(drive: Drive, vehicle: Vehicle) -> Estimate:
    estimator = LoadBalance()
    return estimator.estimate(estimator.prepare(drive, {}), vehicle, {}, np.random.default_rng(0))


def _heavier(file: Vehicle, by: float) -> Vehicle:
    mass = file.quantities["mass_kg"]
    wrong = replace(mass, value=by * mass.value, std=by * mass.std)
    return replace(file, quantities={**file.quantities, "mass_kg": wrong})


def test_a_little_misfit_is_noise_and_a_large_one_is_not() -> None:
    rng = np.random.default_rng(0)
    z, noise = rng.standard_normal((500, 3)), rng.standard_normal(500)
    little, large = z @ [0.3, -1.0, 0.5], z @ [30.0, -400.0, 70.0]
    assert np.array_equal(noise_of(z, little + noise), little + noise)
    left = noise_of(z, large + noise)
    assert 0.8 * MISFIT < np.std(left) < 1.5 * MISFIT
    assert np.corrcoef(left, large)[0, 1] > 0.9
    weight = rng.uniform(0.1, 1.0, 500)
    assert 0.8 * MISFIT < np.std(noise_of(z, large + noise, weight)) < 1.5 * MISFIT


def test_instruments_alike_are_no_obstacle() -> None:
    one = np.random.default_rng(1).standard_normal((200, 1))
    assert np.abs(noise_of(np.hstack([one, one]), 5 * one[:, 0])).max() < 1e-6


def _torques(found: Estimate) -> FloatArray:
    return next(e.covariance for e in found.evidence if e.kind == "longitudinal")


def test_a_wrong_file_adds_little_noise(driven: tuple[Car, Drive]) -> None:
    """Twice the mass: the torques' balance is a few times less sure of its products than with the right file (it was 40 to 80 times)."""
    car, drive = driven
    right = vehicle_file(car, None)
    sure, wrong = _torques(_run(drive, right)), _torques(_run(drive, _heavier(right, 2.0)))
    assert np.sqrt(np.diag(wrong) / np.diag(sure)).max() < 3 * MISFIT


def test_twice_the_mass_is_found_out(driven: tuple[Car, Drive]) -> None:
    car, drive = driven
    file = _heavier(vehicle_file(car, None), 2.0)
    found = infer(_run(drive, file).evidence, file, np.random.default_rng(0))
    assert found is not None
    assert LIGHTER in {r.relation for r in found.record.relations if r.text == "contradicts the log"}
    mass = found.parameters["mass_kg"]
    assert mass.status != "identified"
    assert "beyond doubt" in mass.reason
    assert all(p.status != "identified" for p in found.parameters.values())
