"""The estimator on a car in roll that is richer than its model, and its refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_roll import Car, Knowledge, Sensors, record, simulate, sine_with_dwell, slalom, vehicle_of

from parsers.drive import Drive
from pipelines.analyze import run_estimator
from pipelines.estimators.base import FullSettings
from pipelines.estimators.marginalized_particle_filter.estimator import SETTINGS, MarginalizedParticleFilter
from pipelines.estimators.marginalized_particle_filter.run import explained_share
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

QUICK = {"particles": 300.0, "most_particles": 3000.0, "clouds": 3.0}
CAR = Car()


def settings(variant: str) -> FullSettings:
    return FullSettings({**{s.name: s.default for s in SETTINGS}, **QUICK}, {"variant": variant})


def vehicle(**known: float | None) -> Vehicle:
    return vehicle_of(CAR, replace(Knowledge(), **known), np.random.default_rng(3))  # type: ignore[arg-type]


def driven(accel: np.ndarray) -> Drive:
    return record(simulate(CAR, accel), CAR, Sensors(), np.random.default_rng(4))


def run(drive: Drive, of: Vehicle, variant: str = "published", seed: int = 0) -> Estimate:
    return run_estimator(MarginalizedParticleFilter(), drive, of, settings(variant), seed)


@pytest.fixture(scope="module")
def lively() -> Drive:
    return driven(np.concatenate((sine_with_dwell(5.0), slalom(4.0, seconds=20.0))))


@pytest.fixture(scope="module")
def found(lively: Drive) -> dict[str, Estimate]:
    return {variant: run(lively, vehicle(), variant) for variant in ("published", "kernel")}


@pytest.mark.parametrize("variant", ["published", "kernel"])
def test_intervals_hold_what_was_planted(found: dict[str, Estimate], variant: str) -> None:
    estimate = found[variant]
    assert estimate.status == "ran"
    assert estimate.witness
    planted = {
        "cg_height_m": CAR.cg_height,
        "roll_stiffness_nmprad": CAR.stiffness,
        "roll_damping_nmsprad": CAR.damping,
        "roll_gradient_degpg": CAR.gradient(road=True),
    }
    assert set(estimate.parameters) == set(planted)
    for name, truth in planted.items():
        entry = estimate.parameters[name]
        if name == "roll_damping_nmsprad" and entry.value is None:
            # an unknown delay between the channels looks like damping
            assert entry.status == "not_identifiable"
            continue
        assert entry.value is not None
        assert entry.std is not None
        assert abs(entry.value - truth) < 3 * entry.std, name
        assert "roll_map" not in entry.sources
    gradient = estimate.parameters["roll_gradient_degpg"]
    assert gradient.value == pytest.approx(planted["roll_gradient_degpg"], rel=0.2)
    assert gradient.status != "not_identifiable"


def test_the_height_alone_is_not_claimed_from_roll(lively: Drive) -> None:
    """Without a stiffness in the vehicle file only ratios are told: the height may not come out identified."""
    silent = run(lively, vehicle(stiffness=None, imu=None))
    assert silent.parameters["cg_height_m"].status != "identified"
    assert silent.parameters["roll_stiffness_nmprad"].status != "identified" or (
        silent.parameters["cg_height_m"].prior is not None
    )


def test_distributions_rise_over_their_levels_and_follow_the_drive(found: dict[str, Estimate]) -> None:
    for estimate in found.values():
        assert [d.parameter for d in estimate.distributions] == [
            "roll_stiffness_nmprad", "roll_damping_nmsprad", "cg_height_m"
        ]  # fmt: skip
        for distribution in estimate.distributions:
            table = np.array(distribution.quantiles)
            assert table.shape == (len(distribution.levels), len(distribution.time_s))
            told = np.isfinite(table).all(axis=0)
            assert told.sum() >= 10
            assert (np.diff(table[:, told], axis=0) >= 0).all()
            assert (np.diff(distribution.time_s) > 0).all()
        height = estimate.distributions[2]
        band = height.quantiles[height.levels.index(0.975)] - height.quantiles[height.levels.index(0.025)]
        assert np.nanmedian(band) > 0.03


def test_same_seed_same_answer_and_other_seed_near(lively: Drive, found: dict[str, Estimate]) -> None:
    again, other = run(lively, vehicle()), run(lively, vehicle(), seed=1)
    first = found["published"].parameters["cg_height_m"]
    assert again.parameters["cg_height_m"] == first
    value = other.parameters["cg_height_m"].value
    assert value is not None
    assert first.value is not None
    assert first.std is not None
    assert value != first.value
    assert abs(value - first.value) < 2 * first.std


def test_a_straight_drive_tells_nothing() -> None:
    estimate = run(driven(np.zeros(20_000)), vehicle())
    assert estimate.status == "ran"
    assert all(p.status == "not_identifiable" for p in estimate.parameters.values())
    assert "lateral acceleration" in estimate.reason
    assert estimate.distributions == ()


def test_a_dead_roll_signal_is_refused(lively: Drive) -> None:
    rng = np.random.default_rng(0)
    roll = lively.signals["roll"]
    dead = replace(roll, values=0.002 * rng.standard_normal(len(roll.values)))
    keep = ("accel_y", "speed")
    drive = replace(lively, signals={"roll": dead, **{name: lively.signals[name] for name in keep}})
    estimate = run(drive, vehicle())
    assert all(p.status == "not_identifiable" for p in estimate.parameters.values())
    assert "does not follow" in estimate.reason or "disagree" in estimate.reason


def test_without_a_mass_it_says_what_it_lacks(lively: Drive) -> None:
    estimate = run(lively, Vehicle())
    assert estimate.status == "skipped"
    assert "mass_kg" in estimate.reason


def test_an_accelerometer_where_no_model_stands_is_no_traceback(lively: Drive) -> None:
    high = vehicle()
    high = replace(high, sensors={**high.sensors, "imu_above_ground_m": Quantity(3.0, 0.02, "vehicle file")})
    for variant in ("published", "kernel"):
        estimate = run(lively, high, variant)
        assert estimate.status == "ran"
        assert "does not run away" in estimate.reason
        assert all(p.status == "not_identifiable" for p in estimate.parameters.values())


@pytest.mark.parametrize("variant", ["nonbo", "nonadap"])
def test_papers_comparisons_are_variants(lively: Drive, variant: str) -> None:
    estimate = run(lively, vehicle(), variant)
    assert estimate.status == "ran"
    gradient = estimate.parameters["roll_gradient_degpg"]
    assert gradient.value is not None
    assert gradient.value == pytest.approx(CAR.gradient(road=True), rel=0.25)
    if variant == "nonadap":
        assert estimate.diagnostics["particles_mean"] == pytest.approx(QUICK["particles"])


@pytest.mark.parametrize("variant", ["published", "kernel"])
def test_cap_holds_whatever_is_wanted(lively: Drive, variant: str) -> None:
    few = FullSettings(
        {**settings(variant), "particles": 5000.0, "most_particles": 100.0}, {"variant": variant}
    )
    estimate = run_estimator(MarginalizedParticleFilter(), lively, vehicle(), few, 0)
    assert estimate.diagnostics["particles_mean"] <= 100.0


def test_few_rows_are_no_motion_that_does_not_follow() -> None:
    short = driven(slalom(4.0, seconds=6.0))
    estimate = run(short, vehicle())
    assert "does not follow" not in estimate.reason
    assert not any("does not follow" in p.reason for p in estimate.parameters.values())


def test_share_that_is_explained_needs_few_samples() -> None:
    angle = np.column_stack((0.02 * np.sin(np.arange(8.0)), np.full(8, np.nan)))
    assert explained_share(angle, 0.01 * angle) == pytest.approx(1 - 1e-4)
    assert explained_share(0 * angle, 0 * angle) == 0.0
