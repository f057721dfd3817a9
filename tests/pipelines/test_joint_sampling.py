"""Draws from posteriors with known answers: Gaussian, bounded, curved, with two modes."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.joint.sampling.gaussianity import LogDensity
from pipelines.joint.sampling.sample import FAR_OUT, Drawn, no_narrower, not_gaussian, sample
from pipelines.results import FloatArray


def _rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def _gaussian(k: int, informed: int, rng: np.random.Generator) -> tuple[LogDensity, FloatArray, FloatArray]:
    """Linear measurements, some a hundred times sharper than the prior: density, mean, precision."""
    slope = rng.standard_normal((informed, k)) * np.exp(rng.uniform(-1, 4, informed))[:, None]
    seen = slope @ rng.standard_normal(k) + rng.standard_normal(informed)
    precision = np.eye(k) + slope.T @ slope

    def density(u: FloatArray) -> FloatArray:
        return -0.5 * np.sum(u**2, axis=1) - 0.5 * np.sum((u @ slope.T - seen) ** 2, axis=1)

    return density, np.linalg.solve(precision, slope.T @ seen), precision


def _banana(k: int, spread: float, sigma: float) -> tuple[LogDensity, FloatArray]:
    """(1 + spread u0)(1 + spread u1) is known to be 1 ± sigma: density, and covariance at the mode 0."""

    def density(u: FloatArray) -> FloatArray:
        a, b = 1 + spread * u[:, 0], 1 + spread * u[:, 1]
        value = -0.5 * np.sum(u**2, axis=1) - 0.5 * ((a * b - 1) / sigma) ** 2
        return np.where((a > 0) & (b > 0), value, -np.inf)

    slope = np.zeros(k)
    slope[:2] = spread / sigma
    return density, np.linalg.inv(np.eye(k) + np.outer(slope, slope))


def _banana_moments(spread: float, sigma: float) -> tuple[float, float, float]:
    """Mean and standard deviation of u0, covariance with u1: by a sum over a and a b on a fine grid."""
    a = np.linspace(1e-3, 1 + 6 * spread, 4001)[:, None]
    off = np.linspace(-7, 7, 141)[None, :] * sigma
    u, v = (a - 1) / spread, ((1 + off) / a - 1) / spread
    weight = np.exp(-0.5 * (u**2 + v**2 + (off / sigma) ** 2)) / a
    weight /= weight.sum()
    mean = float(np.sum(weight * u))
    std = float(np.sqrt(np.sum(weight * (u - mean) ** 2)))
    return mean, std, float(np.sum(weight * u * v)) - mean**2


def _check_all_directions(drawn: Drawn, mean: FloatArray, precision: FloatArray) -> None:
    """Whitened draws have mean 0 and variance 1 within Monte-Carlo error, on the mean over all directions and at worst."""
    white = (drawn.draws - mean) @ np.linalg.cholesky(precision)
    squares = np.mean(white, axis=0) ** 2 * drawn.effective
    assert np.mean(squares) < 1.8
    assert np.max(squares) < 4.5**2
    assert np.mean(np.var(white, axis=0)) == pytest.approx(1, abs=0.04)
    assert np.all(np.abs(np.var(white, axis=0) - 1) < 5.5 * np.sqrt(2 / drawn.effective))


def test_not_gaussian_is_nought_on_a_gaussian_and_large_on_a_banana() -> None:
    density, mean, precision = _gaussian(80, 25, _rng(1))
    covariance = np.linalg.inv(precision)
    gradient = _rng(2).standard_normal((5, 80))
    along = gradient @ covariance / np.sqrt(np.einsum("dk,kl,dl->d", gradient, covariance, gradient))[:, None]
    calls: list[int] = []

    def counted(u: FloatArray) -> FloatArray:
        calls.append(len(u))
        return density(u)

    assert not_gaussian(counted, mean, covariance, along) < 1e-9 * abs(float(density(mean[None])[0]))
    assert len(calls) == 1
    curved, at_mode = _banana(60, 0.3, 0.03)
    ridge = at_mode @ np.eye(60)[0] / np.sqrt(at_mode[0, 0])
    assert not_gaussian(curved, np.zeros(60), at_mode, ridge) > 5
    bounded = lambda u: np.where(u[:, 0] > -1.5, -0.5 * np.sum(u**2, axis=1), -np.inf)  # noqa: E731
    assert not_gaussian(bounded, np.zeros(3), np.eye(3), np.eye(3)) == np.inf


def test_a_gaussian_of_80_unknowns_comes_back() -> None:
    density, mean, precision = _gaussian(80, 20, _rng(3))
    drawn = sample(density, [(mean, np.linalg.inv(precision))], _rng())
    assert drawn.draws.shape == (2000, 80)
    assert 700 < drawn.effective <= 2000
    assert "sequential Monte Carlo" in drawn.text
    _check_all_directions(drawn, mean, precision)


def test_modes_that_are_off_and_too_narrow_do_no_harm() -> None:
    density, mean, precision = _gaussian(60, 12, _rng(4))
    covariance = np.linalg.inv(precision)
    off = mean + 1.0 * np.linalg.cholesky(covariance) @ _rng(5).standard_normal(60) / np.sqrt(60)
    drawn = sample(density, [(off, covariance / 1.3)], _rng(6))
    _check_all_directions(drawn, mean, precision)
    spread = np.std(drawn.draws[:, 0])
    assert spread == pytest.approx(np.sqrt(covariance[0, 0]), rel=0.15)


def test_bounds_cut_the_density() -> None:
    def density(u: FloatArray) -> FloatArray:
        return np.where((u[:, 0] > 0) & (u[:, 1] > 1), -0.5 * np.sum(u**2, axis=1), -np.inf)

    mode = np.zeros(60)
    mode[:2] = 0.1, 1.1
    drawn = sample(density, [(mode, np.eye(60))], _rng(7))
    first, second = drawn.draws[:, 0], drawn.draws[:, 1]
    assert first.min() > 0
    assert second.min() > 1
    # the truncated normal's means: density over tail probability
    assert np.mean(first) == pytest.approx(0.79788, abs=4 * 0.603 / np.sqrt(drawn.effective))
    assert np.mean(second) == pytest.approx(1.52514, abs=4 * 0.446 / np.sqrt(drawn.effective))


def test_a_curved_ridge_is_followed_to_its_ends() -> None:
    density, covariance = _banana(60, 0.3, 0.03)
    mean, std, together = _banana_moments(0.3, 0.03)
    drawn = sample(density, [(np.zeros(60), covariance)], _rng(8))
    for column in drawn.draws[:, :2].T:
        assert np.mean(column) == pytest.approx(mean, abs=4 * std / np.sqrt(drawn.effective))
        assert np.std(column) == pytest.approx(std, rel=0.1)
    assert np.cov(drawn.draws[:, :2].T)[0, 1] == pytest.approx(together, rel=0.2)
    # what nothing was learned of stays as known before
    assert np.mean(np.var(drawn.draws[:, 2:], axis=0)) == pytest.approx(1, abs=0.03)


def test_two_modes_get_their_weights() -> None:
    apart = np.zeros(60)
    apart[0] = 6.0

    def density(u: FloatArray) -> FloatArray:
        near, far = (-0.5 * np.sum((u - m) ** 2, axis=1) for m in (0.0, apart))
        return np.logaddexp(np.log(0.8) + near, np.log(0.2) + far)

    drawn = sample(density, [(apart, 0.8 * np.eye(60)), (np.zeros(60), np.eye(60))], _rng(9))
    share = np.mean(drawn.draws[:, 0] > 3)
    assert share == pytest.approx(0.2, abs=4 * 0.4 / np.sqrt(drawn.effective))
    assert "2 modes" in drawn.text


def _mirror(k: int, height: float, inertia: float, sigma: float) -> LogDensity:
    """K/J, D/J and m h/J with J = I + m h² (Berntorp's (1)), known to `sigma`; u0, u1, u2: K, D, h with wide priors."""
    mass = 1800.0

    def ratios(stiffness: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        return np.array([stiffness, damping, mass * h]) / (inertia + mass * h**2)

    truth = ratios(np.array(65e3), np.array(5.5e3), np.array(height))

    def density(u: FloatArray) -> FloatArray:
        found = ratios(60e3 * (1 + 0.6 * u[:, 0]), 5e3 * (1 + 0.6 * u[:, 1]), 0.55 + 0.15 * u[:, 2])
        misfit = (found / truth[:, None] - 1) / sigma
        return -0.5 * np.sum(u**2, axis=1) - 0.5 * np.sum(misfit**2, axis=0)

    return density


def test_the_mirror_solution_is_found_and_weighed() -> None:
    k, height, inertia = 40, 0.70, 450.0
    mirror = inertia / (1800 * height)
    density = _mirror(k, height, inertia, 0.02)
    mode = np.zeros(k)
    mode[:3] = (65 / 60 - 1) / 0.6, (5.5 / 5 - 1) / 0.6, (height - 0.55) / 0.15
    step = 1e-3 * np.eye(k)
    curve = (density(mode + step) + density(mode - step) - 2 * density(mode[None])) / 1e-6
    drawn = sample(density, [(mode, np.diag(-1 / curve))], _rng(10))
    h = 0.55 + 0.15 * drawn.draws[:, 2]
    low = h < np.sqrt(inertia / 1800)
    # reference: three unknowns only, by importance sampling from the prior
    u = _rng(11).standard_normal((400_000, 3))
    weight = np.exp(density(np.hstack([u, np.zeros((len(u), k - 3))])) + 0.5 * np.sum(u**2, axis=1))
    below = 0.55 + 0.15 * u[:, 2] < np.sqrt(inertia / 1800)
    truth = np.sum(weight * below) / np.sum(weight)
    count = np.sum(weight) ** 2 / np.sum(weight**2)
    error = np.hypot(0.5 / np.sqrt(drawn.effective), 0.5 / np.sqrt(count))
    assert 0.05 < truth < 0.95
    assert np.mean(low) == pytest.approx(truth, abs=4 * error)
    assert np.median(h[low]) == pytest.approx(mirror, abs=0.03)
    assert np.median(h[~low]) == pytest.approx(height, abs=0.03)


def test_the_seed_decides() -> None:
    density, covariance = _banana(20, 0.3, 0.05)
    modes = [(np.zeros(20), covariance)]
    one, same, other = (sample(density, modes, _rng(seed), 500) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.draws, same.draws)
    assert one.text == same.text
    assert one.draws.shape == (500, 20)
    assert not np.array_equal(one.draws, other.draws)


def test_a_density_of_nought_is_said() -> None:
    drawn = sample(lambda u: np.full(len(u), -np.inf), [(np.zeros(4), np.eye(4))], _rng())
    assert drawn.effective == 0
    assert "not sampled" in drawn.text


def test_draws_from_far_outside_are_no_surer_than_the_curvature() -> None:
    """A start at a millionth of the likelihood is coarse; one at a hundredth is not. Stretched about the mean, never shrunk."""
    draws = np.zeros((3, 2))
    assert Drawn(draws, 300.0, "", 0.02 * FAR_OUT).coarse
    assert not Drawn(draws, 300.0, "", 1e-2).coarse
    column = _rng().standard_normal(500)
    wide = no_narrower(column, 3.0)
    assert wide.std() == pytest.approx(3.0)
    assert wide.mean() == pytest.approx(column.mean())
    assert no_narrower(column, 0.5) is column
