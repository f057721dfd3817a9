"""Priors from the measured vehicles: calibrated on the vehicles themselves, silent outside their range."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.vehicles.measured import POWERTRAINS, known_body, measured_inertias, measured_vehicles
from pipelines.vehicles.priors import (
    measured_cg_height,
    measured_pitch_inertia,
    measured_roll_inertia,
    standing,
)


def test_tables_are_whole() -> None:
    assert len(measured_vehicles().height) == 1270
    assert len(measured_inertias().roll) == 204


@pytest.mark.parametrize("style", ["Sedan", "SUV", "Pickup", "Hatchback", "Wagon", "Minivan", "Van", "Coupe"])
def test_height_prior_covers_the_measured(style: str) -> None:
    table = measured_vehicles()
    inside = []
    for body, mass, height in zip(table.body, table.mass, table.height, strict=True):
        if body == style:
            prior = measured_cg_height(body, mass)
            assert prior is not None
            inside.append(abs(height - prior.value) < 1.96 * prior.std)
    # 34 wagons at 95 %: two standard errors are 0.075
    assert 0.87 <= np.mean(inside) <= 1.0


def test_hatchback_of_the_volvo() -> None:
    prior = measured_cg_height("Hatchback", 1355)
    assert prior is not None
    assert prior.value == pytest.approx(0.555, abs=0.01)
    assert 0.02 < prior.std < 0.04


def test_a_coupe_may_be_a_sports_car() -> None:
    """The sports cars among the measured vehicles, closed or open, are within its prior, and so are two-door saloons."""
    table = measured_vehicles()
    sports = ("FR-S", "350Z", "MR2", "MX5", "S2000", "Z4")
    found = [i for i, label in enumerate(table.label) if any(name in label for name in sports)]
    assert len(found) >= len(sports)
    away = []
    for i in found:
        prior = measured_cg_height("Coupe", float(table.mass[i]))
        assert prior is not None
        assert "sports cars" in prior.source
        away.append((float(table.height[i]) - prior.value) / prior.std)
    assert max(map(abs, away)) < 2
    assert np.mean(away) < 0


def test_no_prior_outside_what_was_measured() -> None:
    assert measured_cg_height(None, None) is None
    assert measured_cg_height("semi-trailer tractor", 8000) is None
    assert measured_cg_height("Robot", 1000) is None
    assert measured_cg_height("SUV", 9000) is None
    assert measured_cg_height(None, 50) is None
    assert measured_roll_inertia(50) is None
    assert measured_roll_inertia(None) is None


def test_inertia_prior_covers_the_measured() -> None:
    table = measured_inertias()
    inside = []
    for mass, track, roll in zip(table.mass, table.track, table.roll, strict=True):
        prior = measured_roll_inertia(mass, track)
        assert prior is not None
        inside.append(abs(roll - prior.value) < 1.96 * prior.std)
    assert 0.92 <= np.mean(inside) <= 0.99
    without, with_track = measured_roll_inertia(1500), measured_roll_inertia(1500, 1.5)
    assert without is not None
    assert with_track is not None
    assert with_track.std / with_track.value < without.std / without.value


def test_body_names() -> None:
    assert known_body("Station Wagon") == "Wagon"
    assert known_body("suv") == "SUV"
    assert known_body("Pick-up") == "Pickup"
    assert known_body("bus") is None
    assert known_body(None) is None


def test_standing() -> None:
    where = standing("Hatchback", 0.55, 1355)
    assert where.body == "Hatchback"
    assert len(where.same_body) == 65
    assert where.percentile is not None
    assert 30 < where.percentile < 70
    assert len(where.nearest) == 5
    assert standing(None, None).percentile is None


@pytest.mark.parametrize("powertrain", POWERTRAINS)
def test_height_prior_by_powertrain_covers_the_measured(powertrain: str) -> None:
    table = measured_vehicles()
    away = []
    rows = zip(table.body, table.mass, table.height, table.powertrain, strict=True)
    for body, mass, height, kind in rows:
        if kind == powertrain:
            prior = measured_cg_height(body, mass, powertrain)
            assert prior is not None
            away.append((height - prior.value) / prior.std)
    assert len(away) > 10
    assert abs(np.mean(away)) < 0.3
    assert 0.6 < np.sqrt(np.mean(np.square(away))) < 1.2
    assert np.mean(np.abs(away) < 1.96) >= 0.9


def test_a_battery_below_the_floor_lowers_the_prior() -> None:
    silent, burning, battery = (measured_cg_height("SUV", 2400, p) for p in (None, "combustion", "battery"))
    assert silent is not None
    assert burning is not None
    assert battery is not None
    # the two measured ones stand at 0.55 and 0.58 m, the silent prior at 0.71 +- 0.03
    assert battery.value < silent.value - 2 * silent.std
    assert battery.std > 2 * burning.std
    assert burning.std < silent.std
    assert "battery vehicles" in battery.source


def test_no_prior_for_a_bus_whatever_drives_it() -> None:
    assert measured_cg_height("bus", 9000, "battery") is None
    unknown = measured_cg_height(None, 1800, "battery")
    assert unknown is not None
    assert unknown.std > 0.07


# mass, wheelbase (their makers') and measured pitch inertia, kg m and kg m²
KNOWN_LENGTHS = {
    "325i": (1251.5, 2.57, 2011.4),
    "Caravan": (1667.7, 2.845, 3270.1),
    "Club Wagon": (2529.0, 3.505, 6748.6),
    "E150": (2256.8, 3.505, 6476.6),
    "Suburban": (2667.0, 3.34, 7284.2),
    "Tahoe": (2536.9, 2.985, 5003.7),
}


@pytest.mark.parametrize("name", KNOWN_LENGTHS)
def test_a_pitch_inertia_goes_by_the_wheelbase_where_it_is_known(name: str) -> None:
    mass, length, measured = KNOWN_LENGTHS[name]
    prior = measured_pitch_inertia(mass, length)
    assert prior is not None
    assert abs(measured - prior.value) < 1.96 * prior.std
    assert prior.std < 0.13 * prior.value
    by_mass = measured_pitch_inertia(mass)
    assert by_mass is not None
    assert by_mass.std / by_mass.value > prior.std / prior.value


def test_a_pitch_inertia_without_a_mass_is_not_told() -> None:
    assert measured_pitch_inertia(None, 2.7) is None
    assert measured_pitch_inertia(9000.0, 4.2) is None
