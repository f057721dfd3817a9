"""The roll fit's steps: straight coordinates of its bent valley, and steps that keep to their bounds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipelines.estimators.roll_map.climb import Straight, bent_by, bounded_step

NAMES = ["stiffening", "a", "b", "c", "delay"]
POINT = np.array([0.3, 104.0, 7.0, 0.9, 0.021])


def _answer(x: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Of the angle to the acceleration, times a."""
    _, a, b, c, delay = x
    s = 1j * frequency
    return np.asarray(a * np.exp(-s * delay) / (a + b * s + c * s * s))


def test_slopes_are_those_of_the_way() -> None:
    straight, small = Straight(NAMES), 1e-6
    ways = [straight.moved(POINT, small * unit) - straight.moved(POINT, -small * unit) for unit in np.eye(5)]
    np.testing.assert_allclose(straight.slopes(POINT), np.column_stack(ways) / (2 * small), atol=1e-6)


def test_a_step_is_what_parts_the_coordinates_of_its_ends() -> None:
    straight, step = Straight(NAMES), np.array([0.1, 3.0, -2.0, 0.001, -0.002])
    moved = straight.moved(POINT, step)
    apart = straight.at(moved) - straight.at(POINT)
    np.testing.assert_allclose(apart[[4, 3]], step[[4, 3]], atol=1e-12)
    np.testing.assert_allclose(apart[:3], step[:3])


def test_damping_alone_moves_the_slow_answer_by_the_third_order() -> None:
    moved = Straight(NAMES).moved(POINT, np.array([0.0, 0.0, -4.0, 0.0, 0.0]))
    assert moved[2] == pytest.approx(3.0)
    # half the frequency: an eighth of the change
    apart = [abs(_answer(moved, np.array([w])) - _answer(POINT, np.array([w])))[0] for w in (0.5, 1.0)]
    assert apart[0] / apart[1] == pytest.approx(1 / 8, rel=0.1)


def test_other_parameters_stay_as_they_are() -> None:
    straight = Straight(["b", "c", "friction"])
    x, step = np.array([7.0, 0.9, 0.1]), np.array([0.5, -0.1, 0.02])
    np.testing.assert_array_equal(straight.moved(x, step), x + step)
    np.testing.assert_array_equal(straight.slopes(x), np.eye(3))


@given(st.integers(0, 10_000))
def test_a_step_ends_at_its_bounds_and_no_worse_than_a_cut_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(4, 6))
    curvature, gradient = half @ half.T + 0.01 * np.eye(4), rng.normal(size=4)
    low, high = -rng.uniform(0, 1, 4), rng.uniform(0, 1, 4)
    step = bounded_step(curvature, gradient, low, high, 0.0)
    assert (step >= low - 1e-12).all()
    assert (step <= high + 1e-12).all()
    free = (step > low + 1e-12) & (step < high - 1e-12)
    # what is free has nothing left to gain
    np.testing.assert_allclose((gradient - curvature @ step)[free], 0.0, atol=1e-8)


def test_without_bounds_it_is_the_step_of_scoring() -> None:
    curvature = np.array([[4.0, 1.0], [1.0, 3.0]])
    gradient = np.array([1.0, -2.0])
    step = bounded_step(curvature, gradient, np.full(2, -np.inf), np.full(2, np.inf), 0.0)
    np.testing.assert_allclose(step, np.linalg.solve(curvature, gradient))


def test_a_curvature_bent_by_steps_in_all_directions_is_the_true_one() -> None:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(4, 4))
    true, expected = root @ root.T + np.eye(4), 5.0 * np.eye(4)
    # steps that are conjugate keep what those before them taught
    directions = np.linalg.inv(np.linalg.cholesky(true)).T
    bent = bent_by(expected, [(step, true @ step) for step in directions.T])
    np.testing.assert_allclose(bent, true, rtol=1e-9)


def test_a_step_along_which_the_cost_bends_the_other_way_teaches_nothing() -> None:
    curvature, step = np.diag([2.0, 3.0]), np.array([1.0, 0.5])
    np.testing.assert_array_equal(bent_by(curvature, [(step, -curvature @ step)]), curvature)
    np.testing.assert_array_equal(bent_by(curvature, [(np.zeros(2), np.zeros(2))]), curvature)
    assert np.linalg.eigvalsh(bent_by(curvature, [(step, 0.1 * curvature @ step)])).min() > 0
