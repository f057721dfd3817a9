"""The compiled spline against scipy's, and against cubics, which it goes through exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from pipelines.prepare.spline import spline_at


@given(st.integers(4, 60), st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_it_is_the_spline_that_scipy_makes(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    time_s = 1e4 * rng.random() + np.cumsum(rng.uniform(0.004, 0.026, count))
    values = rng.standard_normal(count) * 10.0 ** rng.integers(-3, 4)
    wanted = np.sort(rng.uniform(time_s[0], time_s[-1], 200))
    wanted[[0, -1]] = time_s[[0, -1]]
    expected = CubicSpline(time_s, values)(wanted)
    assert np.allclose(
        spline_at(time_s, values, wanted), expected, rtol=0, atol=1e-7 * np.abs(expected).max()
    )


def test_a_cubic_is_read_exactly() -> None:
    time_s = np.array([0.0, 0.3, 0.5, 1.1, 1.2])
    wanted = np.linspace(0.0, 1.2, 33)
    assert spline_at(time_s, 2 - time_s + 3 * time_s**3, wanted) == pytest.approx(2 - wanted + 3 * wanted**3)


def test_nothing_wanted_is_nothing_read() -> None:
    assert len(spline_at(np.arange(5.0), np.arange(5.0), np.zeros(0))) == 0


@pytest.mark.parametrize(("times", "count"), [(3, 3), (5, 4)])
def test_too_few_samples_are_refused(times: int, count: int) -> None:
    with pytest.raises(ValueError, match="four samples"):
        spline_at(np.arange(float(times)), np.zeros(count), np.zeros(1))
