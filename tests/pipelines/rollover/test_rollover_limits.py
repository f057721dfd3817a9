"""Equations (151)-(163) against numbers worked by hand and against each other."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.rollover.limits import (
    coefficient_of_forces,
    contact_limit,
    level,
    quasi_static_threshold,
    rollover_coefficient,
    sensed,
    static_stability_factor,
    steady_roll,
    suspension_limit,
)

TRACK, HEIGHT, LEVER, OFFSET = 1.6, 0.7, 0.55, 0.03


def test_static_stability_factor_is_the_limit_of_a_centred_rigid_vehicle() -> None:
    assert static_stability_factor(TRACK, HEIGHT) == pytest.approx(1.6 / 1.4)
    for side in (1.0, -1.0):
        assert contact_limit(side, TRACK, 0.0, HEIGHT, LEVER, 0.0) == pytest.approx(side * 1.6 / 1.4)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_coefficient_is_one_at_the_limit(side: float) -> None:
    roll = side * np.radians(6.0)
    limit = contact_limit(side, TRACK, OFFSET, HEIGHT, LEVER, roll)
    # in a left turn the left wheels lose their load: -1
    assert rollover_coefficient(limit, roll, TRACK, OFFSET, HEIGHT, LEVER) == pytest.approx(-side)
    springs = suspension_limit(side, TRACK, OFFSET, LEVER, roll)
    assert rollover_coefficient(springs, roll, TRACK, OFFSET, LEVER, LEVER) == pytest.approx(-side)


def test_a_load_on_the_left_helps_left_turns_and_body_roll_helps_none() -> None:
    def size(side: float, offset: float, roll: float) -> float:
        return abs(float(contact_limit(side, TRACK, offset, HEIGHT, LEVER, roll)))

    plain = size(1.0, 0.0, 0.0)
    assert size(1.0, OFFSET, 0.0) > plain
    assert size(-1.0, OFFSET, 0.0) < plain
    assert size(1.0, 0.0, 0.1) < plain
    assert size(-1.0, 0.0, -0.1) < plain
    # (155) in its printed form: r / h_r - phi
    assert suspension_limit(1.0, TRACK, OFFSET, LEVER, 0.1) == pytest.approx(
        (TRACK / 2 + OFFSET) / LEVER - 0.1
    )


def test_coefficient_of_forces() -> None:
    assert coefficient_of_forces(3000.0, 1000.0, 3000.0, 1000.0) == pytest.approx(0.5)
    assert coefficient_of_forces(0.0, 4000.0, 0.0, 4000.0) == pytest.approx(-1.0)
    assert np.isnan(coefficient_of_forces(0.0, 0.0, 0.0, 0.0))


def test_a_leaning_accelerometer_is_levelled_again() -> None:
    lateral, roll = np.array([-0.8, 0.0, 0.5]), np.array([-0.09, 0.02, 0.05])
    across, up = sensed(lateral, roll), np.cos(roll) - lateral * np.sin(roll)
    assert level(across, up, roll) == pytest.approx(lateral)


def test_the_threshold_is_met_by_the_roll_that_it_brings() -> None:
    gradient = np.radians(6.0)
    limit = quasi_static_threshold(1.0, TRACK, OFFSET, HEIGHT, LEVER, gradient)
    roll = steady_roll(limit, gradient)
    assert roll == pytest.approx(gradient * sensed(limit, roll))
    assert limit == pytest.approx(contact_limit(1.0, TRACK, OFFSET, HEIGHT, LEVER, float(roll)))
    to_the_right = quasi_static_threshold(-1.0, TRACK, -OFFSET, HEIGHT, LEVER, gradient)
    assert to_the_right == pytest.approx(limit)


def test_jacking_takes_from_the_threshold_what_a_higher_and_narrower_vehicle_does() -> None:
    rise, axis = 0.03, 0.1
    limit = quasi_static_threshold(1.0, TRACK, 0.0, HEIGHT, LEVER, 0.0, rise, axis)
    up = rise * limit
    assert limit == pytest.approx((TRACK / 2 - up * axis / (TRACK / 2)) / (HEIGHT + up))


def test_patches_that_carry_all_go_twice_as_far_to_the_inside() -> None:
    """By moments: the outer two tyres of four with the rate k carry m g and m a, so that the load is m a / (2 k) nearer to the CG."""
    mass, rate, gravity = 1800.0, 1.2e5, 9.80665
    give = mass * gravity / (4 * rate)
    limit = float(quasi_static_threshold(1.0, TRACK, 0.0, HEIGHT, LEVER, 0.0, give=give))
    inwards = mass * limit * gravity / (2 * rate)
    assert limit * HEIGHT == pytest.approx(TRACK / 2 - inwards)
