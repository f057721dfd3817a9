"""Compiled filters and recursive least squares against scipy's bilinear filters, plain Python and batch least squares."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from pipelines.filters.least_squares import recursive_least_squares
from pipelines.filters.second_order import second_order_filters

Array = NDArray[np.float64]


@pytest.mark.parametrize(
    ("natural", "damping", "step"), [(6.0, 0.1, 0.005), (20.0, 0.5, 0.01), (1.0, 0.01, 0.002)]
)
def test_filters_are_scipys_bilinear_ones(natural: float, damping: float, step: float) -> None:
    u = np.random.default_rng(1).standard_normal(3000)
    found = second_order_filters(u, step, natural, damping)
    below = [1.0, 2 * damping * natural, natural**2]
    for column, above in enumerate(([1.0], [1.0, 0.0], [1.0, 0.0, 0.0])):
        b, a = bilinear(above, below, 1 / step)
        np.testing.assert_allclose(found[:, column], lfilter(b, a, u), rtol=1e-7, atol=1e-9)


def test_filters_refuse_nonsense() -> None:
    with pytest.raises(ValueError, match="above 0"):
        second_order_filters(np.zeros(5), 0.0, 6.0, 0.1)


def plain(phi: Array, y: Array, theta: Array, p: Array, keep: float) -> tuple[Array, Array]:
    """Textbook recursive least squares with matrices."""
    for row, value in zip(phi, y, strict=True):
        gain = p @ row / (keep + row @ p @ row)
        theta = theta + gain * (value - theta @ row)
        p = (p - np.outer(gain, row @ p)) / keep
    return theta, p


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("keep", [1.0, 0.995])
def test_least_squares_is_the_plain_one(count: int, keep: float) -> None:
    rng = np.random.default_rng(count)
    phi, start = rng.standard_normal((500, count)), rng.standard_normal(count)
    y = phi @ np.arange(1.0, count + 1) + 0.1 * rng.standard_normal(500)
    p0 = np.eye(count) * 10 + 1
    wanted, wanted_p = plain(phi, y, start, p0, keep)
    track, theta, p = recursive_least_squares(phi, y, start, p0, every=50, forgetting=keep)
    np.testing.assert_allclose(theta, wanted, rtol=1e-9)
    np.testing.assert_allclose(p, wanted_p, rtol=1e-8)
    np.testing.assert_array_equal(track[-1], theta)
    np.testing.assert_allclose(track[1], plain(phi[:100], y[:100], start, p0, keep)[0], rtol=1e-9)
    np.testing.assert_array_equal(p, p.T)


def test_a_wide_start_gives_batch_least_squares() -> None:
    rng = np.random.default_rng(3)
    phi = rng.standard_normal((400, 3))
    y = phi @ [3.0, -1.0, 0.5] + rng.standard_normal(400)
    _, theta, p = recursive_least_squares(phi, y, np.zeros(3), 1e9 * np.eye(3))
    np.testing.assert_allclose(theta, np.linalg.lstsq(phi, y, rcond=None)[0], rtol=1e-6)
    np.testing.assert_allclose(p, np.linalg.inv(phi.T @ phi), rtol=1e-5)


def test_least_squares_refuses_what_does_not_fit() -> None:
    with pytest.raises(ValueError, match="fit together"):
        recursive_least_squares(np.zeros((5, 2)), np.zeros(4), np.zeros(2), np.eye(2))
    with pytest.raises(ValueError, match="forgetting"):
        recursive_least_squares(np.zeros((5, 2)), np.zeros(5), np.zeros(2), np.eye(2), forgetting=1.5)
