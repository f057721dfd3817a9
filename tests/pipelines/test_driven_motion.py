"""The compiled motion of a linear model against a plain loop, and what it does with bad arrays and with motion beyond all numbers."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.models.driven import BEYOND, driven
from pipelines.models.roll import RollCoefficients
from pipelines.models.roll_series import plain_roll, series_roll


@pytest.mark.parametrize("tyres", [False, True])
def test_as_a_plain_loop_does(tyres: bool) -> None:
    rng = np.random.default_rng(4)
    roll = RollCoefficients(95.0, 7.0, 0.8)
    model = (
        series_roll(roll, 0.2, 0.2, against_axles=True, gravity=False)
        if tyres
        else plain_roll(roll, gravity=True)
    )
    push = rng.normal(size=(90, 2))
    starts, stops = np.array([3, 40]), np.array([31, 88])
    phi, before, after = held = model.held(0.02)
    rows = np.array([model.angle, model.rate])
    first = model.steady(push[starts])
    expected = np.zeros((90, 2))
    for start, stop, x in zip(starts, stops, first, strict=True):
        for i in range(start, stop):
            expected[i] = rows @ x
            if i + 1 < stop:
                x = phi @ x + before @ push[i] + after @ push[i + 1]
    found = driven(push, (starts, stops), held, rows, first)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert not found[31:40].any()


def test_what_runs_away_is_beyond_and_not_missing() -> None:
    phi = np.array([[1e200]])
    held = (phi, np.zeros((1, 1)), np.zeros((1, 1)))
    found = driven(
        np.zeros((5, 1)), (np.array([0]), np.array([5])), held, np.array([[1.0]]), np.array([[1.0]])
    )
    assert found[0, 0] == 1.0
    assert (found[2:] == BEYOND).all()


def test_a_model_that_is_larger_than_the_loop_is_refused() -> None:
    held = (np.eye(4), np.zeros((4, 1)), np.zeros((4, 1)))
    with pytest.raises(ValueError, match="do not fit"):
        driven(np.zeros((5, 1)), (np.array([0]), np.array([5])), held, np.eye(4)[:1], np.zeros((1, 4)))


@pytest.mark.parametrize("stop", [6, 5])
def test_arrays_that_do_not_fit(stop: int) -> None:
    held = (np.eye(2), np.zeros((2, 1)), np.zeros((2, 1)))
    states = 2 if stop > 5 else 3
    with pytest.raises(ValueError, match=r"do not fit|leaves the arrays"):
        driven(np.zeros((5, 1)), (np.array([0]), np.array([stop])), held, np.eye(states), np.zeros((1, 2)))
