"""Student's tails on an answer: known quantiles, and draws that keep their 95 % interval and skewness."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from pipelines.joint.tails import (
    FREEDOM,
    FREEDOM_OF,
    density,
    freedom_of,
    share_below,
    stretched,
    told_with_tails,
)
from pipelines.parameters import PARAMETERS
from pipelines.results import ParameterEstimate

OUTER_Z = 1.959964
SCALE = OUTER_Z / student.ppf(0.975, FREEDOM)


def test_the_outer_interval_is_a_normal_ones_and_the_inner_are_narrower() -> None:
    z = np.linspace(-6, 6, 49)
    assert share_below(z) == pytest.approx(student.cdf(z / SCALE, FREEDOM))
    assert density(z) == pytest.approx(student.pdf(z / SCALE, FREEDOM) / SCALE)
    reach = np.array([0.523, 1.082, OUTER_Z])
    assert share_below(reach) - share_below(-reach) == pytest.approx([0.5, 0.8, 0.95], abs=5e-4)


def test_some_parameters_have_tails_of_their_own_and_the_same_outer_interval() -> None:
    assert set(FREEDOM_OF) <= set(PARAMETERS)
    assert freedom_of("mass_kg") == FREEDOM
    few = freedom_of("roll_arm_m")
    assert few < FREEDOM < freedom_of("corner_mass_rl_kg")
    z = np.linspace(-6, 6, 49)
    scale = OUTER_Z / student.ppf(0.975, few)
    assert share_below(z, few) == pytest.approx(student.cdf(z / scale, few))
    assert density(z, few) == pytest.approx(student.pdf(z / scale, few) / scale)
    draws = np.sort(np.random.default_rng(3).normal(5.0, 2.0, 40_000))
    shares = np.array([0.025, 0.25, 0.75, 0.975])
    exact = 5.0 + 2.0 * scale * student.ppf(shares, few)
    assert np.quantile(stretched(draws, 5.0, few), shares) == pytest.approx(exact, abs=0.06)


@pytest.mark.parametrize("count", [400, 4000, 40_000])
def test_normal_draws_become_students(count: int) -> None:
    draws = np.sort(np.random.default_rng(3).normal(5.0, 2.0, count))
    moved = stretched(draws, 5.0)
    assert np.all(np.diff(moved) >= 0)
    assert float(moved.mean()) == pytest.approx(float(draws.mean()), abs=1e-9)
    shares = np.array([0.025, 0.1, 0.25, 0.5, 0.75, 0.9, 0.975])
    exact = 5.0 + 2.0 * SCALE * student.ppf(shares, FREEDOM)
    assert np.quantile(moved, shares) == pytest.approx(exact, abs=0.03 + 6.0 / math.sqrt(count))


def test_what_is_skew_stays_so() -> None:
    draws = np.sort(np.random.default_rng(4).gamma(2.0, 1.0, 20_000))
    moved = stretched(draws, float(draws.mean()))
    below, above = np.quantile(moved, (0.05, 0.95)) - draws.mean()
    assert above > 1.3 * -below


def test_one_estimators_answer_keeps_its_95_percent_interval_and_draws_in_the_others() -> None:
    entry = ParameterEstimate("roll_gradient_degpg", 4.0, 0.1, 3.8, 4.2, "identified", "seen")
    told = told_with_tails(entry)
    assert (told.interval(0.95), told.std) == ((3.8, 4.2), 0.1)
    for level, reach in ((0.5, 0.4304), (0.8, 0.9487)):
        assert told.interval(level) == pytest.approx(
            (4 - reach * 0.2 / OUTER_Z, 4 + reach * 0.2 / OUTER_Z), abs=1e-4
        )
    # intervals of its own draws, skew ones: each end by the same share
    skew = replace(entry, inner=((3.98, 4.08), (3.9, 4.15)))
    (low, high), _ = told_with_tails(skew).inner
    assert (4 - low) / (high - 4) == pytest.approx(0.02 / 0.08)
    assert high - low == pytest.approx(0.1 * 0.4304 / 0.67449, abs=1e-4)
    nothing = ParameterEstimate("mass_kg", None, None, None, None, "not_identifiable", "no")
    assert told_with_tails(nothing) is nothing
