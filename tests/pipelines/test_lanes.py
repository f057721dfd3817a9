"""Functions for vector instructions against numpy's, and the draws against their distribution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from parsers.jit import kernel
from pipelines.filters.lanes import LANES, LOWEST, RandomState, exp, log, random_state, two_normals
from tests.pipelines.plain_particles import PlainLanes


@kernel
def _exp(x: np.ndarray, out: np.ndarray) -> None:
    for i in range(x.size):
        out[i] = exp(x[i])


@kernel
def _log(x: np.ndarray, out: np.ndarray) -> None:
    for i in range(x.size):
        out[i] = log(x[i])


@kernel
def _normals(state: RandomState, out: np.ndarray) -> None:
    for k in range(out.shape[0]):
        for i in range(LANES):
            out[k, 0, i], out[k, 1, i] = two_normals(state, i)


def test_exp_is_good_to_a_unit_in_the_last_place() -> None:
    rng = np.random.default_rng(0)
    x = np.concatenate(
        (rng.uniform(LOWEST, 709, 20_000), rng.normal(size=20_000), [0.0, 1.0, -1e-300, LOWEST])
    )
    out = np.empty_like(x)
    _exp(x, out)
    np.testing.assert_allclose(out, np.exp(x), rtol=4.5e-16)
    _exp(np.array([-1e4, -np.inf]), out)
    np.testing.assert_allclose(out[:2], np.exp(LOWEST), rtol=4.5e-16)


def test_log_is_good_to_a_unit_in_the_last_place() -> None:
    rng = np.random.default_rng(1)
    x = np.concatenate(
        (
            np.exp(rng.uniform(-700, 700, 20_000)),
            rng.uniform(0.3, 3.0, 20_000),
            1 + 1e-12 * rng.normal(size=100),
            [1.0, np.sqrt(0.5), 2.0],
        )
    )
    out = np.empty_like(x)
    _log(x, out)
    np.testing.assert_allclose(out, np.log(x), rtol=4.5e-16)


def test_draws_are_those_of_the_plain_generator_and_standard_normal() -> None:
    state, plain = random_state(np.random.default_rng(7)), PlainLanes(np.random.default_rng(7))
    few = np.empty((50, 2, LANES))
    _normals(state, few)
    np.testing.assert_allclose(few, [plain.two_normals() for _ in range(50)], atol=1e-13)
    many = np.empty((8000, 2, LANES))
    _normals(state, many)
    assert stats.kstest(many.ravel(), "norm").pvalue > 1e-3
    for power, moment in ((1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0)):
        spread = np.sqrt(stats.norm().moment(2 * power) / many.size)
        assert np.mean(many**power) == pytest.approx(moment, abs=4.5 * spread)
    # of one lane from time to time, of lanes side by side, and of a pair
    for one, two in ((many[1:], many[:-1]), (many[..., 1:], many[..., :-1]), (many[:, 0], many[:, 1])):
        assert np.mean(one * two) == pytest.approx(0.0, abs=4.5 / np.sqrt(one.size))
        assert np.mean(one**2 * two**2) == pytest.approx(1.0, abs=4.5 * np.sqrt(8 / one.size))
