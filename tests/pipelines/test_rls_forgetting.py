"""Recursive least squares with forgetting: equal to batch weighted least squares, with and without noise on the inputs."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.filters.least_squares import recursive_least_squares
from pipelines.filters.rls_forgetting import rls_forgetting
from pipelines.results import FloatArray

THETA = np.array([2.0, -1.0, 0.5])


def problem(rows: int, seed: int = 0, noise: float = 0.1) -> tuple[FloatArray, FloatArray]:
    """phi (rows, 2, 3) and y (rows, 2) of two outputs that share three coefficients."""
    rng = np.random.default_rng(seed)
    phi = rng.standard_normal((rows, 2, 3))
    return phi, phi @ THETA + noise * rng.standard_normal((rows, 2))


def batch(
    phi: FloatArray, y: FloatArray, p0: FloatArray, variance: FloatArray, keep: float, excess: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The closed form: weights lambda^age, the start's information aging too. Returns theta and P."""
    rows = len(y)
    weight = keep ** np.arange(rows - 1, -1, -1.0)
    information = keep**rows * np.linalg.inv(p0)
    right = np.zeros(phi.shape[2])
    for i in range(phi.shape[1]):
        weighted = phi[:, i] * (weight / variance[i])[:, None]
        information = information + weighted.T @ phi[:, i] - np.diag(excess[i] * weight.sum() / variance[i])
        right += weighted.T @ y[:, i]
    p = np.linalg.inv(information)
    return p @ right, p


@pytest.mark.parametrize("keep", [1.0, 0.98])
def test_equals_weighted_least_squares_of_all_samples(keep: float) -> None:
    phi, y = problem(200)
    variance, p0 = np.array([0.01, 0.04]), np.diag([1.0, 4.0, 9.0])
    track, spread, theta, p = rls_forgetting(phi, y, np.zeros(3), p0, variance=variance, forgetting=keep)
    expected, covariance = batch(phi, y, p0, variance, keep, np.zeros((2, 3)))
    assert np.allclose(theta, expected, rtol=1e-9, atol=0)
    assert np.allclose(p, covariance, rtol=1e-8, atol=1e-15)
    assert np.allclose(track[-1], theta)
    assert np.allclose(spread[-1] ** 2, np.diag(p))


def test_one_output_equals_the_scalar_filter() -> None:
    phi, y = problem(100)
    _, _, theta, p = rls_forgetting(phi[:, :1], y[:, :1], np.zeros(3), np.eye(3), forgetting=0.97)
    _, expected, covariance = recursive_least_squares(
        phi[:, 0], y[:, 0], np.zeros(3), np.eye(3), forgetting=0.97
    )
    assert np.allclose(theta, expected, rtol=1e-10)
    assert np.allclose(p, covariance, rtol=1e-9)


def test_known_input_noise_is_taken_out_as_in_the_closed_form() -> None:
    phi, y = problem(400)
    excess = np.array([[0.2, 0.0, 0.0], [0.0, 0.0, 0.1]])
    variance, p0 = np.array([0.01, 0.02]), 1e-3 * np.eye(3)
    _, _, theta, _ = rls_forgetting(phi, y, np.zeros(3), p0, variance=variance, input_variance=excess)
    expected, _ = batch(phi, y, p0, variance, 1.0, excess)
    # the last samples' excess may still wait
    assert np.allclose(theta, expected, atol=2e-3)


def test_noise_on_inputs_biases_towards_zero_and_its_variance_takes_the_bias_out() -> None:
    phi, y = problem(20_000, seed=1)
    seen = phi.copy()
    seen[:, :, 0] += 0.5 * np.random.default_rng(2).standard_normal(phi.shape[:2])
    excess = np.zeros((2, 3))
    excess[:, 0] = 0.25
    plain = rls_forgetting(seen, y, np.zeros(3), 100 * np.eye(3))[2]
    right = rls_forgetting(seen, y, np.zeros(3), 100 * np.eye(3), input_variance=excess)[2]
    assert plain[0] == pytest.approx(2.0 / 1.25, abs=0.05)
    assert right[0] == pytest.approx(2.0, abs=0.05)


def test_follows_a_change_only_with_forgetting() -> None:
    phi, y = problem(2000, noise=0.0)
    y[1000:] += phi[1000:, :, 0]
    with_memory = rls_forgetting(phi, y, np.zeros(3), 100 * np.eye(3))[2]
    forgetful = rls_forgetting(phi, y, np.zeros(3), 100 * np.eye(3), forgetting=0.98)[2]
    assert forgetful[0] == pytest.approx(3.0, abs=1e-4)
    assert with_memory[0] == pytest.approx(2.5, abs=0.1)


def test_wrong_input_is_refused() -> None:
    phi, y = problem(10)
    with pytest.raises(ValueError, match="three axes"):
        rls_forgetting(phi[:, 0], y, np.zeros(3), np.eye(3))
    with pytest.raises(ValueError, match="fit together"):
        rls_forgetting(phi, y[:5], np.zeros(3), np.eye(3))
    with pytest.raises(ValueError, match="forgetting"):
        rls_forgetting(phi, y, np.zeros(3), np.eye(3), forgetting=0.0)
    with pytest.raises(ValueError, match="variance above 0"):
        rls_forgetting(phi, y, np.zeros(3), np.eye(3), variance=np.array([1.0, 0.0]))
    with pytest.raises(ValueError, match="input variance"):
        rls_forgetting(phi, y, np.zeros(3), np.eye(3), input_variance=-np.ones((2, 3)))
