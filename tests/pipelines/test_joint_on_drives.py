"""The joint verdict on driven logs: it holds what the estimators found, chains, and gives the prior back where it can't tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from parsers.drive import Drive
from pipelines.estimators.base import Estimator
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.roll_map.estimator import RollMap
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.combine import verdict_of

MAIN = ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "cg_lateral_offset_m")


@pytest.fixture(scope="module")
def log() -> tuple[Drive, Vehicle]:
    rng = np.random.default_rng(5)
    car = Car()
    motion = simulate(car, demand(330, rng), rng)
    return logged(motion, rng), vehicle_file(car, rng)


def _run(estimator: Estimator, drive: Drive, vehicle: Vehicle) -> Estimate:
    defaults = {s.name: s.default for s in estimator.settings}
    return estimator.estimate(estimator.prepare(drive, defaults), vehicle, defaults, np.random.default_rng(1))


def test_with_one_estimator_the_joint_posterior_is_its_own(
    log: tuple[Drive, Vehicle], monkeypatch: pytest.MonkeyPatch
) -> None:
    # what may be otherwise: `tests/pipelines/test_doubts.py`
    for module in ("pipelines.joint.inference", "pipelines.estimators.load_balance.by_springs"):
        monkeypatch.setattr(f"{module}.doubts_of", lambda joint, vehicle, opened="": ())
    drive, vehicle = log
    alone = _run(LoadBalance(), drive, vehicle)
    assert len(alone.evidence) >= 3
    verdict = verdict_of([alone], vehicle)
    assert verdict.joint is not None
    for name in MAIN:
        one, both = alone.parameters[name], verdict.parameters[name]
        assert one.std is not None
        assert one.value is not None
        assert both.value == pytest.approx(one.value, abs=0.1 * one.std)
        assert both.std == pytest.approx(one.std, rel=0.1)


def test_truth_lies_in_the_intervals_and_the_log_taught(log: tuple[Drive, Vehicle]) -> None:
    drive, vehicle = log
    verdict = verdict_of([_run(e, drive, vehicle) for e in (LoadBalance(), RollMap())], vehicle)
    assert verdict.joint is not None
    truth = Car().truth()
    for name in MAIN:
        p = verdict.parameters[name]
        assert p.value is not None
        assert p.std is not None
        assert abs(p.value - truth[name]) < 3 * p.std
    assert verdict.joint.learned["cg_height_m"].bits > 0.8
    assert verdict.joint.learned["mass_kg"].bits > 2
    # one steady roll against the axles, seen by two estimators
    assert any("steady roll" in who for who, _ in verdict.joint.not_counted)
    assert verdict.parameters["roll_gradient_degpg"].sources == ("roll_map",)


def test_without_relations_the_prior_comes_back(log: tuple[Drive, Vehicle]) -> None:
    drive, vehicle = log
    few = replace(
        drive, signals={n: s for n, s in drive.signals.items() if n in ("accel_x", "accel_y", "speed")}
    )
    balance = _run(LoadBalance(), few, vehicle)
    assert balance.evidence == ()
    verdict = verdict_of([balance], vehicle)
    assert verdict.joint is None
    height = verdict.parameters["cg_height_m"]
    assert height.status == "not_identifiable"
    assert height.prior is not None
    assert height.value == pytest.approx(height.prior.value)
    assert height.std == pytest.approx(height.prior.std)


def test_witnesses_give_the_posterior_nothing(log: tuple[Drive, Vehicle]) -> None:
    drive, vehicle = log
    alone = _run(LoadBalance(), drive, vehicle)
    posing = replace(alone, estimator="published", witness=True)
    assert verdict_of([posing], vehicle).joint is None
    same = verdict_of([alone, posing], vehicle).parameters["cg_height_m"]
    assert same.std == pytest.approx(verdict_of([alone], vehicle).parameters["cg_height_m"].std)


def test_the_same_drive_gives_the_same_verdict_again(log: tuple[Drive, Vehicle]) -> None:
    drive, vehicle = log
    alone = _run(LoadBalance(), drive, vehicle)
    first, second = (verdict_of([alone], vehicle, np.random.default_rng(9)) for _ in range(2))
    assert first.parameters == second.parameters
