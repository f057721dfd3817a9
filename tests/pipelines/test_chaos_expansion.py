"""Collocation, coefficients, moments, sensitivities and densities: recovery of what was planted, and known functions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.errors import ExpansionError
from pipelines.chaos.bases import hermite, jacobi, laguerre, legendre
from pipelines.chaos.collocation import collocate, collocate_at, hammersley
from pipelines.chaos.densities import estimate_density
from pipelines.chaos.expansion import Expansion, expand
from pipelines.chaos.space import Space, total_degree

MIXED = Space((legendre(), jacobi(2, 3), hermite()))


def test_hammersley_points_are_the_known_ones() -> None:
    points = hammersley(4, 3)
    assert np.allclose(points[:, 0], [0.125, 0.375, 0.625, 0.875])
    assert np.allclose(points[:, 1], [1 / 2, 1 / 4, 3 / 4, 1 / 8])
    assert np.allclose(points[:, 2], [1 / 3, 2 / 3, 1 / 9, 4 / 9])
    many = hammersley(1000, 5)
    assert many.min() > 0
    assert many.max() < 1
    assert np.abs(many.mean(axis=0) - 0.5).max() < 0.01


def test_the_inverse_is_the_pseudo_inverse_in_both_ways() -> None:
    """A good matrix takes the quick way, a worse one (few points) that by singular values."""
    good = collocate(MIXED, 3)
    poor = collocate(Space((laguerre(), hermite())), 4, worst_condition=1e12)
    assert good.condition < 50 < poor.condition
    for each in (good, poor):
        wanted = np.linalg.pinv(each.matrix)
        assert np.abs(each.inverse - wanted).max() < 1e-10 * np.abs(wanted).max()
        assert each.condition == pytest.approx(np.linalg.cond(each.matrix), rel=1e-8)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from(["hammersley", "random"]), st.integers(0, 4), st.integers(1, 3))
def test_a_polynomial_is_recovered_exactly(seed: int, kind: str, order: int, outputs: int) -> None:
    rng = np.random.default_rng(seed)
    points = collocate(MIXED, order, kind=kind, rng=rng, worst_condition=1e4)  # type: ignore[arg-type]
    planted = Expansion(MIXED, points.indices, rng.standard_normal((len(points.indices), outputs)))
    found = expand(points, planted.evaluate(points.points))
    assert np.abs(found.coefficients - planted.coefficients).max() < 1e-9
    fresh = MIXED.sample(rng, 100)
    wanted = MIXED.matrix(fresh, planted.indices) @ planted.coefficients
    assert np.allclose(planted.evaluate(fresh), wanted, rtol=1e-10, atol=1e-10)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 3))
def test_moments_and_shares_keep_their_rules(seed: int, outputs: int) -> None:
    """Covariance is what Gauss rules integrate; shares lie in order between 0 and 1."""
    rng = np.random.default_rng(seed)
    indices = total_degree(3, 3)
    expansion = Expansion(MIXED, indices, rng.standard_normal((len(indices), outputs)))
    rules = [basis.gauss(5) for basis in MIXED.bases]
    grid = np.stack(np.meshgrid(*[nodes for nodes, _ in rules], indexing="ij"), axis=-1).reshape(-1, 3)
    weight = np.einsum("i,j,k->ijk", *[weights for _, weights in rules]).ravel()
    values = expansion.evaluate(grid)
    mean = weight @ values
    assert np.allclose(expansion.mean, mean, atol=1e-11)
    assert np.allclose(expansion.covariance, ((values - mean).T * weight) @ (values - mean), atol=1e-10)
    assert np.allclose(np.diag(expansion.covariance), expansion.variance)
    assert np.allclose(expansion.std**2, expansion.variance)
    assert np.allclose(np.diag(expansion.correlation), 1)
    first, total = expansion.sobol_first, expansion.sobol_total
    assert (first >= 0).all()
    assert (first <= total + 1e-12).all()
    assert (total <= 1 + 1e-12).all()
    assert (first.sum(axis=0) <= 1 + 1e-12).all()
    assert (total.sum(axis=0) >= 1 - 1e-12).all()


def test_the_ishigami_function_has_its_sobol_indices() -> None:
    a, b = 7.0, 0.1
    space = Space((legendre(),) * 3)
    points = collocate(space, 13)
    x = np.pi * points.points
    expansion = expand(
        points, np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0])
    )
    one = 0.5 * (1 + b * math.pi**4 / 5) ** 2
    two = a * a / 8
    both = 8 * b * b * math.pi**8 / 225
    whole = one + two + both
    assert expansion.mean[0] == pytest.approx(a / 2, rel=1e-4)
    assert expansion.variance[0] == pytest.approx(whole, rel=1e-4)
    assert np.allclose(expansion.sobol_first[:, 0], [one / whole, two / whole, 0], atol=1e-4)
    assert np.allclose(
        expansion.sobol_total[:, 0], [(one + both) / whole, two / whole, both / whole], atol=1e-4
    )


def test_a_smooth_function_converges_with_the_order() -> None:
    """exp of a normal variable: the expansion's coefficients are exp(s²/2) s^k / sqrt(k!)."""
    s = 0.4
    space = Space((hermite(),))
    errors = []
    for order in (2, 4, 6):
        points = collocate(space, order, factor=8)
        found = expand(points, np.exp(s * points.points[:, 0])).coefficients[:, 0]
        exact = [math.exp(s * s / 2) * s**k / math.sqrt(math.factorial(k)) for k in range(order + 1)]
        errors.append(np.abs(found - exact).max())
    assert errors[0] > 4 * errors[1] > 16 * errors[2]
    assert errors[2] < 1e-3


def test_one_variable_alone_has_all_of_the_variance() -> None:
    points = collocate(MIXED, 3)
    expansion = expand(points, np.column_stack((points.points[:, 1] ** 2, np.full(len(points.points), 4.0))))
    assert np.allclose(expansion.sobol_first, [[0, 0], [1, 0], [0, 0]], atol=1e-12)
    assert np.allclose(expansion.sobol_total, expansion.sobol_first, atol=1e-12)
    assert expansion.mean[1] == pytest.approx(4.0)
    # a constant's terms are rounding, not shares
    assert expansion.variance[1] < 1e-24


def test_what_does_not_vary_has_neither_shares_nor_density() -> None:
    flat = Expansion(MIXED, total_degree(3, 1), np.array([[4.0], [0.0], [0.0], [0.0]]))
    assert not flat.sobol_first.any()
    assert not flat.sobol_total.any()
    assert flat.correlation.tolist() == [[1.0]]
    with pytest.raises(ExpansionError, match="does not vary"):
        flat.density(np.random.default_rng(0))


def test_densities_and_quantiles_are_those_of_the_output() -> None:
    space = Space((hermite(), legendre()))
    linear = Expansion(space, total_degree(2, 1), np.array([[5.0, 1.0], [2.0, 0.0], [0.0, 0.5]]))
    rng = np.random.default_rng(1)
    normal = linear.density(rng, output=0)
    exact = np.exp(-0.5 * ((normal.value - 5) / 2) ** 2) / (2 * math.sqrt(2 * math.pi))
    assert np.abs(normal.density - exact).max() < 0.006
    uniform = linear.density(rng, output=1)
    assert uniform.at(np.array([1.0, -3.0, 0.5, 1.5])) == pytest.approx(
        [1 / math.sqrt(3), 0, 0.577, 0.577], abs=0.03
    )
    for each in (normal, uniform):
        assert each.density.sum() * (each.value[1] - each.value[0]) == pytest.approx(1.0, abs=1e-3)
        assert each.density.min() >= 0
    found = linear.quantile((0.025, 0.5, 0.975), rng)
    assert found[:, 0] == pytest.approx([5 - 1.96 * 2, 5, 5 + 1.96 * 2], abs=0.06)
    with pytest.raises(ValueError, match="no output"):
        linear.density(rng, output=2)


def test_the_density_equals_the_plain_kernel_sum() -> None:
    samples = np.random.default_rng(2).gamma(2.0, 3.0, 2000)
    quick = estimate_density(samples)
    some = quick.value[::40]
    plain = np.exp(-0.5 * ((some[:, None] - samples) / quick.width) ** 2).sum(axis=1)
    plain /= len(samples) * quick.width * math.sqrt(2 * math.pi)
    assert np.abs(quick.at(some) - plain).max() < 2e-3 * plain.max()


@pytest.mark.parametrize("samples", [np.array([1.0, np.nan, 2.0]), np.array([1.0, np.inf]), np.ones(50)])
def test_samples_without_a_density_are_refused(samples: np.ndarray) -> None:
    with pytest.raises(ExpansionError):
        estimate_density(samples)


def test_a_bad_random_set_is_drawn_again() -> None:
    space = Space((legendre(),) * 2)
    draws = [
        collocate_at(space, total_degree(2, 2), space.sample(np.random.default_rng(seed), 6)).condition
        for seed in range(40)
    ]
    assert max(draws) > 100
    for seed in np.flatnonzero(np.array(draws) > 30):
        again = collocate(
            space, 2, factor=1, kind="random", rng=np.random.default_rng(int(seed)), worst_condition=30
        )
        assert again.condition <= 30


def test_sets_that_stay_bad_are_refused_with_what_to_do() -> None:
    space = Space((legendre(),) * 2)
    with pytest.raises(ExpansionError, match=r"condition.*more points"):
        collocate(space, 2, factor=1)
    with pytest.raises(ExpansionError, match="condition"):
        collocate(space, 4, factor=1, kind="random", rng=np.random.default_rng(0), worst_condition=2)
    singular = collocate_at(space, total_degree(2, 2), space.quantile(hammersley(6, 2)))
    assert singular.condition > 1e10
    assert np.isfinite(singular.inverse).all()


def test_wrong_requests_are_refused() -> None:
    space = Space((legendre(), laguerre()))
    with pytest.raises(ExpansionError, match="times as many"):
        collocate(space, 2, factor=0.5)
    with pytest.raises(ExpansionError, match="too large"):
        collocate(Space((legendre(),) * 6), 12)
    with pytest.raises(ValueError, match="generator"):
        collocate(space, 2, kind="random")
    with pytest.raises(ValueError, match="hammersley, or random"):
        collocate(space, 2, kind="sobol")  # type: ignore[arg-type]
    with pytest.raises(ExpansionError, match="cannot determine"):
        collocate_at(space, total_degree(2, 2), space.quantile(hammersley(5, 2)))
    with pytest.raises(ExpansionError, match="not finite"):
        collocate_at(space, total_degree(2, 1), np.full((9, 2), np.nan))
    points = collocate(space, 2)
    with pytest.raises(ValueError, match="one a point"):
        expand(points, np.zeros(3))
    values = np.zeros(len(points.points))
    values[:2] = np.nan
    with pytest.raises(ExpansionError, match="2 of 24"):
        expand(points, values)
    with pytest.raises(ValueError, match="one row a term"):
        Expansion(space, points.indices, np.zeros((3, 1)))
