"""Rows on disk: any window is loaded as if all had been ordered in memory, and the counts are the same."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parsers.spool
from parsers.spool import GroupRows, GroupWriter, Spool
from parsers.timebase import JUMP_AHEAD_NS, MAX_RUNS, NS, order
from parsers.windows import windows_of


def spooled(spool: Spool, time_ns: np.ndarray, chunk: int, flush_every: int = 3) -> GroupRows:
    writer = GroupWriter(spool, ("a", "b"))
    for number, start in enumerate(range(0, len(time_ns), chunk)):
        part = time_ns[start : start + chunk]
        writer.add(part, {"a": np.arange(start, start + len(part), dtype=float), "b": part / 7})
        if number % flush_every == flush_every - 1:
            writer.flush()
    return writer.finish()


def check(folder, time_ns: np.ndarray, chunk: int, most: int) -> GroupRows:
    """Windows put together equal what `order` makes of the whole; the rows, to ask for their counts."""
    with closing(Spool(folder)) as spool:
        rows = spooled(spool, time_ns, chunk)
        compare(rows, time_ns, most)
        return rows


def compare(rows: GroupRows, time_ns: np.ndarray, most: int) -> None:
    expected = order(time_ns)
    assert (rows.late, rows.jumps, rows.lost) == (expected.out_of_order, expected.jumps, expected.lost)
    stamps, numbers, derived = [], [], []
    windows = windows_of([(rows, 24)], most)
    for (start, stop), after in zip(windows, [*windows[1:], (windows[-1][1], 0)], strict=True):
        assert start < stop == after[0]
        found, columns = rows.load(start, stop, ["a", "b"])
        assert ((found >= start) & (found < stop)).all()
        stamps.append(found)
        numbers.append(columns["a"])
        derived.append(columns["b"])
    assert np.array_equal(np.concatenate(stamps), expected.time_ns)
    assert np.array_equal(np.concatenate(numbers), expected.rows.astype(float))
    assert np.array_equal(np.concatenate(derived), expected.time_ns / 7)
    assert rows.rows - len(expected.time_ns) == expected.duplicates


@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.one_of(
            st.integers(1, 50).map(lambda ms: ms * 1_000_000),
            st.sampled_from(
                [0, -1_000_000, -40_000_000, -3 * NS, 5 * NS, JUMP_AHEAD_NS + NS, -2 * JUMP_AHEAD_NS]
            ),
        ),
        min_size=1,
        max_size=300,
    ),
    st.integers(1, 90),
    st.integers(2, 4000),
)
def test_equal_to_order_whatever_the_stamps(tmp_path_factory, steps, chunk, most) -> None:
    time_ns = np.cumsum(np.array(steps, dtype=np.int64))
    rows = check(tmp_path_factory.getbasetemp(), time_ns, chunk, most)
    assert rows.rows + rows.lost == len(time_ns)


@pytest.mark.parametrize("block", [7, 64, 1 << 16])
def test_late_rows_duplicates_and_set_clocks(tmp_path, monkeypatch, block) -> None:
    monkeypatch.setattr(parsers.spool, "BLOCK_ROWS", block)
    rng = np.random.default_rng(3)
    time_ns = np.arange(3000) * 10_000_000
    time_ns[rng.integers(0, 3000, 200)] -= rng.integers(0, 500_000_000, 200)
    time_ns[700:900] += 40 * JUMP_AHEAD_NS
    time_ns[2000:2300] -= 15 * NS
    time_ns[2500] = time_ns[2400]
    rows = check(tmp_path, time_ns, 111, 24 * 100)
    assert rows.late > 100
    assert rows.jumps >= 2


def test_more_settings_than_anybody_makes_are_shuffled_stamps(tmp_path) -> None:
    for runs in (MAX_RUNS - 1, MAX_RUNS, MAX_RUNS + 40):
        steps = np.full(5000, 1_000_000)
        steps[16 * np.arange(1, runs)] = -NS - 10_000_000
        time_ns = np.cumsum(steps)
        rows = check(tmp_path, time_ns, 97, 24 * 200)
        assert (rows.jumps, rows.late) == (0, runs - 1)


def test_the_usual_steps_of_a_slow_channel_are_no_pauses(tmp_path) -> None:
    time_ns = np.arange(3000) * 2 * NS
    time_ns[1700] -= 7 * NS
    rows = check(tmp_path, time_ns, 97, 24 * 200)
    assert (rows.jumps, rows.lost) == (1, 1)


def test_all_stamps_equal(tmp_path) -> None:
    time_ns = np.full(5000, 12345)
    rows = check(tmp_path, time_ns, 100, 100)
    assert (rows.rows, rows.late, rows.jumps, rows.lost) == (5000, 0, 0, 0)


def test_a_chunk_without_a_column_has_no_values_there(tmp_path) -> None:
    with closing(Spool(tmp_path)) as spool:
        writer = GroupWriter(spool, ("a", "b"))
        writer.add(np.array([1, 2]), {"a": np.array([1.0, 2.0])})
        writer.add(np.array([3]), {"a": np.array([3.0]), "b": np.array([9.0])})
        _, columns = writer.finish().load(0, 10, ["a", "b"])
    assert np.array_equal(columns["b"], [np.nan, np.nan, 9.0], equal_nan=True)


def test_windows_hold_about_as_much_each_whatever_the_pauses(tmp_path) -> None:
    time_ns = np.concatenate([np.arange(50_000), 10**12 + 100 * np.arange(50_000)])
    with closing(Spool(tmp_path)) as spool:
        rows = spooled(spool, time_ns, 1000, 1)
        sizes = [len(rows.load(a, b, [])[0]) for a, b in windows_of([(rows, 24)], 24 * 1000)]
    assert sum(sizes) == 100_000
    assert max(sizes) < 2100


def test_nothing_is_left_on_the_disk(tmp_path) -> None:
    spool = Spool(tmp_path)
    spool.put(np.arange(100.0))
    assert list(tmp_path.iterdir()) == []
    spool.close()
