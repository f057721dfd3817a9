"""The Kalman update of expansions: against plain numpy, and against the Kalman filter."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT, gpc_update, gpc_update_with
from pipelines.results import FloatArray


def _case(
    seed: int, n: int = 5, m: int = 3, terms: int = 12
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((n, terms)), rng.standard_normal((m, terms))
    return x, y, rng.standard_normal(m), rng.uniform(0.1, 2.0, m)


@pytest.mark.parametrize("m", [1, 2, 3, 6])
def test_as_published_is_the_same_as_plain_numpy(m: int) -> None:
    x, y, z, r = _case(m, m=m)
    gain = x[:, 1:] @ y[:, 1:].T @ np.linalg.inv(y[:, 1:] @ y[:, 1:].T + np.diag(r))
    target = np.column_stack([x[:, 0] + gain @ (z - y[:, 0]), x[:, 1:] - gain @ y[:, 1:]])
    gpc_update(x, y, z, r, PUBLISHED)
    np.testing.assert_allclose(x, target, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize("m", [1, 2, 3, 6])
def test_the_square_root_form_has_the_mean_and_the_covariance_of_the_kalman_filter(m: int) -> None:
    x, y, z, r = _case(10 + m, m=m)
    cross, total = x[:, 1:] @ y[:, 1:].T, y[:, 1:] @ y[:, 1:].T + np.diag(r)
    mean = x[:, 0] + cross @ np.linalg.solve(total, z - y[:, 0])
    covariance = x[:, 1:] @ x[:, 1:].T - cross @ np.linalg.solve(total, cross.T)
    gpc_update(x, y, z, r, SQUARE_ROOT)
    np.testing.assert_allclose(x[:, 0], mean, rtol=1e-11)
    np.testing.assert_allclose(x[:, 1:] @ x[:, 1:].T, covariance, rtol=1e-10, atol=1e-12)


def test_an_added_covariance_moves_the_mean_as_the_kalman_filter_does() -> None:
    rng = np.random.default_rng(4)
    x = rng.standard_normal((4, 8))
    h = np.zeros((2, 4))
    h[0, 0] = h[1, 1] = 1.0
    y, z, r, added = h @ x, rng.standard_normal(2), np.array([0.3, 0.5]), np.diag([0.7, 0.2, 0.1, 0.0])
    covariance = x[:, 1:] @ x[:, 1:].T + added
    gain = covariance @ h.T @ np.linalg.inv(h @ covariance @ h.T + np.diag(r))
    target = np.column_stack([x[:, 0] + gain @ (z - y[:, 0]), x[:, 1:] - gain @ y[:, 1:]])
    gpc_update_with(x, y, z, r, PUBLISHED, added @ h.T, h @ added @ h.T, np.empty((2, 6)))
    np.testing.assert_allclose(x, target, rtol=1e-11, atol=1e-13)


def test_a_linear_gaussian_drive_is_that_of_the_kalman_filter() -> None:
    """A constant-velocity target with noise: square-root form at each step, against the textbook filter."""
    rng = np.random.default_rng(8)
    phi, h, r = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[1.0, 0.0]]), 0.04
    mean, p = np.array([0.0, 1.0]), np.diag([2.0, 3.0])
    x = np.column_stack([mean, np.linalg.cholesky(p)])
    for step in range(200):
        mean, p = phi @ mean, phi @ p @ phi.T
        x = phi @ x
        z = np.array([0.2 + 0.15 * step + 0.2 * rng.standard_normal()])
        gain = p @ h.T / (h @ p @ h.T + r)
        mean, p = mean + gain @ (z - h @ mean), p - gain @ h @ p
        gpc_update(x, h @ x, z, np.array([r]), SQUARE_ROOT)
    np.testing.assert_allclose(x[:, 0], mean, rtol=1e-9)
    np.testing.assert_allclose(x[:, 1:] @ x[:, 1:].T, p, rtol=1e-8, atol=1e-14)


@pytest.mark.parametrize("form", [PUBLISHED, SQUARE_ROOT])
def test_an_output_that_is_not_there_is_as_if_there_were_none(form: int) -> None:
    x, y, z, r = _case(21)
    z[1] = np.nan
    fewer = x.copy()
    gpc_update(fewer, np.ascontiguousarray(y[[0, 2]]), z[[0, 2]], r[[0, 2]], form)
    gpc_update(x, y, z, r, form)
    np.testing.assert_allclose(x, fewer, rtol=1e-12)


@pytest.mark.parametrize("form", [PUBLISHED, SQUARE_ROOT])
def test_the_same_output_twice_without_noise_does_no_harm(form: int) -> None:
    x, y, z, _ = _case(22, m=2)
    y[1], z[1] = y[0], z[0]
    once = x.copy()
    gpc_update(once, np.ascontiguousarray(y[:1]), z[:1], np.zeros(1), form)
    gpc_update(x, y, z, np.zeros(2), form)
    assert np.isfinite(x).all()
    np.testing.assert_allclose(x, once, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("form", [PUBLISHED, SQUARE_ROOT])
def test_outputs_without_any_spread_change_nothing(form: int) -> None:
    x, y, z, _ = _case(23)
    y[:, 1:] = 0.0
    before = x.copy()
    gpc_update(x, y, z, np.zeros(3), form)
    np.testing.assert_array_equal(x, before)


def test_a_measurement_as_sure_as_the_prior_quarters_the_published_variance_and_halves_the_kalman_one() -> (
    None
):
    y = np.array([[0.0, 3.0, 4.0]])
    for form, left in ((PUBLISHED, 0.25), (SQUARE_ROOT, 0.5)):
        x = y.copy()
        gpc_update(x, y, np.array([1.0]), np.array([25.0]), form)
        assert x[0, 0] == pytest.approx(0.5)
        assert np.sum(x[0, 1:] ** 2) == pytest.approx(25.0 * left)
