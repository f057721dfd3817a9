"""A vehicle file that states tyres which do not give, by a very large rate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipelines.estimators.brake_roll.vehicle import known_of
from pipelines.estimators.roll_map.priors import draw_vehicle
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.models.axle_load import patch_shift
from pipelines.simulation.logs.vehicle import plant_vehicle
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

RATES = (1e9, 1e12)


def file(rate: float) -> Vehicle:
    text = f"""[vehicle]
body = "SUV"
mass_kg = 1995
wheelbase_m = 2.8
track_front_m = 1.6
track_rear_m = 1.6
roll_stiffness_nmprad = 88740
tire_vertical_rate_npm = {rate:g}
"""
    return parse_vehicle(text, Path("car.toml"))


def row(known: Known, name: str) -> tuple[float, float]:
    at = known.index(name)
    return float(known.mean[at]), float(known.std[at])


@pytest.mark.parametrize("rate", RATES)
def test_every_unknown_stays_finite_and_nothing_else_becomes_rigid(rate: float) -> None:
    known, usual = before_the_log(file(rate)), before_the_log(file(250e3))
    assert np.isfinite(known.mean).all()
    assert (known.std > 0).all()
    assert row(known, "tyre_rate")[0] == rate
    # no real tyre holds a standing vehicle harder
    for axle in ("front", "rear"):
        mean, spread = row(known, f"standing_{axle}")
        assert mean <= 3 * row(usual, f"standing_{axle}")[0]
        assert spread <= 3 * row(usual, f"standing_{axle}")[1]
    # what does not give upright gives nothing aside or along, where nobody says otherwise
    assert abs(row(known, "patch_lag")[0]) < 1e-4 < row(usual, "patch_lag")[0]
    assert abs(row(known, "patch_side")[0]) < 1e-5 < row(usual, "patch_side")[0]


@pytest.mark.parametrize("rate", RATES)
def test_the_tyres_have_no_part_in_the_roll(rate: float) -> None:
    draws, assumptions, _ = draw_vehicle(file(rate), np.random.default_rng(0), 500)
    assert np.isfinite(draws.tyre_roll).all()
    assert np.median(88740 / (88740 + draws.tyre_roll)) < 1e-3
    assert any("tire_vertical_rate_npm" in each.name for each in assumptions)
    assert patch_shift(1995.0, rate) == pytest.approx((0.0, 0.0), abs=1e-5)


def test_the_plant_of_such_a_file_can_be_driven() -> None:
    hard = plant_vehicle(file(1e9))
    assert hard.tire_vertical_rate_front_npm == hard.tire_vertical_rate_rear_npm == 3e7


@pytest.mark.parametrize("rate", RATES)
def test_braking_and_roll_know_the_suspension_alone(rate: float) -> None:
    known = known_of(file(rate))
    assert known is not None
    assert known.stiffness is not None
    assert known.stiffness.value == pytest.approx(88740, rel=1e-3)
    assert np.isfinite(known.stiffness.std)
