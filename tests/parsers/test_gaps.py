"""Gaps of a drive and its signals, bounded in time and number; traces that are thinned keep peaks and gaps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.thin import thin_minmax
from parsers.timebase import MIN_GAP_S, NS, drive_gaps, find_gaps, list_gaps, order


def stamps(rng, rows, gaps):
    step = rng.integers(9_000_000, 11_000_000, rows)
    step[rng.choice(rows, gaps, replace=False)] += rng.integers(300_000_000, 3_000_000_000, gaps)
    return np.cumsum(step)


def by_hand(times):
    """Every pair of spans, one by one."""
    own = {name: find_gaps(stamps, 0, name) for name, stamps in times.items()}
    spans = [[(gap.start_s, gap.end_s) for gap in gaps] for gaps in own.values()]
    common = spans[0]
    for other in spans[1:]:
        common = [(max(a, c), min(b, d)) for a, b in common for c, d in other if min(b, d) > max(a, c)]
    common = [(a, b) for a, b in common if b - a >= MIN_GAP_S]
    single = [
        gap
        for gaps in own.values()
        for gap in gaps
        if not any(a - 1 <= gap.start_s and gap.end_s <= b + 1 for a, b in common)
    ]
    return [(a, b, None) for a, b in common] + [(g.start_s, g.end_s, g.signal) for g in single]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 5))
def test_gaps_equal_those_found_pair_by_pair(seed, signals):
    rng = np.random.default_rng(seed)
    base = stamps(rng, 200, 8)
    times = {
        f"s{i}": np.unique(np.concatenate([base[rng.random(200) > 0.1], base[rng.random(200) > 0.3] + 1]))
        for i in range(signals)
    }
    found = [(g.start_s, g.end_s, g.signal) for g in list_gaps(times, 0, 10**9).gaps]
    assert found == by_hand(times)


def test_no_signals_and_short_signals_have_no_gaps():
    assert drive_gaps({}, 0) == ()
    two = np.array([0, 100 * NS])
    assert drive_gaps({"a": two[:0], "b": two[:1], "c": two}, 0) == ()


def test_of_many_gaps_in_many_signals_the_longest_are_kept():
    rng = np.random.default_rng(1)
    times = {f"s{i}": stamps(rng, 50_000, 5000) for i in range(10)}
    list_gaps(times, 0)
    found = list_gaps(times, 0, most=100)
    every = list_gaps(times, 0, most=10**9)
    assert len(every.gaps) == every.total == found.total > 20_000
    assert len(found.gaps) == 100
    longest = sorted(every.gaps, key=lambda g: (g.signal is not None, g.start_s - g.end_s))[:100]
    assert set(found.gaps) == set(longest)
    assert list(found.gaps) == [gap for gap in every.gaps if gap in set(longest)]


def test_a_drives_gaps_stay_before_longer_ones_of_a_signal():
    regular = np.arange(0, 100 * NS, NS // 10)
    holed = regular[(regular < 50 * NS) | (regular > 51 * NS)]
    late = holed[(holed < 10 * NS) | (holed > 30 * NS)]
    (gap,) = list_gaps({"speed": holed, "roll": late}, 0, most=1).gaps
    assert (gap.signal, round(gap.start_s, 1)) == (None, 49.9)


def test_a_clock_that_was_set_many_times_in_a_long_log_rises():
    rng = np.random.default_rng(2)
    runs = [
        np.arange(4000, dtype=np.int64) * NS // 100 + int(rng.integers(0, 10**6)) * NS for _ in range(200)
    ]
    time_ns = np.concatenate(runs)
    ordered = order(time_ns)
    assert bool((np.diff(ordered.time_ns) > 0).all())
    assert len(ordered.rows) + ordered.duplicates + ordered.lost == len(time_ns)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 400), st.integers(2, 60))
def test_thinning_keeps_the_ends_the_extremes_and_the_order(seed, rows, points):
    rng = np.random.default_rng(seed)
    time_s = np.cumsum(rng.choice([0.01, 0.011, 5.0], rows, p=[0.5, 0.4, 0.1]))
    values = rng.normal(size=rows)
    t, v = thin_minmax(time_s, values, points)
    assert len(t) <= 4 * points + 4
    assert bool((np.diff(t) > 0).all())
    assert (t[0], t[-1]) == (time_s[0], time_s[-1])
    drawn = np.isfinite(v)
    assert (v[drawn].min(), v[drawn].max()) == (values.min(), values.max())
    assert set(zip(t[drawn], v[drawn], strict=True)) <= set(zip(time_s, values, strict=True))


def test_a_gap_is_drawn_where_it_is():
    time_s = np.concatenate([np.arange(1000) / 100, 20 + np.arange(1000) / 100])
    t, v = thin_minmax(time_s, np.sin(time_s), 50)
    (hole,) = np.flatnonzero(np.isnan(v))
    assert (t[hole - 1], t[hole + 1]) == (time_s[999], time_s[1000])


def test_more_gaps_than_points_still_reach_the_end():
    step = np.full(5000, 0.01)
    step[::10] = np.linspace(1, 2, 500)
    time_s = np.cumsum(step)
    t, v = thin_minmax(time_s, np.arange(5000.0), 100)
    assert len(t) <= 404
    assert t[-1] == time_s[-1]
    assert int(np.isnan(v).sum()) == 100
    shown = [b - a for (a, b), hole in zip(pairwise(t), np.isnan(v[1:]), strict=True) if hole]
    # half of each gap lies before the break: only the longest are shown
    assert min(shown) == pytest.approx(0.9, abs=0.02)
