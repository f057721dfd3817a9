"""A balance's noise is what its instruments do not explain: a wrong file is misfit, and must not silence the balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from parsers.drive import Drive
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.solve import unexplained
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


def test_what_the_instruments_explain_is_taken_off() -> None:
    rng = np.random.default_rng(0)
    z = rng.standard_normal((500, 3))
    noise = rng.standard_normal(500)
    left = unexplained(z, z @ [3.0, -40.0, 7.0] + noise)
    assert np.std(left - noise) < 0.15
    np.testing.assert_allclose(z.T @ left, 0, atol=1e-9)
    weight = rng.uniform(0.1, 1.0, 500)
    np.testing.assert_allclose(
        z.T @ (weight * unexplained(z, z @ [3.0, -40.0, 7.0] + noise, weight)), 0, atol=1e-9
    )


def test_instruments_alike_are_no_obstacle() -> None:
    one = np.random.default_rng(1).standard_normal((200, 1))
    left = unexplained(np.hstack([one, one]), 5 * one[:, 0])
    assert np.abs(left).max() < 1e-6


def _torques(found: Estimate) -> FloatArray:
    return next(e.covariance for e in found.evidence if e.kind == "longitudinal")


def test_a_wrong_file_adds_no_noise(driven: tuple[Car, Drive]) -> None:
    """Twice the mass: the torques' balance is as sure of its products as with the right file (it was 40 to 80 times less)."""
    car, drive = driven
    right = vehicle_file(car, None)
    sure, wrong = _torques(_run(drive, right)), _torques(_run(drive, _heavier(right, 2.0)))
    np.testing.assert_allclose(np.sqrt(np.diag(wrong) / np.diag(sure)), 1.0, atol=0.2)


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
