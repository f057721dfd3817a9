"""The brake and roll fits' least squares: its answer on a straight line, and an end where whole steps would swing apart."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipelines.estimators.brake_roll.least import Samples, Unknown, fit_least
from pipelines.results import FloatArray


def _samples(y: FloatArray) -> Samples:
    rows = np.arange(len(y))
    return Samples(y, np.zeros(len(y), dtype=np.int64), rows // 10, np.array([0.1]), np.array([1e-6]))


def test_a_straight_line_has_the_answer_of_least_squares() -> None:
    rng = np.random.default_rng(1)
    t = np.linspace(0, 1, 400)
    y = 2.0 * t - 0.5 + 0.1 * rng.standard_normal(len(t))
    fit = fit_least(
        lambda x: x[0] * t + x[1],
        _samples(y),
        (Unknown("slope", 0.0, math.inf, 1e-4), Unknown("level", 0.0, math.inf, 1e-4)),
    )
    assert fit.converged
    # Huber's limit of three standard deviations moves it by next to nothing
    np.testing.assert_allclose(fit.values, np.polyfit(t, y, 1), atol=2e-3)
    assert fit.std("slope") == pytest.approx(0.1 / math.sqrt(400 * np.var(t)), rel=0.4)


@pytest.mark.parametrize("start", [1.3, -2.0, 6.0])
def test_whole_steps_that_swing_apart_are_halved(start: float) -> None:
    """Gauss-Newton on arctan leaves its end from 1.39 on: each step is farther off than the one before."""
    rng = np.random.default_rng(2)
    shift = 0.02 * rng.standard_normal(200)
    fit = fit_least(
        lambda x: np.full(200, math.atan(float(x[0]))),
        _samples(math.atan(0.3) + shift),
        (Unknown("x", start, math.inf, 1e-5),),
    )
    assert fit.converged
    assert fit.values[0] == pytest.approx(0.3, abs=0.01)
