"""An error of the data, put into a posterior that holds a prior: as if the data had had it, whatever the prior's width."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map.answers import Coefficients
from pipelines.estimators.roll_map.posterior import pure_likelihood, with_discrepancy
from pipelines.estimators.roll_map.tyre_share import (
    BANKED,
    BANKED_LAG_S,
    BANKED_STD,
    gain_alone,
    off_banked_roads,
)

NAMES = ("a", "b", "c", "rate_gain")
PRIOR_MEAN, PRIOR_STD = np.array([110.0, 6.0, 0.8, 1.2]), np.array([80.0, 6.0, 0.6, 0.15])


def _posterior(mean: np.ndarray, covariance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Data N(mean, covariance) with the weak priors."""
    information, weak = np.linalg.inv(covariance), 1 / PRIOR_STD**2
    after = np.linalg.inv(information + np.diag(weak))
    return after @ (information @ mean + weak * PRIOR_MEAN), after


def _data(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    root = rng.standard_normal((4, 4)) * np.array([4.0, 0.5, 0.08, 0.03])[:, None]
    return np.array([90.0, 7.0, 0.7, 1.3]), root @ root.T + np.diag([1.0, 0.01, 1e-4, 1e-4])


@pytest.mark.parametrize("size", [0.0, 0.02, 0.15, 3.0])
@pytest.mark.parametrize("columns", [1, 2])
def test_it_is_the_posterior_of_data_with_that_error(size: float, columns: int) -> None:
    rng = np.random.default_rng(7)
    mean, covariance = _data(rng)
    error = size * rng.standard_normal((4, columns)) * np.array([5.0, 0.4, 0.05, 1.0])[:, None]
    found = with_discrepancy(*_posterior(mean, covariance), PRIOR_MEAN, PRIOR_STD, error)
    right = _posterior(mean, covariance + error @ error.T)
    np.testing.assert_allclose(found[0], right[0], rtol=1e-6)
    np.testing.assert_allclose(found[1], right[1], rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("banked_share", [0.0, 0.5, 1.0])
def test_the_gain_on_flat_ground_is_the_data_s(banked_share: float) -> None:
    rng = np.random.default_rng(8)
    mean, covariance = _data(rng)
    post, spread = _posterior(mean, covariance)
    seen = off_banked_roads(Coefficients(NAMES, post, spread, PRIOR_MEAN, PRIOR_STD), banked_share)
    matrix, linear = pure_likelihood(seen.mean, seen.covariance, seen.prior_mean, seen.prior_std)
    told = np.linalg.inv(matrix)
    flat = 1 - BANKED * banked_share
    assert (told @ linear)[3] == pytest.approx(mean[3] / flat, rel=1e-4)
    own = covariance[3, 3] / flat**2 + (BANKED_STD * banked_share * post[3] / flat) ** 2
    assert told[3, 3] == pytest.approx(own, rel=1e-3)


def test_a_gain_as_unsure_as_its_prior_is_no_wild_figure() -> None:
    # before, the prior taken out of 0.149 left 8.2, where the data say 1.3 +- 0.04
    data = np.diag([4.0, 0.1, 0.01, 0.04**2])
    post, spread = _posterior(np.array([90.0, 7.0, 0.7, 1.3]), data)
    gain, variance = gain_alone(
        off_banked_roads(Coefficients(NAMES, post, spread, PRIOR_MEAN, PRIOR_STD), 0.95)
    )
    assert gain == pytest.approx(1.3 / (1 - 0.95 * BANKED), rel=1e-3)
    assert np.sqrt(variance) == pytest.approx(
        np.hypot(0.04, 0.95 * BANKED_STD * 1.3) / (1 - 0.95 * BANKED), rel=0.1
    )
    nothing = Coefficients(NAMES, PRIOR_MEAN, np.diag(PRIOR_STD**2), PRIOR_MEAN, PRIOR_STD)
    assert gain_alone(nothing)[1] == np.inf


@pytest.mark.parametrize("banked_share", [0.0, 0.7])
def test_bends_of_roads_leave_the_damping_as_unsure_as_a_delay(banked_share: float) -> None:
    post, spread = _posterior(np.array([90.0, 7.0, 0.7, 1.3]), np.diag([4.0, 0.1, 0.01, 0.04**2]))
    seen = off_banked_roads(Coefficients(NAMES, post, spread, PRIOR_MEAN, PRIOR_STD), banked_share)
    matrix, linear = pure_likelihood(seen.mean, seen.covariance, seen.prior_mean, seen.prior_std)
    told = np.linalg.inv(matrix)
    assert (told @ linear)[1] == pytest.approx(7.0, abs=0.01)
    assert told[1, 1] == pytest.approx(0.1 + (BANKED_LAG_S * banked_share * post[0]) ** 2, rel=0.01)
