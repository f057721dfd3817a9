"""Algorithm 1: regression against its closed form, expected improvement against integration, the density, the search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.warm_start.density import Box, Density
from pipelines.warm_start.expected_improvement import expected_improvement
from pipelines.warm_start.gaussian_process import Hyper, _slope, condition, fit
from pipelines.warm_start.roll_cost import RollError, roll_features
from pipelines.warm_start.warm_start import (
    PUBLISHED,
    TEMPERED,
    WarmStartSettings,
    drawn_particles,
    grid_particles,
    minimise,
    warm_start,
)
from pipelines.warm_start.weighting import independent_residuals
from tests.pipelines.test_marginalized_particle import NOISE, STEP, THETA, drive

BOX = Box(np.array([5e4, 3e3, 0.55]), np.array([8e4, 1e4, 1.2]))


def covariance(a: np.ndarray, b: np.ndarray, scales: np.ndarray, matern: bool) -> np.ndarray:
    """Correlation one pair after the other."""
    out = np.zeros((len(a), len(b)))
    for i, left in enumerate(a):
        for j, right in enumerate(b):
            r = np.sqrt((((left - right) / scales) ** 2).sum())
            s = np.sqrt(5) * r
            out[i, j] = (1 + s + s * s / 3) * np.exp(-s) if matern else np.exp(-0.5 * r * r)
    return out


@pytest.mark.parametrize("matern", [False, True])
def test_regression_is_the_closed_form(matern: bool) -> None:
    """Given hyperparameters: mean, variance and marginal likelihood of the normal distribution written out."""
    rng = np.random.default_rng(0)
    points, at = rng.random((9, 2)), rng.random((4, 2))
    values = np.sin(5 * points[:, 0]) + points[:, 1]
    scales, noise = np.array([0.4, 0.7]), 0.01
    process = condition(points, values, Hyper(scales, noise, matern))
    inner = covariance(points, points, scales, matern) + noise * np.eye(9)
    across = covariance(at, points, scales, matern)
    inverse, ones = np.linalg.inv(inner), np.ones(9)
    mean = ones @ inverse @ values / (ones @ inverse @ ones)
    variance = (values - mean) @ inverse @ (values - mean) / 9
    found, std = process.predict(at)
    np.testing.assert_allclose(found, mean + across @ inverse @ (values - mean), rtol=1e-8)
    np.testing.assert_allclose(process.means(at), found)
    left = variance * (1 - np.einsum("ij,jk,ik->i", across, inverse, across))
    np.testing.assert_allclose(std**2, left, rtol=1e-6)
    full = variance * inner
    quadratic = (values - mean) @ np.linalg.solve(full, values - mean)
    log = -0.5 * (quadratic + np.linalg.slogdet(full)[1] + 9 * np.log(2 * np.pi))
    assert process.log_likelihood == pytest.approx(log, rel=1e-9)


@pytest.mark.parametrize("matern", [False, True])
def test_the_likelihoods_slope_is_its_difference(matern: bool) -> None:
    rng = np.random.default_rng(1)
    points = rng.random((12, 3))
    values = points[:, 0] ** 2 + np.cos(4 * points[:, 1])
    z = np.log([0.5, 0.8, 1.5, 0.02])

    def log_likelihood(z: np.ndarray) -> float:
        return condition(points, values, Hyper(np.exp(z[:3]), float(np.exp(z[3])), matern)).log_likelihood

    exact = _slope(condition(points, values, Hyper(np.exp(z[:3]), float(np.exp(z[3])), matern)))
    for j in range(4):
        step = np.zeros(4)
        step[j] = 1e-5
        difference = (log_likelihood(z + step) - log_likelihood(z - step)) / 2e-5
        assert exact[j] == pytest.approx(difference, rel=1e-5)


def test_fit_finds_length_scales_of_a_drawn_function() -> None:
    """Values drawn from a process: its likelihood at the fit is not below that at the truth; a dead input goes flat."""
    rng = np.random.default_rng(2)
    points = rng.random((60, 2))
    truth = Hyper(np.array([0.3, 20.0]), 1e-4)
    values = np.linalg.cholesky(
        covariance(points, points, truth.scales, False) + 1e-4 * np.eye(60)
    ) @ rng.standard_normal(60)
    found = fit(points, values, Hyper(np.full(2, 0.5), 1e-3), 2, rng)
    assert found.log_likelihood >= condition(points, values, truth).log_likelihood
    assert found.hyper.scales[0] == pytest.approx(0.3, rel=0.3)
    assert found.hyper.scales[1] > 3.0


def test_expected_improvement_is_the_integral() -> None:
    for mean, std, best in ((0.0, 1.0, 0.0), (2.0, 0.5, 1.0), (-1.0, 2.0, 0.3), (0.2, 0.1, 0.9)):
        places = mean + std * np.linspace(-12, 12, 200_001)
        density = np.exp(-0.5 * ((places - mean) / std) ** 2) / (std * np.sqrt(2 * np.pi))
        integral = np.trapezoid(np.maximum(best - places, 0) * density, places)
        found = expected_improvement(np.array([mean]), np.array([std]), best)
        assert found[0] == pytest.approx(integral, rel=1e-6, abs=1e-10)
    np.testing.assert_array_equal(
        expected_improvement(np.array([1.0, 3.0]), np.zeros(2), 2.0), np.array([1.0, 0.0])
    )


def test_minimise_finds_the_lowest_point() -> None:
    """Branin's function, of which three points are lowest (0.3979), in 50 evaluations."""

    def branin(x: np.ndarray) -> float:
        first = x[1] - 5.1 / (4 * np.pi**2) * x[0] ** 2 + 5 / np.pi * x[0] - 6
        return float(first**2 + 10 * (1 - 1 / (8 * np.pi)) * np.cos(x[0]) + 10)

    box = Box(np.array([-5.0, 0.0]), np.array([10.0, 15.0]))
    settings = WarmStartSettings(iterations=42, first=8, candidates=600)
    history = minimise(branin, box, None, settings, np.random.default_rng(0))
    assert len(history.costs) == 50
    assert box.holds(history.points).all()
    assert branin(history.best) == history.costs.min() < 0.45


def test_density_is_the_kernels_sum_and_draws_follow_it() -> None:
    rng = np.random.default_rng(0)
    box = Box(np.zeros(2), np.array([1.0, 2.0]))
    points, weights = rng.random((15, 2)) * [1.0, 2.0], rng.random(15)
    density = Density(points, weights / weights.sum(), box, 0.2)
    at = np.array([[0.4, 1.1]])
    kernel = density.factor @ density.factor.T
    by_hand = 0.0
    for point, weight in zip(points, density.weights, strict=True):
        off = at[0] - point
        part = np.exp(-0.5 * off @ np.linalg.solve(kernel, off)) / np.sqrt(np.linalg.det(2 * np.pi * kernel))
        by_hand += 0.8 * weight * part
    assert np.exp(density.log_density(at)[0]) == pytest.approx(by_hand + 0.2 / 2.0, rel=1e-9)
    drawn = density.draw(20_000, rng)
    assert box.holds(drawn).all()
    places, value = density.marginal(0)
    assert value.sum() * (places[1] - places[0]) == pytest.approx(1.0)
    inside = density.confidence_box(0.95)
    one = density.draw_dimension(0, 20_000, Box(box.low, box.high), rng)
    assert np.mean((one >= inside.low[0]) & (one <= inside.high[0])) == pytest.approx(0.95, abs=0.01)


def test_weights_make_the_draws_uniform_again() -> None:
    """A warm start is only where to look: weighed, its draws have the box's mean and spread."""
    rng = np.random.default_rng(0)
    box = Box(np.zeros(2), np.ones(2))
    density = Density(np.array([[0.3, 0.4], [0.5, 0.6], [0.4, 0.6], [0.35, 0.3]]), np.full(4, 0.25), box, 0.3)
    started = replace(
        warm_start(lambda x: float(x.sum()), box, None, replace(PUBLISHED, iterations=3), rng),
        density=density,
    )
    points, weights = drawn_particles(started, 40_000, rng)
    mean = weights @ points
    np.testing.assert_allclose(mean, 0.5, atol=0.01)
    np.testing.assert_allclose(np.sqrt(weights @ (points - mean) ** 2), np.sqrt(1 / 12), atol=0.01)


def test_independent_residuals() -> None:
    """White noise is worth what it counts; a first-order process of coefficient a the share (1 - a) / (1 + a)."""
    rng = np.random.default_rng(0)
    white = rng.standard_normal(20_000)
    slow = np.zeros(20_000)
    for k in range(1, 20_000):
        slow[k] = 0.9 * slow[k - 1] + white[k]
    assert independent_residuals(white) == pytest.approx(20_000, rel=0.05)
    assert independent_residuals(slow) == pytest.approx(20_000 * 0.1 / 1.9, rel=0.3)
    assert independent_residuals(np.ones(5)) == 5.0


def roll_error(rng: np.random.Generator, offsets: bool = False) -> RollError:
    """The cost of one drive of the planted vehicle."""
    y, accel = drive(150, rng, offsets=(0.01, 0.0, 0.0) if offsets else (0.0, 0.0, 0.0))
    y[3] = np.nan
    return RollError(
        y,
        accel,
        STEP,
        mass_kg=1800.0,
        roll_inertia_kgm2=500.0,
        scale=(NOISE.roll_rad, NOISE.roll_rate_radps),
        offsets=offsets,
    )


def test_roll_cost_is_lowest_near_the_planted_values() -> None:
    for offsets in (False, True):
        cost = roll_error(np.random.default_rng(0), offsets)
        at_truth = cost(THETA[:3])
        assert at_truth < 1.6 * np.sqrt(2 * 149)
        for j in range(3):
            for factor in (0.9, 1.1):
                moved = THETA[:3].copy()
                moved[j] *= factor
                assert cost(moved) > at_truth
    assert cost(np.array([1e3, 5e3, 0.7])) == np.inf


def test_warm_starts_on_the_roll_hold_the_truth() -> None:
    """As published most of the box stays; tempered little of it; both hold the planted values."""
    rng = np.random.default_rng(5)
    cost = roll_error(rng)
    short = replace(PUBLISHED, iterations=40)
    published = warm_start(cost, BOX, None, short, rng)
    tempered = warm_start(cost, BOX, None, TEMPERED, rng, features=roll_features, power=cost.independent)
    for started in (published, tempered):
        assert started.inside.holds(THETA[None, :3])[0]
    assert 0.4 < published.kept < 0.95
    assert tempered.kept < 0.3
    grid = grid_particles(published, 20, rng)
    assert grid.shape == (8000, 3)
    assert published.inside.holds(grid).all()
    assert len(np.unique(grid[:, 0])) == 20


def test_refusals() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="below a finite high"):
        Box(np.ones(2), np.ones(2))
    with pytest.raises(ValueError, match="outside the box"):
        minimise(lambda x: 0.0, BOX, np.zeros(3), PUBLISHED, rng)
    with pytest.raises(ValueError, match="finite cost"):
        warm_start(lambda x: np.inf, BOX, None, replace(PUBLISHED, iterations=2), rng)
    with pytest.raises(ValueError, match="power"):
        warm_start(lambda x: float(x[0]), BOX, None, replace(TEMPERED, iterations=2), rng)
    with pytest.raises(ValueError, match="finite numbers"):
        RollError(np.zeros((2, 2)), np.full(2, np.nan), 0.01, mass_kg=1.0, roll_inertia_kgm2=1.0)
