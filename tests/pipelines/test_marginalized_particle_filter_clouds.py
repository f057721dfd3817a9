"""What several clouds say together, and what particles tell of the coefficients that the log can see."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.marginalized_particle_filter.clouds import pooled_spread
from pipelines.estimators.marginalized_particle_filter.coefficients import moments_of, pooled, wander
from pipelines.estimators.marginalized_particle_filter.inputs import spread_over_time
from pipelines.filters.marginalized_particle.records import Cloud

MASS, INERTIA, SENSOR = 1800.0, 500.0, 0.4


def cloud(theta: np.ndarray, weights: np.ndarray | None = None) -> Cloud:
    """K, D, h with one mass, inertia and sensor height."""
    rest = np.tile([MASS, INERTIA, SENSOR], (len(theta), 1))
    count = len(theta)
    return Cloud(np.column_stack((theta, rest)), np.full(count, 1 / count) if weights is None else weights)


def test_spread_of_two_clouds_by_hand() -> None:
    means, stds = np.array([[1.0, 10.0], [3.0, 10.0]]), np.array([[1.0, 2.0], [2.0, 2.0]])
    mean, std = pooled_spread(means, stds)
    np.testing.assert_allclose(mean, [2.0, 10.0])
    np.testing.assert_allclose(std, [np.sqrt(2.5 + 3.0), 2.0])
    drives = pooled_spread(np.array([means, 2 * means]), np.array([stds, 2 * stds]))
    np.testing.assert_allclose(drives[1], [std, 2 * std])


def test_one_cloud_is_refused() -> None:
    with pytest.raises(ValueError, match="at least two clouds"):
        pooled_spread(np.zeros((1, 3)), np.ones((1, 3)))


def test_joined_clouds_are_honest_where_each_has_lost_its_outliers() -> None:
    """A posterior N(0, 1) seen by clouds of spread 0.6 whose means chance has moved by the rest."""
    rng = np.random.default_rng(0)
    between = 1 - 0.6**2
    truth = rng.standard_normal(4000)
    means = np.sqrt(between) * rng.standard_normal((4000, 4, 1))
    mean, std = pooled_spread(means, np.full(means.shape, 0.6))
    error = np.abs(means[:, 0, 0] - truth)
    own, honest = np.mean(error < 1.96 * 0.6), np.mean(np.abs(mean[:, 0] - truth) < 1.96 * std[:, 0])
    assert own < 0.7
    # what parts four clouds is known to 40 % only: 0.92 where it were 0.95 by many
    assert 0.90 < honest < 0.97


def test_coefficients_of_one_particle_and_of_its_mirror_image() -> None:
    theta = np.array([65_000.0, 5_500.0, 0.74])
    mirror = theta * INERTIA / (MASS * theta[2] ** 2)
    moment = MASS * theta[2]
    expected = [theta[0] / moment, theta[1] / moment, INERTIA / moment + theta[2] - SENSOR]
    for one in (theta, mirror):
        mean, covariance = moments_of(cloud(one[None]))
        np.testing.assert_allclose(mean, expected, rtol=1e-12)
        np.testing.assert_allclose(covariance, 0.0, atol=1e-18)


def test_weighted_moments_equal_numpy_and_pooling_adds_what_parts_the_clouds() -> None:
    rng = np.random.default_rng(1)
    theta = np.array([65_000.0, 5_500.0, 0.74]) * (1 + 0.05 * rng.standard_normal((50, 3)))
    weights = rng.random(50)
    moment = MASS * theta[:, 2]
    table = np.array([theta[:, 0] / moment, theta[:, 1] / moment, INERTIA / moment + theta[:, 2] - SENSOR])
    mean, covariance = moments_of(cloud(theta, weights))
    np.testing.assert_allclose(mean, np.average(table, axis=1, weights=weights))
    np.testing.assert_allclose(covariance, np.cov(table, aweights=weights, ddof=0))
    alone = pooled([cloud(theta, weights)])
    twice = pooled([cloud(theta, weights)] * 2)
    np.testing.assert_allclose(alone[1], covariance)
    np.testing.assert_allclose(twice[1], covariance)
    apart = pooled([cloud(theta), cloud(1.1 * theta)])
    assert (np.diag(apart[1])[:2] >= 0.99 * np.diag(moments_of(cloud(theta))[1])[:2]).all()
    assert apart[1][2, 2] > moments_of(cloud(theta))[1][2, 2]


def test_wander_is_the_mean_square_from_the_last_value() -> None:
    means = np.array([[9.0, 0, 0], [1.0, 0, 0], [3.0, 0, 0]])
    np.testing.assert_allclose(wander(means, np.array([2.0, 0, 0])), np.diag([1.0, 0, 0]))


def test_spread_over_time_of_white_of_correlated_and_of_loud_noise() -> None:
    rng = np.random.default_rng(2)
    white = rng.standard_normal(20_000)
    assert spread_over_time(white, 0.05) < 1.3
    assert spread_over_time(2 * white, 0.05) == pytest.approx(4.0, rel=0.3)
    keep, slow = 0.8, np.zeros(20_000)
    for k in range(1, len(slow)):
        slow[k] = keep * slow[k - 1] + np.sqrt(1 - keep**2) * white[k]
    # sums of an autoregressive noise vary (1 + ρ) / (1 - ρ) times as much
    assert spread_over_time(slow, 0.05) == pytest.approx(9.0, rel=0.3)
    holes = np.full(40_000, np.nan)
    holes[::2] = slow
    assert spread_over_time(holes, 0.025) == pytest.approx(spread_over_time(slow, 0.05), rel=0.01)
    assert spread_over_time(np.full(100, np.nan), 0.05) == 1.0
