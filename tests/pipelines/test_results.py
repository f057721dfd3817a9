"""A parameter's intervals: its own where it tells them, a normal distribution's else."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pipelines.results import ParameterEstimate

NORMAL = ParameterEstimate("mass_kg", 1900.0, 10.0, 1880.4, 1919.6, "identified", "")


def test_intervals_without_their_own_are_those_of_the_spread() -> None:
    assert NORMAL.interval(0.95) == (1880.4, 1919.6)
    assert NORMAL.interval(0.5) == pytest.approx((1900 - 6.745, 1900 + 6.745), abs=1e-3)
    assert NORMAL.interval(0.8) == pytest.approx((1900 - 12.816, 1900 + 12.816), abs=1e-3)


def test_an_answer_tells_its_own() -> None:
    tailed = replace(NORMAL, inner=((1896.0, 1903.0), (1890.0, 1908.0)))
    assert tailed.interval(0.5) == (1896.0, 1903.0)
    assert tailed.interval(0.8) == (1890.0, 1908.0)
    assert tailed.interval(0.95) == NORMAL.interval(0.95)


def test_no_figures_no_interval_and_no_other_levels() -> None:
    nothing = ParameterEstimate("mass_kg", None, None, None, None, "not_identifiable", "")
    assert nothing.interval(0.8) is None
    with pytest.raises(ValueError, match="90 %"):
        NORMAL.interval(0.9)
