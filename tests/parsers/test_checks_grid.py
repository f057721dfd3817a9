"""The common clock of the checks."""

import numpy as np
import pytest

from parsers.checks.grid import compare, make_grid
from parsers.checks.spikes import _median_of_five, calm
from parsers.drive import Signal

NS = 1_000_000_000


def signal(times, values):
    return Signal("roll", (np.asarray(times) * NS).astype(np.int64), np.asarray(values, dtype=float), "x")


def test_cells_hold_means_and_short_gaps_are_bridged():
    grid = make_grid({"roll": signal([0.01, 0.05, 0.21, 0.55, 1.75], [1, 3, 4, 10, 20])})
    column = grid.columns["roll"]
    assert grid.time_s[:3] == pytest.approx([0.05, 0.15, 0.25])
    assert column[:6] == pytest.approx([2, 3, 4, 6, 8, 10])
    assert np.isnan(column[6:17]).all()  # 1.2 s without a sample
    assert column[17] == 20


def test_long_pauses_cost_no_memory():
    grid = make_grid({"roll": signal([0.0, 1.0, 1e8], [1, 2, 3])})
    assert len(grid.time_s) == 30
    assert np.isnan(grid.rate(grid.columns["roll"])[10:]).all()


def test_slow_satellites_are_bridged_over_one_period():
    grid = make_grid({"roll": signal(np.arange(10.0), np.arange(10.0))})
    assert grid.columns["roll"][:91] == pytest.approx(np.arange(91) / 10)


def test_compare_finds_sign_ratio_and_lag():
    t = np.arange(600) * 0.1
    a = np.sin(t)
    together = compare(-3 * np.roll(a, 2), a)
    assert together is not None
    assert together.correlation == pytest.approx(-1, abs=0.01)
    assert together.ratio == pytest.approx(3, rel=0.02)
    assert compare(a, np.full(600, np.nan)) is None
    assert compare(a, np.zeros(600)) is None
    assert compare(a[:5], a[:5]) is None


def test_median_of_five_equals_the_sorted_one():
    rows = np.random.default_rng(0).integers(-3, 4, (5, 5000)).astype(float)
    assert np.array_equal(_median_of_five(list(rows)), np.median(rows, axis=0))


def test_calm_takes_only_what_stands_alone():
    t = np.arange(500) * 0.01
    values = np.sin(t)
    values[[40, 41, 300]] = [900, 900, -70]
    left = calm(signal(t, values))
    assert len(left.values) == 497
    assert np.abs(left.values).max() <= 1
    step = signal(t, (t > 2).astype(float))
    assert calm(step) is step


def test_numbers_whose_squares_overflow_say_nothing():
    huge = np.where(np.arange(400) % 2, 1e200, -1e200)
    wave = np.sin(np.arange(400) / 10)
    assert compare(wave, huge) is None
    assert compare(huge, wave) is None


def test_columns_of_the_same_signals_are_taken_over():
    time = np.arange(0, 30, 0.02)
    roll, ay = signal(time, np.sin(time)), signal(time, np.cos(time))
    shared = {"roll": roll, "accel_y": Signal("accel_y", roll.time_ns, ay.values, "y")}
    first = make_grid(shared)
    doubled = {**shared, "roll": Signal("roll", roll.time_ns, 2 * roll.values, "x")}
    again = make_grid(doubled, first)
    assert again.columns["accel_y"] is first.columns["accel_y"]
    for name, column in make_grid(doubled).columns.items():
        assert np.array_equal(again.columns[name], column, equal_nan=True)
    # other stamps, other cells: nothing can be taken over
    later = {"roll": roll, "accel_y": signal(time[700:] + 40.0, ay.values[700:])}
    fresh, after = make_grid(later), make_grid(later, first)
    assert np.array_equal(after.time_s, fresh.time_s)
    assert np.array_equal(after.columns["roll"], fresh.columns["roll"], equal_nan=True)


@pytest.mark.parametrize(("hertz", "least"), [(0.4, 0.95), (2.5, 0.0)])
def test_what_a_lag_turns_round_has_no_sign(hertz: float, least: float) -> None:
    """At 2.5 Hz two tenths of a second turn a swing round: it goes with another as well either way."""
    rng = np.random.default_rng(0)
    time_s = 0.1 * np.arange(3000)
    swing = np.sin(2 * np.pi * hertz * time_s + 0.2 * np.cumsum(rng.standard_normal(3000)) / np.sqrt(10))
    found = compare(swing, np.roll(swing, 1) + 0.1 * rng.standard_normal(3000))
    assert found is not None
    assert (abs(found.correlation) < 0.3) if least == 0 else found.correlation > least
