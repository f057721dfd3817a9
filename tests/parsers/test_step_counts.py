"""Quantiles of columns that are never in memory whole."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.step_counts import SizeCounts, StepCounts
from parsers.time_figures import SharedFigures, TimeFigures
from parsers.timebase import NS, find_gaps, usual_period_s


@pytest.mark.parametrize("count", [1, 2, 999, 40_000])
def test_the_median_is_exact_where_few_steps_differ(count: int) -> None:
    steps = np.random.default_rng(count).integers(9_990_000, 10_010_000, count) // 1000 * 1000
    held = StepCounts()
    for part in np.array_split(steps, 7):
        held.add(part)
    assert held.median_ns == np.median(steps)
    assert held.resolution_ns == 1


def test_the_median_of_very_many_different_steps_says_how_exact_it_is() -> None:
    steps = np.random.default_rng(1).integers(1, 10**9, 300_000)
    held = StepCounts()
    for part in np.array_split(steps, 11):
        held.add(part)
    assert 1 < held.resolution_ns < 10**9 / 2000
    assert held.median_ns == pytest.approx(np.median(steps), abs=held.resolution_ns)
    assert StepCounts().median_ns == 0.0


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_quantiles_of_sizes(scale: float) -> None:
    sizes = np.abs(np.random.default_rng(2).standard_normal(200_000)) * scale
    sizes[:100] = 0.0
    held = SizeCounts()
    for part in np.array_split(sizes, 5):
        held.add(part)
    for share in (0.1, 0.5, 0.9, 0.999):
        assert held.quantile(share) == pytest.approx(np.quantile(sizes, share), rel=3e-3)
    assert SizeCounts().quantile(0.9) == 0.0


def test_figures_of_stamps_in_parts_equal_those_of_the_whole() -> None:
    rng = np.random.default_rng(3)
    time_ns = np.cumsum(rng.integers(9, 12, 20_000) * 1_000_000)
    time_ns[5000:] += 3 * NS
    time_ns[15_000:] += NS // 2
    figures = TimeFigures(1e7)
    for part in np.array_split(time_ns, 13):
        figures.add(part)
    assert figures.median_ns / NS == usual_period_s(time_ns)
    starts, ends = figures.gaps()
    gaps = find_gaps(time_ns, 0)
    assert [(a / NS, b / NS) for a, b in zip(starts, ends, strict=True)] == [
        (g.start_s, g.end_s) for g in gaps
    ]
    assert (figures.samples, figures.first, figures.last) == (20_000, time_ns[0], time_ns[-1])


def test_of_very_many_gaps_the_longest_stay() -> None:
    steps = np.where(np.arange(200_000) % 3 == 0, NS + np.arange(200_000), 1_000_000)
    figures = TimeFigures(1e6)
    for part in np.array_split(np.cumsum(steps), 50):
        figures.add(part)
    starts, ends = figures.gaps()
    assert len(starts) + figures.dropped == np.count_nonzero(steps[1:] > NS)
    assert (ends - starts).max() == steps.max()


def test_names_that_share_stamps_are_parted_when_they_differ() -> None:
    base = np.arange(0, 1000) * 10
    shared = SharedFigures({"a": None, "b": None})
    for number, part in enumerate(np.array_split(base, 10)):
        other = part[::2] if number == 4 else part
        shared.add(part, {"a": part, "b": other})
    assert shared.of("a").samples == 1000
    assert shared.of("b").samples == 950
    assert (shared.of("a").median_ns, shared.of("b").last) == (10.0, 9990)
