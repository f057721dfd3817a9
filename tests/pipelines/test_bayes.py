"""The gPC-Bayesian engine: closed forms of a linear model first, then domains that move, then what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipelines.bayes.priors import Beta, Distribution, Known, Normal, Priors, Uniform
from pipelines.bayes.sequence import Choice, estimate
from pipelines.bayes.surrogate import Domain, box
from pipelines.results import FloatArray

RNG = np.random.default_rng(0)
ROWS = 240
DESIGN = RNG.standard_normal((ROWS, 2)) @ np.array([[1.0, 0.4], [0.0, 0.6]])
TRUE = np.array([3.0, -1.0])
READ = DESIGN @ TRUE + RNG.standard_normal(ROWS)


def linear(intervals: int):
    """Residuals of the linear model, unit noise."""
    edges = np.linspace(0, ROWS, intervals + 1).astype(int)

    def residuals(values: FloatArray, interval: int) -> FloatArray:
        part = slice(edges[interval], edges[interval + 1])
        return READ[part] - values @ DESIGN[part].T

    return residuals


def two(first: Distribution, second: Distribution) -> Priors:
    return Priors((Known("a", first), Known("b", second)))


def run(priors: Priors, residuals, intervals: int = 1, **choice):
    return estimate(priors, residuals, intervals, Choice(**choice), np.random.default_rng(1))


@pytest.mark.parametrize("intervals", [1, 8])
def test_a_linear_model_with_normal_priors_has_its_closed_form(intervals: int) -> None:
    mean, std = np.array([2.5, 0.0]), np.array([0.3, 2.0])
    found = run(two(Normal(mean[0], std[0]), Normal(mean[1], std[1])), linear(intervals), intervals)
    precision = DESIGN.T @ DESIGN + np.diag(1 / std**2)
    covariance = np.linalg.inv(precision)
    expected = covariance @ (DESIGN.T @ READ + mean / std**2)
    posterior = found.posterior
    spread = np.sqrt(np.diag(covariance))
    assert np.all(np.abs(posterior.map_value - expected) < 0.005 * spread)
    assert np.all(np.abs(posterior.mean - expected) < 0.03 * spread)
    np.testing.assert_allclose(posterior.covariance, covariance, rtol=0.04, atol=0.04 * spread.min() ** 2)
    # evidence: z is normal about the prior's mean, up to the residuals' own constant
    whole = np.eye(ROWS) + DESIGN @ np.diag(std**2) @ DESIGN.T
    off = READ - DESIGN @ mean
    log = -0.5 * (off @ np.linalg.solve(whole, off) + np.linalg.slogdet(whole)[1])
    assert posterior.log_evidence == pytest.approx(log, abs=0.03)
    assert found.error < 1e-6
    assert found.refits >= 1
    low, high = posterior.quantiles(np.array([0.025, 0.975]))
    np.testing.assert_allclose(high - low, 2 * 1.96 * spread, rtol=0.05)


def test_intervals_narrow_and_end_where_all_at_once_does() -> None:
    priors = two(Uniform(-10, 10), Uniform(-10, 10))
    once, many = run(priors, linear(1)), run(priors, linear(12), 12)
    assert np.all(np.abs(once.posterior.map_value - many.posterior.map_value) < 1e-4)
    np.testing.assert_allclose(once.posterior.std, many.posterior.std, rtol=0.03)
    widths = np.array([step.std for step in many.steps])
    assert np.all(widths[-1] < 0.5 * widths[0])
    assert np.all(np.diff(widths[:, 0]) < 0.02 * widths[:-1, 0])


def test_a_density_integrates_to_one_and_peaks_at_the_map() -> None:
    found = run(two(Uniform(-10, 10), Uniform(-10, 10)), linear(1))
    grid, density = found.posterior.density(0)
    assert np.trapezoid(density, grid) == pytest.approx(1.0, abs=0.01)
    assert grid[np.argmax(density)] == pytest.approx(
        found.posterior.map_value[0], abs=0.3 * found.posterior.std[0]
    )


def test_a_strongly_curved_model_is_followed_to_its_answer() -> None:
    """A decay over a prior of a factor of 30, of which a surrogate over the prior's support knows little."""
    time = np.linspace(0, 4, 200)
    read = np.exp(-1.7 * time) + 0.001 * np.random.default_rng(2).standard_normal(200)

    def residuals(coordinates: FloatArray, _: int) -> FloatArray:
        return (read - np.exp(-np.exp(coordinates) * time)) / 0.001

    priors = Priors((Known("rate", Uniform(0.3, 10.0), log=True),))
    followed = run(priors, residuals, order=3)
    fixed = run(priors, residuals, order=3, follow=False)
    slope = -time * np.exp(-1.7 * time) / 0.001
    spread = 1 / math.sqrt(slope @ slope)
    assert followed.posterior.map_value[0] == pytest.approx(1.7, abs=4 * spread)
    assert followed.posterior.std[0] == pytest.approx(spread, rel=0.1)
    assert followed.error < 0.1
    assert abs(fixed.posterior.map_value[0] - 1.7) > 5 * spread
    assert math.isnan(fixed.error)


def test_a_prior_far_from_the_truth_gives_way() -> None:
    """The truth lies 10 standard deviations out, beyond the first support."""
    found = run(two(Normal(1.0, 0.2), Normal(0.0, 2.0)), linear(1))
    precision = DESIGN.T @ DESIGN + np.diag([25.0, 0.25])
    expected = np.linalg.solve(precision, DESIGN.T @ READ + np.array([25.0, 0.0]))
    assert np.all(np.abs(found.posterior.map_value - expected) < 0.01 * found.posterior.std)
    assert found.at_edge == ()


def test_a_hard_bound_short_of_the_truth_is_named() -> None:
    found = run(two(Uniform(0.0, 2.0), Uniform(-5, 5)), linear(1))
    assert found.at_edge == ("a",)
    assert found.posterior.map_value[0] == pytest.approx(2.0, abs=1e-6)
    assert np.all(found.posterior.values[:, 0] <= 2.0 + 1e-9)


def test_what_the_data_do_not_show_keeps_its_prior() -> None:
    """Only the sum of both is seen."""
    read = 2.0 + np.random.default_rng(3).standard_normal(50)

    def residuals(values: FloatArray, _: int) -> FloatArray:
        return read - values.sum(axis=1)[:, None] * np.ones(50)

    found = run(two(Normal(1.0, 0.5), Normal(1.0, 0.5)), residuals)
    covariance = found.posterior.covariance
    assert covariance[0, 1] / math.sqrt(covariance[0, 0] * covariance[1, 1]) < -0.9
    assert found.posterior.std[0] == pytest.approx(0.5 * math.sqrt(0.5 + 0.5 / (1 + 2 * 0.25 * 50)), rel=0.04)


def test_many_dimensions_take_random_points() -> None:
    design = np.random.default_rng(4).standard_normal((100, 6))
    read = design @ np.arange(6.0)
    priors = Priors(tuple(Known(str(j), Uniform(-10, 10)) for j in range(6)))
    found = run(priors, lambda v, _: read - v @ design.T, order=2, near_order=2)
    np.testing.assert_allclose(found.posterior.map_value, np.arange(6.0), atol=1e-3)
    np.testing.assert_allclose(
        found.posterior.std, np.sqrt(np.diag(np.linalg.inv(design.T @ design))), rtol=0.15
    )


@pytest.mark.parametrize(
    "prior", [Uniform(2.0, 5.0), Normal(3.0, 0.4), Beta(1.0, 4.0, 2.0, 3.5)], ids=lambda p: type(p).__name__
)
def test_densities_have_their_moments(prior: Distribution) -> None:
    x = np.linspace(-1, 7, 40_001)
    density = np.exp(prior.log_density(x))
    assert np.trapezoid(density, x) == pytest.approx(1.0, abs=1e-3)
    assert np.trapezoid(x * density, x) == pytest.approx(prior.mean, abs=2e-3)
    assert np.trapezoid((x - prior.mean) ** 2 * density, x) == pytest.approx(prior.std**2, rel=2e-3)
    assert prior.reach[0] < prior.mean < prior.reach[1]


def test_domains_go_there_and_back() -> None:
    domain = Domain(np.array([1.0, 2.0]), np.array([[2.0, 0.5], [0.0, 1.0]]))
    xi = np.array([[0.3, -0.7], [1.0, 1.0]])
    np.testing.assert_allclose(domain.into(domain.out(xi)), xi, atol=1e-14)
    np.testing.assert_allclose(box(np.zeros(2), np.ones(2)).out(np.array([[-1.0, 1.0]])), [[0.0, 1.0]])


def test_what_cannot_be_is_refused() -> None:
    for wrong in (
        lambda: Uniform(1, 1), lambda: Normal(0, 0), lambda: Normal(5, 1, 6, 7), lambda: Beta(0, 1, 0, 1),
        lambda: Uniform(0, math.inf), lambda: Priors(()), lambda: Priors((Known("a", Uniform(-1, 1), log=True),)),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=r"\w"):
            wrong()
    priors = two(Uniform(0, 1), Uniform(0, 1))
    with pytest.raises(ValueError, match="no interval"):
        run(priors, linear(1), 0)
    with pytest.raises(FloatingPointError, match="no finite prediction"):
        run(priors, lambda v, _: np.full((len(v), 4), np.inf))
