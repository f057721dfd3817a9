"""What is known before the log: springs to roll stiffness, loads, and the second stage's draws."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipelines.estimators.roll_map.height import two_peaks
from pipelines.estimators.roll_map.posterior import moments, pure_likelihood, quantiles
from pipelines.estimators.roll_map.priors import damping_prior, draw_vehicle, stiffness_prior
from pipelines.prepare.roll_angle import TYPICAL_TRACK
from pipelines.vehicles.kinds import LOAD_SPREAD
from pipelines.vehicles.vehicle import Quantity, Vehicle


def known(**values: tuple[float, float]) -> dict[str, Quantity]:
    return {key: Quantity(value, std, "vehicle file") for key, (value, std) in values.items()}


def test_springs_and_bars_make_roll_stiffness() -> None:
    """½ k t² an axle plus the bars, by hand; the spread is that of a product."""
    quantities = known(
        spring_rate_front_npm=(25_000, 500), spring_rate_rear_npm=(28_000, 560), track_front_m=(1.6, 0.0),
        track_rear_m=(1.5, 0.0), anti_roll_stiffness_front_nmprad=(12_000, 600),
        anti_roll_stiffness_rear_nmprad=(0.0, 0.0),
    )  # fmt: skip
    prior = stiffness_prior(Vehicle(quantities=quantities))
    assert prior is not None
    assert prior.value == pytest.approx(32_000 + 31_500 + 12_000)
    assert prior.std == pytest.approx(math.sqrt(640**2 + 630**2 + 600**2))
    assert "anti-roll bars" in prior.source
    del quantities["track_rear_m"]
    assert stiffness_prior(Vehicle(quantities=quantities)) is None
    stated = Vehicle(quantities=quantities | known(roll_stiffness_nmprad=(70_000, 700)))
    prior = stiffness_prior(stated)
    assert prior is not None
    assert (prior.value, prior.std) == (70_000, 700)
    assert damping_prior(stated) is None


def test_bars_of_which_the_file_is_silent_are_unknown_not_none() -> None:
    """As usual beside springs of 32 000 and 31 500 N m/rad, alike on both axles; less where the other axle's is stated."""
    quantities = known(
        spring_rate_front_npm=(25_000, 0.0), spring_rate_rear_npm=(28_000, 0.0), track_front_m=(1.6, 0.0),
        track_rear_m=(1.5, 0.0),
    )  # fmt: skip
    silent = stiffness_prior(Vehicle(quantities=quantities))
    assert silent is not None
    assert silent.value == pytest.approx(1.6 * 63_500)
    assert silent.std == pytest.approx(0.5 * 63_500)
    assert "does not state" in silent.source
    front = quantities | known(anti_roll_stiffness_front_nmprad=(12_000, 600))
    half = stiffness_prior(Vehicle(quantities=front))
    assert half is not None
    assert half.value == pytest.approx(63_500 + 12_000 + 0.3 * 31_500)
    assert half.std == pytest.approx(math.hypot(600, 0.4 * 31_500))
    assert "usual rear anti-roll bar" in half.source
    live = stiffness_prior(Vehicle(quantities=quantities, body="Pickup"))
    assert live is not None
    assert live.value == pytest.approx(1.6 * 32_000 + 1.1 * 31_500)


def test_a_stated_load_moves_mass_height_and_inertia() -> None:
    """300 kg at 1.2 m on 1 500 kg at 0.55 m: the lever rule."""
    quantities = known(
        mass_kg=(1500, 1e-6), cg_height_m=(0.55, 1e-6), roll_inertia_kgm2=(550, 1e-6),
        unsprung_mass_front_kg=(70, 1e-6), unsprung_mass_rear_kg=(70, 1e-6), wheel_radius_m=(0.3, 1e-6),
    )  # fmt: skip
    vehicle = Vehicle(quantities=quantities, load=known(mass_kg=(300, 1e-6), height_m=(1.2, 1e-6)))
    draws, assumptions, source = draw_vehicle(vehicle, np.random.default_rng(1), 50)
    height = (1500 * 0.55 + 300 * 1.2) / 1800
    assert source == "vehicle file"
    np.testing.assert_allclose(draws.mass, 1800, rtol=1e-6)
    np.testing.assert_allclose(draws.height, height, rtol=1e-5)
    np.testing.assert_allclose(draws.sprung_height, (1800 * height - 140 * 0.3) / 1660, rtol=1e-5)
    own = LOAD_SPREAD[0] * TYPICAL_TRACK[0] ** 2
    np.testing.assert_allclose(draws.inertia, 550 + 1500 * 300 / 1800 * 0.65**2 + own * 300, rtol=1e-5)
    assert {"load mass", "unsprung mass, front", "track"} <= {a.name for a in assumptions}


def test_an_unknown_load_is_wide_and_said() -> None:
    vehicle = Vehicle(body="SUV", quantities=known(mass_kg=(1800, 20)))
    draws, assumptions, source = draw_vehicle(vehicle, np.random.default_rng(1), 20_000)
    assert source is not None
    assert "measured vehicles" in source
    load = draws.mass - 1800
    assert 170 < load.mean() < 220
    assert load.std() > 60
    assert next(a for a in assumptions if a.name == "load mass").source == "the vehicle file has no [load]"


def test_taking_the_prior_out_gives_the_likelihood_back() -> None:
    rng = np.random.default_rng(2)
    root = rng.standard_normal((3, 3))
    information = root @ root.T + np.diag([5.0, 1.0, 2.0])
    centre, mean, std = rng.standard_normal(3), np.array([0.3, -1.0, 0.5]), np.array([2.0, 1.0, 3.0])
    covariance = np.linalg.inv(information + np.diag(std**-2))
    posterior = covariance @ (information @ centre + mean / std**2)
    matrix, linear = pure_likelihood(posterior, covariance, mean, std)
    np.testing.assert_allclose(matrix, information, rtol=1e-9)
    np.testing.assert_allclose(linear, information @ centre, rtol=1e-8)


def test_data_that_say_nothing_leave_no_information() -> None:
    std = np.array([2.0, 1.0, 3.0])
    matrix, linear = pure_likelihood(np.zeros(3), np.diag(std**2), np.zeros(3), std)
    assert not matrix.any()
    assert not linear.any()


def test_weighted_quantiles_and_peaks() -> None:
    rng = np.random.default_rng(3)
    values = rng.standard_normal(40_000)
    weight = np.exp(values - 0.5)  # turns a unit normal about 0 into one about 1
    weight /= weight.sum()
    assert moments(values, weight) == (pytest.approx(1.0, abs=0.03), pytest.approx(1.0, abs=0.03))
    assert quantiles(values, weight, (0.025, 0.5)) == pytest.approx([-0.96, 1.0], abs=0.06)
    even = np.full(len(values), 1 / len(values))
    assert two_peaks(values, even) is None
    double = np.where(rng.random(len(values)) < 0.4, 0.45, 0.70) + 0.03 * values
    peaks = two_peaks(double, even)
    assert peaks == (pytest.approx(0.45, abs=0.02), pytest.approx(0.70, abs=0.02))


def test_tyres_that_do_not_give_stay_possible() -> None:
    """5 % of the draws where the file is silent, 1 % against a stated rate; the others as known."""
    base = known(mass_kg=(1500, 15), track_front_m=(1.5, 0.01), track_rear_m=(1.5, 0.01))
    silent, _, _ = draw_vehicle(Vehicle(quantities=base), np.random.default_rng(2), 20_000)
    usual = (150e3 + 45 * 1500) * 1.5**2
    assert np.mean(silent.tyre_roll > 8 * usual) == pytest.approx(0.05, abs=0.005)
    assert np.median(silent.tyre_roll) == pytest.approx(usual, rel=0.03)
    stated = base | known(tire_vertical_rate_npm=(220_000, 2_200))
    told, _, _ = draw_vehicle(Vehicle(quantities=stated), np.random.default_rng(2), 20_000)
    assert np.mean(told.tyre_roll > 10 * 220_000 * 1.5**2) == pytest.approx(0.01, abs=0.003)
