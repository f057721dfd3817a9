"""What a log told of a fit's parameters, the fit's priors divided out: known answers, and nothing that is made up."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.brake_roll.least import Samples, Unknown, fit_least
from pipelines.joint.from_parameters import Told, direct, evidence_of, without_prior
from pipelines.results import FloatArray


def fitted(x: FloatArray, y: FloatArray, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Posterior of y = x theta + unit noise under independent priors."""
    precision = np.array([0.0 if np.isinf(s) else s**-2 for s in std])
    covariance = np.linalg.inv(x.T @ x + np.diag(precision))
    return covariance @ (x.T @ y + precision * mean), np.asarray(covariance)


def joined(told: Told, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What was told with the same priors again."""
    inverse = np.linalg.inv(told.covariance)
    precision = np.array([0.0 if np.isinf(s) else s**-2 for s in std])
    covariance = np.linalg.inv(told.rows.T @ inverse @ told.rows + np.diag(precision))
    return covariance @ (told.rows.T @ inverse @ told.observed + precision * mean), np.asarray(covariance)


@pytest.fixture(name="problem")
def _problem() -> tuple[FloatArray, ...]:
    rng = np.random.default_rng(3)
    x = rng.standard_normal((40, 3)) * np.array([1.0, 50.0, 0.02])
    theta, mean, std = (
        np.array([0.6, 1.3, 900.0]),
        np.array([0.0, 1.2, 850.0]),
        np.array([np.inf, 0.05, 40.0]),
    )
    return x, x @ theta + rng.standard_normal(40), mean, std


def test_division_undoes_the_prior(problem: tuple[FloatArray, ...]) -> None:
    x, y, mean, std = problem
    told = without_prior(*fitted(x, y, mean, std), mean, std, most_prior=1.0 - 1e-9)
    assert told is not None
    information = told.rows.T @ np.linalg.solve(told.covariance, told.rows)
    assert np.allclose(information, x.T @ x, rtol=1e-6)
    assert np.allclose(told.rows.T @ np.linalg.solve(told.covariance, told.observed), x.T @ y, rtol=1e-6)


def test_alone_it_is_plain_least_squares(problem: tuple[FloatArray, ...]) -> None:
    x, y, mean, std = problem
    told = without_prior(*fitted(x, y, mean, std), mean, std, most_prior=1.0 - 1e-9)
    assert told is not None
    flat = np.full(3, np.inf)
    value, covariance = joined(told, mean, flat)
    assert np.allclose(value, np.linalg.lstsq(x, y, rcond=None)[0], rtol=1e-6)
    assert np.allclose(covariance, np.linalg.inv(x.T @ x), rtol=1e-6)


def test_with_the_same_prior_it_is_the_posterior_again(problem: tuple[FloatArray, ...]) -> None:
    x, y, mean, std = problem
    posterior = fitted(x, y, mean, std)
    told = without_prior(*posterior, mean, std, most_prior=1.0 - 1e-9)
    assert told is not None
    value, covariance = joined(told, mean, std)
    assert np.allclose(value, posterior[0], rtol=1e-8)
    assert np.allclose(covariance, posterior[1], rtol=1e-6)


def test_a_parameter_that_the_log_left_to_its_prior_is_left_out(problem: tuple[FloatArray, ...]) -> None:
    x, y, mean, std = problem
    unseen = x.copy()
    unseen[:, 1] *= 1e-6
    told = without_prior(*fitted(unseen, y, mean, std), mean, std)
    assert told is not None
    assert len(told.observed) == 2
    assert np.abs(told.rows[:, 1] * std[1]).max() < 1e-3


def test_nothing_is_told_where_the_posterior_is_wider_than_the_prior() -> None:
    mean, std = np.array([1.0, 2.0]), np.array([0.1, 0.3])
    assert without_prior(mean + 0.05, np.diag((1.4 * std) ** 2), mean, std) is None
    assert without_prior(mean + 0.05, np.diag((0.9 * std) ** 2), mean, std) is None


@pytest.mark.parametrize("seed", range(20))
def test_no_precision_is_made_up_from_a_widened_covariance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((6, 4))
    std = rng.uniform(0.2, 3.0, 4)
    value, covariance = fitted(x, rng.standard_normal(6), np.zeros(4), std)
    # as a sandwich does it: every parameter widened by its own factor
    wide = rng.uniform(1.0, 2.5, 4)
    told = without_prior(value, covariance * np.outer(wide, wide), np.zeros(4), std)
    if told is None:
        return
    assert np.all(np.linalg.eigvalsh(told.covariance) > 0)
    claimed = told.rows.T @ np.linalg.solve(told.covariance, told.rows)
    # never more than the widened posterior holds with its prior
    rest = np.linalg.inv(covariance * np.outer(wide, wide)) - claimed
    assert np.linalg.eigvalsh(rest).min() > -1e-9


def test_a_broken_covariance_is_refused() -> None:
    with pytest.raises(ValueError, match="positive"):
        without_prior(np.zeros(2), np.diag([1.0, 0.0]), np.zeros(2), np.ones(2))
    with pytest.raises(ValueError, match="positive definite"):
        without_prior(np.zeros(2), np.array([[1.0, 2.0], [2.0, 1.0]]), np.zeros(2), np.ones(2))


def test_evidence_predicts_for_one_vehicle_and_for_many() -> None:
    told = direct([3.0, 1.0], np.eye(2))
    relation = evidence_of(
        "pitch", "rear axle load", "title", "source", told, lambda v: [v["a"] * v["b"], v["b"]], ("a", "b")
    )
    one = relation.predict({"a": 2.0, "b": 1.5})
    many = relation.predict({"a": np.array([2.0, 1.0]), "b": np.array([1.5, 4.0])})
    assert one.tolist() == [3.0, 1.5]
    assert many.tolist() == [[3.0, 4.0], [1.5, 4.0]]


@pytest.mark.parametrize(("share", "together"), [(0.3, 0.0), (0.3, 0.035), (0.2, 0.08), (0.1, 0.3)])
def test_what_a_widened_fit_hands_on_is_as_sure_as_it_says(share: float, together: float) -> None:
    """Residuals that hang together widen the log's own share: divided as a wide posterior it was 1.4 to 2.2 times too sure."""
    rng = np.random.default_rng(0)
    count, size = 600, float(np.sqrt(600 * share / (1 - share)))
    off, joint = [], []
    for _ in range(400):
        truth = rng.standard_normal()
        blocks = np.repeat(np.arange(20), 30)
        noise = np.sqrt(1 - together) * rng.standard_normal(count) + np.sqrt(together) * rng.standard_normal(20)[blocks]  # fmt: skip
        samples = Samples(truth + size * noise, np.zeros(count, np.int64), blocks, np.array([size]), np.array([1e-6]))  # fmt: skip
        fit = fit_least(lambda x: np.full(count, x[0]), samples, (Unknown("t", 0.0, 1.0, 1e-4),))
        told = without_prior(fit.values, fit.covariance, np.zeros(1), np.ones(1), white=fit.white)
        assert told is not None, "the log told more than the prior by white noise, whatever widens it"
        seen = told.observed - told.rows[:, 0] * truth
        off.append(float(seen[0] / np.sqrt(told.covariance[0, 0])))
        mean, spread = joined(told, np.zeros(1), np.ones(1))
        joint.append(float((mean[0] - truth) / np.sqrt(spread[0, 0])))
    for z in (off, joint):
        assert 0.85 < float(np.sqrt(np.mean(np.square(z)))) < 1.2


@pytest.mark.parametrize("seed", range(10))
def test_division_of_the_white_posterior_is_never_surer_than_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, std = rng.standard_normal((6, 4)), rng.uniform(0.2, 3.0, 4)
    value, covariance = fitted(x, rng.standard_normal(6), np.zeros(4), std)
    wide = rng.uniform(1.0, 2.5, 4)
    plain = without_prior(value, covariance, np.zeros(4), std)
    told = without_prior(value, covariance * np.outer(wide, wide), np.zeros(4), std, white=covariance)
    assert (plain is None) == (told is None)
    if plain is None or told is None:
        return
    np.testing.assert_allclose(told.observed, plain.observed)
    assert np.linalg.eigvalsh(told.covariance - plain.covariance).min() > -1e-9
    same = without_prior(value, covariance, np.zeros(4), std, white=covariance)
    assert same is not None
    np.testing.assert_allclose(same.covariance, plain.covariance, atol=1e-9)
