"""What is told from draws that are not normal has the draws' own intervals at every level."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map.answers import from_draws
from pipelines.results import INNER, OUTER

REASONS = {"identified": "told", "weak": "wide", "not_identifiable": "not told"}


def test_intervals_are_those_of_the_draws() -> None:
    rng = np.random.default_rng(3)
    # most of them close together, one in twenty a fifth away: tyres that may be rigid
    values = np.where(rng.random(40_000) < 0.05, 6.0, 5.0) + 0.05 * rng.standard_normal(40_000)
    found = from_draws("roll_gradient_degpg", values, np.full(40_000, 1 / 40_000), None, REASONS, None)
    for level in (*INNER, OUTER):
        interval = found.interval(level)
        assert interval is not None
        assert interval == pytest.approx(np.quantile(values, [0.5 - level / 2, 0.5 + level / 2]), abs=1e-3)
    assert found.std is not None
    half = found.interval(INNER[0])
    assert half is not None
    # a share of the spread, which the few far ones make, would be three times as wide
    assert half[1] - half[0] < 0.5 * 2 * 0.674 * found.std


def test_heavier_draws_count_for_more() -> None:
    values, weight = np.array([5.1, 5.2, 5.3, 5.4]), np.array([0.1, 0.4, 0.4, 0.1])
    found = from_draws(
        "roll_gradient_degpg", np.repeat(values, 500), np.repeat(weight, 500) / 500, None, REASONS, None
    )
    narrow, wide = (found.interval(level) for level in INNER)
    assert narrow is not None
    assert wide is not None
    assert found.low is not None
    assert found.high is not None
    assert found.low < wide[0] <= narrow[0] < narrow[1] <= wide[1] < found.high
