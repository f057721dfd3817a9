"""Loads that stand at one value for the whole drive are left out where the drive must move them."""

from __future__ import annotations

import numpy as np
import pytest
from check_drives import check, drive
from kinematic_log import beside, kinematic, times

from parsers.drive import Decision, Signal
from parsers.signals import WHEELS

LOADS = ("axle_load_front", "axle_load_rear")


def loaded(dead: str = "") -> dict[str, Signal]:
    """A slalom with two axle loads (N) that pushing and braking shift, one of them dead."""
    signals = drive()
    shift = 900 * np.round(signals["accel_x"].values, 1)
    for name, mean, side in zip(LOADS, (30_000.0, 45_000.0), (-1, 1), strict=True):
        signals = beside(signals, name, mean if name == dead else mean + side * shift)
    return signals


def said(decisions: tuple[Decision, ...], name: str) -> list[Decision]:
    return [each for each in decisions if each.signal == name and "stands at" in each.found]


def test_axle_loads_that_shift_are_left_alone() -> None:
    fixed, _ = check(loaded())
    assert set(LOADS) <= set(fixed)


@pytest.mark.parametrize("dead", LOADS)
def test_an_axle_load_that_no_braking_shifts_is_left_out(dead: str) -> None:
    fixed, decisions = check(loaded(dead))
    (one,) = said(decisions, dead)
    assert one.applied
    assert set(LOADS) - set(fixed) == {dead}


def test_an_axle_load_at_a_steady_speed_may_stand() -> None:
    t = times(60)
    signals = beside(kinematic(20 + 0 * t, 0.1 * np.sin(t)), LOADS[0], 30_000.0)
    fixed, decisions = check(signals)
    assert LOADS[0] in fixed
    assert not said(decisions, LOADS[0])


def test_a_dead_tyre_force_is_left_out() -> None:
    """Normal forces between tyre and road, of which one wheel's stands still."""
    signals = drive(seconds=100)
    lateral, forward = signals["accel_y"].values, signals["accel_x"].values
    for wheel in WHEELS:
        side, end = (1 if wheel[1] == "r" else -1), (1 if wheel[0] == "r" else -1)
        moved = 0.0 if wheel == "rl" else 400 * side * lateral + 200 * end * forward
        signals = beside(signals, f"tire_normal_force_{wheel}", 4000 + moved)
    fixed, decisions = check(signals)
    (one,) = [each for each in decisions if each.signal == "tire_normal_force_rl"]
    assert "does not move with the other wheels" in one.found
    assert "tire_normal_force_rl" not in fixed
    assert "tire_normal_force_rr" in fixed
