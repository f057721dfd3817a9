"""Thinning keeps peaks and gaps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipelines.results import Scatter, Trace
from reports.figures.thin import break_at, cells, jumps, keep, keep_rows, lonely, merge_spans, spread_points
from reports.reduce import reduce_scatter, reduce_trace


def wave(size: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.uniform(0.001, 0.02, size)), rng.normal(size=size)


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 20_000), st.integers(0, 2**31), st.integers(5, 300))
def test_every_bucket_keeps_its_lowest_and_highest(size: int, seed: int, buckets: int) -> None:
    time, values = wave(size, seed)
    index = keep(time, values, buckets)
    assert index.size <= 3 * buckets + 2
    assert (np.diff(index) > 0).all()
    scale = buckets / (time[-1] - time[0]) if size > 1 else 0.0
    bucket = np.clip((time - time[0]) * scale, 0, buckets - 1).astype(int)
    for b in np.unique(bucket)[:50]:
        inside = values[bucket == b]
        kept = values[index[bucket[index] == b]]
        assert kept.min() == inside.min()
        assert kept.max() == inside.max()


def test_a_single_spike_survives() -> None:
    time = np.arange(180_000) / 100
    values = np.sin(time)
    values[123_457] = 50.0
    values[60_001] = -40.0
    index = keep(time, values, 300)
    assert values[index].max() == 50.0
    assert values[index].min() == -40.0


def test_a_missing_sample_still_breaks_the_line() -> None:
    time = np.arange(100_000) / 100
    values = np.sin(time)
    values[40_000] = np.nan
    values[70_000:75_000] = np.nan
    kept = keep(time, values, 200)
    assert 40_000 in kept
    assert np.isnan(values[kept][(kept >= 70_000) & (kept < 75_000)]).all()
    assert not np.isnan(values[kept][kept < 40_000]).any()


def test_a_peak_between_two_missing_samples_is_kept_and_drawn_as_a_dot() -> None:
    time = np.arange(10_000) / 100
    values = np.zeros(10_000)
    values[4_999:5_002] = [np.nan, 9.0, np.nan]
    kept = values[keep(time, values, 3_000)]
    assert kept[lonely(kept)].tolist() == [9.0]


def test_all_missing_and_empty() -> None:
    time = np.arange(1000.0)
    assert np.isnan(np.full(1000, np.nan)[keep(time, np.full(1000, np.nan), 10)]).all()
    assert keep(np.empty(0), np.empty(0), 10).size == 0


@pytest.mark.parametrize("columns", [1, 3, 12])
def test_thinning_twice_is_thinning_once(columns: int) -> None:
    time, _ = wave(90_000, 1)
    rng = np.random.default_rng(2)
    trace = Trace("t", time, {f"c{i}": rng.normal(size=time.size) for i in range(columns)})
    once = reduce_trace(trace)
    assert once.time_s.size < 60_000
    assert reduce_trace(once) is once
    for name, values in trace.columns.items():
        assert once.columns[name].max() == values.max()
        assert once.columns[name].min() == values.min()


def test_the_spread_of_residuals_is_kept_from_before_the_thinning() -> None:
    time, values = wave(90_000, 4)
    thinned = reduce_trace(Trace("roll residual", time, {"residual": values}))
    quantiles = thinned.spread["residual"]
    assert quantiles[100] == pytest.approx(np.median(values))
    assert (
        thinned.columns["residual"].std() > 1.5 * values.std()
    )  # why: peaks alone would lie about the spread
    assert np.diff(quantiles)[80:120].mean() == pytest.approx(
        np.diff(np.quantile(values, np.linspace(0, 1, 201)))[80:120].mean()
    )


def test_keep_rows_leaves_short_records_alone() -> None:
    assert keep_rows(np.arange(50.0), {"a": np.arange(50.0)}, 1000).size == 50


def test_lines_break_inside_gaps() -> None:
    time, values = break_at(np.array([0.0, 1.0, 5.0, 6.0]), np.ones(4), np.array([[1.0, 5.0], [-9.0, -8.0]]))
    assert time.tolist() == [0.0, 1.0, 3.0, 5.0, 6.0]
    assert np.isnan(values).tolist() == [False, False, True, False, False]


def test_spans_nearer_than_the_eye_can_tell_are_one() -> None:
    spans = np.array([[5.0, 6.0], [0.0, 1.0], [1.05, 2.0], [0.2, 0.5]])
    assert merge_spans(spans, 0.1).tolist() == [[0.0, 2.0], [5.0, 6.0]]
    assert merge_spans(np.empty((0, 2)), 0.1).shape == (0, 2)


def test_clouds_keep_their_extremes() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=50_000), rng.normal(size=50_000)
    none = np.empty(0)
    cloud = Scatter("s", "s", "x", "y", x, y, none, none, none, none)
    thin = reduce_scatter(cloud)
    assert thin.x.size <= 6000
    assert (thin.x.min(), thin.y.max()) == (x.min(), y.max())
    assert reduce_scatter(thin) is thin
    assert spread_points(x[:10], y[:10], 100).size == 10
    index, counts = cells(x, y, 84, 64)
    assert counts.sum() == x.size
    assert index.size <= 84 * 64


def test_a_line_breaks_where_a_trace_has_no_samples() -> None:
    time = np.concatenate([np.arange(0.0, 10.0, 0.1), np.arange(25.0, 30.0, 0.1)])
    spans = jumps(time)
    assert spans == pytest.approx(np.array([[9.9, 25.0]]))
    _, values = break_at(time, np.ones(len(time)), spans)
    assert np.count_nonzero(np.isnan(values)) == 1
    assert not len(jumps(np.arange(0.0, 100.0, 5.0)))
    assert not len(jumps(np.array([0.0, 9.0])))
