"""Stamps in order: what is sorted, what is dropped, and that it is counted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parsers.timebase import JUMP_AHEAD_NS, NS, drive_gaps, find_gaps, order

REGULAR = np.arange(0, 10 * NS, NS // 100, dtype=np.int64)


def test_ordered_rows_stay_as_they_are() -> None:
    ordered = order(REGULAR)
    assert np.array_equal(ordered.rows, np.arange(len(REGULAR)))
    assert (ordered.out_of_order, ordered.duplicates, ordered.jumps, ordered.lost) == (0, 0, 0, 0)


def test_late_rows_are_sorted_and_counted() -> None:
    time = REGULAR.copy()
    time[[100, 101]] = time[[101, 100]]
    ordered = order(time)
    assert np.array_equal(ordered.time_ns, REGULAR)
    assert ordered.out_of_order == 1
    assert list(ordered.rows[99:103]) == [99, 101, 100, 102]


def test_last_of_equal_stamps_stays() -> None:
    time = REGULAR.copy()
    time[51] = time[50]
    ordered = order(time)
    assert ordered.duplicates == 1
    assert 50 not in ordered.rows
    assert 51 in ordered.rows


def test_chunks_out_of_order_are_no_clock_jump() -> None:
    time = np.concatenate([REGULAR[500:], REGULAR[:500]])
    ordered = order(time)
    assert np.array_equal(ordered.time_ns, REGULAR)
    assert (ordered.jumps, ordered.lost) == (0, 0)


def test_a_clock_set_back_costs_the_shorter_part() -> None:
    time = np.concatenate([REGULAR, REGULAR[300:700]])
    ordered = order(time)
    assert np.array_equal(ordered.rows, np.arange(1000))
    assert (ordered.jumps, ordered.lost) == (1, 400)


def test_a_clock_set_far_ahead_costs_the_shorter_part() -> None:
    time = np.concatenate([REGULAR[:200], REGULAR + 3 * JUMP_AHEAD_NS])
    ordered = order(time)
    assert np.array_equal(ordered.time_ns, REGULAR + 3 * JUMP_AHEAD_NS)
    assert (ordered.jumps, ordered.lost) == (1, 200)


SHIFTS = (-3600.0, -2.0, -1.2, 1.2, 2.0, 3600.0, 30 * 3600.0, -1e6)


# a last row that comes hours after the others may follow a pause
@pytest.mark.parametrize(
    ("rows", "shift_s"),
    [(rows, shift) for rows in ([500], [500, 501, 502], [300, 400, 700]) for shift in SHIFTS]
    + [([999], shift) for shift in SHIFTS if not 0 < shift <= 3600],
)
def test_rows_with_a_wrong_stamp_cost_these_rows_alone(rows: list[int], shift_s: float) -> None:
    time = REGULAR.copy()
    time[rows] += int(shift_s * NS)
    ordered = order(time)
    assert ordered.lost == len(rows)
    assert np.array_equal(ordered.rows, np.delete(np.arange(1000), rows))


def test_a_wrong_stamp_costs_a_row_of_a_slow_channel_and_its_pauses_stay() -> None:
    time = 2 * NS * np.arange(900, dtype=np.int64)
    time[500:] += 300 * NS
    wrong = time.copy()
    wrong[100] -= 40 * NS + 1
    ordered = order(wrong)
    assert np.array_equal(ordered.time_ns, np.delete(time, 100))


@pytest.mark.parametrize("hours", [-1, -20])
def test_a_clock_set_back_by_more_than_the_log_is_long_costs_the_shorter_part(hours: int) -> None:
    time = REGULAR.copy()
    time[600:] += hours * 3600 * NS
    ordered = order(time)
    assert np.array_equal(ordered.rows, np.arange(600))
    assert (ordered.jumps, ordered.lost) == (1, 400)


def test_chunks_in_any_order_are_put_in_order() -> None:
    chunks = np.split(np.arange(5000, dtype=np.int64) * (NS // 100), 10)
    time = np.concatenate([chunks[n] for n in (0, 2, 1, 3, 5, 4, 9, 8, 7, 6)])
    ordered = order(time)
    assert np.array_equal(ordered.time_ns, np.concatenate(chunks))
    assert (ordered.jumps, ordered.lost) == (0, 0)


def test_pauses_stay_where_the_clock_was_never_set() -> None:
    time = np.concatenate([REGULAR, REGULAR + 3600 * NS, REGULAR + 9 * 3600 * NS])
    assert order(time).untouched


@given(st.lists(st.integers(-(2**40), 2**40), min_size=0, max_size=60))
def test_always_strictly_increasing_and_nothing_unaccounted(stamps: list[int]) -> None:
    time = np.array(stamps, dtype=np.int64)
    ordered = order(time)
    assert bool((np.diff(ordered.time_ns) > 0).all())
    assert np.array_equal(time[ordered.rows], ordered.time_ns)
    assert len(ordered.rows) + ordered.duplicates + ordered.lost == len(time)


def test_gaps_are_found_once() -> None:
    time = np.concatenate([REGULAR, REGULAR + 13 * NS])
    (gap,) = find_gaps(time, 0)
    assert (round(gap.start_s, 2), round(gap.end_s, 2)) == (9.99, 13.0)
    slow = np.concatenate([REGULAR[::10], REGULAR[::10] + 13 * NS])
    holey = np.delete(time, np.arange(300, 400))
    gaps = drive_gaps({"accel_y": time, "speed": slow, "roll": holey}, 0)
    assert [gap.signal for gap in gaps] == [None, "roll"]
    assert round(gaps[1].start_s, 2) == 2.99
