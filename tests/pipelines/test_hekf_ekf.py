"""The published HEKF-EKF on a log: a witness whose interval is wider than its own covariance."""

from __future__ import annotations

import numpy as np
import plant_axle_load as plant
import pytest

from pipelines.estimators.hekf_ekf.answers import correlation_time
from pipelines.estimators.hekf_ekf.estimator import HekfEkf
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Vehicle

ESTIMATOR = HekfEkf()
LORRY = plant.Lorry()
NAMES = ("axle_load_rear", "speed", "road_grade")


def analyse(
    names: tuple[str, ...] = NAMES,
    sensors: plant.Sensors | None = None,
    vehicle: Vehicle | None = None,
    motion: plant.Motion | None = None,
) -> Estimate:
    drive = plant.record(
        LORRY, plant.motion() if motion is None else motion, sensors or plant.Sensors(), names
    )
    known = plant.vehicle(LORRY) if vehicle is None else vehicle
    return ESTIMATOR.estimate(ESTIMATOR.prepare(drive, {}), known, {}, np.random.default_rng(0))


def test_is_a_witness_and_near_the_truth_within_its_interval() -> None:
    found = analyse()
    assert found.witness
    for name, truth in (("cg_height_m", 1.03), ("cg_to_front_axle_m", 1.5)):
        answer = found.parameters[name]
        assert answer.value is not None
        assert answer.low is not None
        assert answer.high is not None
        assert answer.value == pytest.approx(truth, rel=0.05)
        assert answer.low < truth < answer.high
    own = found.diagnostics["filter_height_std_m"]
    height = found.parameters["cg_height_m"]
    assert height.std is not None
    assert height.std > 5 * own
    assert {track.parameter for track in found.tracks} == {"cg_height_m", "cg_to_front_axle_m"}
    assert found.traces


def test_front_axle_serves_too() -> None:
    height = analyse(("axle_load_front", "speed", "road_grade")).parameters["cg_height_m"]
    assert height.value == pytest.approx(1.03, rel=0.07)


def test_without_a_grade_it_says_flat_and_doubts() -> None:
    found = analyse(("axle_load_rear", "speed"))
    assert any("flat" in entry.source for entry in found.assumptions)
    known, flat = analyse().parameters["cg_height_m"].std, found.parameters["cg_height_m"].std
    assert known is not None
    assert flat is None or flat > known
    from_altitude = analyse(("axle_load_rear", "speed", "altitude"))
    assert any("altitude" in entry.source for entry in from_altitude.assumptions)


def test_no_excitation_no_height() -> None:
    found = analyse(motion=plant.motion(size=0.02, hill=0.0)).parameters["cg_height_m"]
    assert found.status == "not_identifiable"
    assert "started with" in found.reason


def test_a_wrong_mass_moves_both_and_the_interval_knows() -> None:
    """Only m h and m a are identifiable: mass 5 % too large, both 5 % too small."""
    right = analyse().parameters
    wrong = analyse(vehicle=plant.vehicle(LORRY, mass=1.05 * LORRY.mass)).parameters
    for name in ("cg_height_m", "cg_to_front_axle_m"):
        before, after = right[name].value, wrong[name].value
        assert before is not None
        assert after is not None
        assert after / before == pytest.approx(1 / 1.05, rel=0.01)
    silent = analyse(vehicle=plant.vehicle(LORRY, load=None)).parameters["cg_height_m"]
    assert silent.std is not None
    assert right["cg_height_m"].std is not None
    assert silent.std > 1.5 * right["cg_height_m"].std


def test_both_axles_give_the_mass() -> None:
    names = (*NAMES, "axle_load_front")
    found = analyse(names, vehicle=plant.vehicle(LORRY, load=None, mass=4000.0)).parameters
    assert found["cg_to_front_axle_m"].value == pytest.approx(1.5, rel=0.03)


def test_missing_signals_are_no_error() -> None:
    found = analyse(("speed",))
    assert found.parameters["cg_height_m"].status == "not_identifiable"
    assert found.status == "ran"


def test_correlation_time_of_white_and_of_slow_noise() -> None:
    rng = np.random.default_rng(0)
    white = rng.standard_normal(20_000)
    slow = np.convolve(white, np.ones(10) / 10, mode="same")
    assert correlation_time(white, 50.0) < 1.5
    assert correlation_time(slow, 50.0) == pytest.approx(10.0, rel=0.3)
