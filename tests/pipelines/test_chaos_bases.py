"""Bases against Gauss rules, their distributions against sampling, index sets against plain Python."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.errors import ExpansionError
from pipelines.chaos.bases import Basis, hermite, jacobi, laguerre, legendre
from pipelines.chaos.expansion import Expansion
from pipelines.chaos.space import MOST_TERMS, Space, plan, term_count, total_degree

BASES = [
    legendre(),
    jacobi(1, 1),
    jacobi(2, 3),
    jacobi(0.5, 0.5),
    jacobi(0.3, 0.7),
    jacobi(1, 5),
    jacobi(40, 2),
    hermite(),
    laguerre(),
    laguerre(0.2),
    laguerre(7.5),
]


def label(basis: Basis) -> str:
    return f"{basis.kind}-{basis.first:g}-{basis.second:g}"


def raw_moment(basis: Basis, power: int) -> float:
    """The expected value of x^power, from the textbooks' formulas."""
    if basis.kind == "hermite":
        return float(math.prod(range(power - 1, 0, -2))) if power % 2 == 0 else 0.0
    if basis.kind == "laguerre":
        return math.prod(basis.first + i for i in range(power))
    a, b = (basis.first, basis.second) if basis.kind == "jacobi" else (1.0, 1.0)

    def unit(k: int) -> float:
        return math.prod((a + i) / (a + b + i) for i in range(k))

    return sum(math.comb(power, k) * 2**k * (-1) ** (power - k) * unit(k) for k in range(power + 1))


@pytest.mark.parametrize("basis", BASES, ids=label)
def test_polynomials_are_orthonormal_under_their_density(basis: Basis) -> None:
    nodes, weights = basis.gauss(25)
    values = basis.evaluate(nodes, 24)
    assert np.abs((values.T * weights) @ values - np.eye(25)).max() < 1e-12


@pytest.mark.parametrize("basis", BASES, ids=label)
def test_gauss_rules_give_the_moments_of_the_distribution(basis: Basis) -> None:
    from scipy import stats

    a, b = basis.first or 1, basis.second or 1
    known = {
        "legendre": stats.uniform(-1, 2),
        "jacobi": stats.beta(a, b, -1, 2),
        "hermite": stats.norm(),
        "laguerre": stats.gamma(a),
    }[basis.kind]
    nodes, weights = basis.gauss(4)
    for power in range(8):
        assert weights @ nodes**power == pytest.approx(raw_moment(basis, power), rel=1e-11, abs=1e-13)
    u = np.linspace(0.001, 0.999, 50)
    assert np.allclose(basis.quantile(u), known.ppf(u), rtol=1e-9, atol=1e-12)
    x = np.linspace(-1.5, 3.0, 200)
    assert np.allclose(basis.density(x), known.pdf(x), rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("basis", BASES, ids=label)
def test_draws_follow_the_distribution(basis: Basis) -> None:
    drawn = np.sort(basis.sample(np.random.default_rng(3), 4000))
    u = np.array([0.1, 0.5, 0.9])
    shares = np.searchsorted(drawn, basis.quantile(u)) / len(drawn)
    assert np.abs(shares - u).max() < 0.03
    low, high = basis.support
    assert low <= drawn[0]
    assert drawn[-1] <= high


def test_first_polynomials_are_the_textbooks() -> None:
    x = np.array([-0.7, 0.1, 0.9])
    assert np.allclose(legendre().evaluate(x, 2).T, [x**0, np.sqrt(3) * x, np.sqrt(5) * (1.5 * x**2 - 0.5)])
    assert np.allclose(hermite().evaluate(x, 3)[:, 3], (x**3 - 3 * x) / math.sqrt(6))
    assert np.allclose(np.abs(laguerre().evaluate(x, 2)[:, 2]), np.abs(x**2 / 2 - 2 * x + 1))
    assert np.allclose(jacobi(1, 1).evaluate(x, 9), legendre().evaluate(x, 9))


def test_the_density_is_nothing_outside_and_at_infinity() -> None:
    far = np.array([-np.inf, -1.1, 1.1, np.inf])
    assert not jacobi(2, 3).density(far).any()
    assert not legendre().density(far).any()
    assert not laguerre(2).density(far[[0, 1, 3]]).any()


@pytest.mark.parametrize("basis", [jacobi(1, 5), hermite(), laguerre(2)], ids=label)
def test_the_polynomials_equal_a_plain_recurrence(basis: Basis) -> None:
    x = basis.sample(np.random.default_rng(0), 5)
    centre, root = basis.recurrence(8)
    got = basis.evaluate(x, 7)
    for i, value in enumerate(x):
        before, now = 0.0, 1.0
        for k in range(7):
            before, now = now, ((value - centre[k]) * now - root[k] * before) / root[k + 1]
            assert got[i, k + 1] == pytest.approx(now, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(("first", "second"), [(0.0, 1.0), (1.0, -2.0), (math.nan, 1.0), (1.0, math.inf)])
def test_shapes_that_no_density_has_are_refused(first: float, second: float) -> None:
    with pytest.raises(ExpansionError, match="shape"):
        jacobi(first, second)


def test_bad_requests_of_a_basis_are_refused() -> None:
    with pytest.raises(ExpansionError, match="shape"):
        laguerre(0)
    with pytest.raises(ExpansionError, match="no family"):
        Basis("chebyshev")  # type: ignore[arg-type]
    with pytest.raises(ExpansionError, match="order"):
        legendre().evaluate(np.zeros(3), -1)
    with pytest.raises(ExpansionError, match="at least one node"):
        legendre().gauss(0)
    with pytest.raises(ExpansionError, match="too large"):
        laguerre().gauss(400)
    with pytest.raises(ExpansionError, match="at least one variable"):
        Space(())


@pytest.mark.parametrize(("d", "order"), [(1, 0), (1, 6), (2, 3), (3, 4), (5, 2), (7, 1), (3, 0)])
def test_index_sets_are_graded_and_complete(d: int, order: int) -> None:
    rows = total_degree(d, order)
    wanted = [row for row in itertools.product(range(order + 1), repeat=d) if sum(row) <= order]
    wanted.sort(key=lambda row: (sum(row), [-power for power in row]))
    assert rows.tolist() == [list(row) for row in wanted]
    assert len(rows) == term_count(d, order)
    if order:
        assert np.array_equal(rows[1 : d + 1], np.eye(d, dtype=int))


def test_large_index_sets_are_made_and_too_large_ones_refused() -> None:
    rows = total_degree(10, 8)
    assert len(rows) == 43758
    assert len(np.unique(rows, axis=0)) == len(rows)
    assert rows.sum(axis=1).max() == 8
    with pytest.raises(ExpansionError, match="lower the order"):
        total_degree(30, 10)
    assert term_count(30, 10) > MOST_TERMS
    for d, order in ((0, 2), (2, -1)):
        with pytest.raises(ExpansionError, match="at least 1 variable"):
            total_degree(d, order)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_any_index_set_multiplies_its_polynomials(data: st.DataObject) -> None:
    """Not only total-degree sets: any order, gaps in the tree, rows twice, constant term or not."""
    d = data.draw(st.integers(1, 4))
    row = st.lists(st.integers(0, 4), min_size=d, max_size=d)
    indices = np.array(data.draw(st.lists(row, min_size=1, max_size=12)))
    count = data.draw(st.sampled_from([1, 2, 63, 64, 65, 130]))
    space = Space(tuple(data.draw(st.lists(st.sampled_from(BASES), min_size=d, max_size=d))))
    points = space.sample(np.random.default_rng(count), count)
    wanted = np.ones((count, len(indices)))
    for j, basis in enumerate(space.bases):
        wanted *= basis.evaluate(points[:, j], 4)[:, indices[:, j]]
    assert np.allclose(space.matrix(points, indices), wanted, rtol=1e-12, atol=1e-12)
    assert plan(indices).levels == np.count_nonzero(indices, axis=1).max()


@pytest.mark.parametrize("count", [255, 256, 257, 600])
def test_blocks_of_points_meet_without_a_seam(count: int) -> None:
    space = Space((legendre(), jacobi(2, 3), hermite(), laguerre(3)))
    indices = total_degree(4, 4)
    rng = np.random.default_rng(count)
    points = space.sample(rng, count)
    wanted = np.ones((count, len(indices)))
    for j, basis in enumerate(space.bases):
        wanted *= basis.evaluate(points[:, j], 4)[:, indices[:, j]]
    assert np.allclose(space.matrix(points, indices), wanted, rtol=1e-12, atol=1e-12)
    coefficients = rng.standard_normal((len(indices), 3))
    values = Expansion(space, indices, coefficients).evaluate(points)
    assert np.allclose(values, wanted @ coefficients, rtol=1e-11, atol=1e-11)


def test_points_and_indices_of_another_space_are_refused() -> None:
    space = Space((legendre(), hermite()))
    with pytest.raises(ValueError, match="rows of 2"):
        space.matrix(np.zeros((3, 1)), total_degree(2, 1))
    with pytest.raises(ValueError, match="rows of 2"):
        space.matrix(np.zeros((3, 2)), total_degree(3, 1))
    with pytest.raises(ValueError, match="at least 0"):
        space.matrix(np.zeros((3, 2)), np.array([[0, -1]]))
    with pytest.raises(ValueError, match="one column"):
        legendre().evaluate(np.zeros((3, 2)), 1)


def test_the_joint_density_integrates_to_one() -> None:
    space = Space((legendre(), jacobi(2, 3)))
    side = (np.arange(200) + 0.5) / 100 - 1
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    assert space.density(grid).sum() * 1e-4 == pytest.approx(1.0, abs=1e-4)
