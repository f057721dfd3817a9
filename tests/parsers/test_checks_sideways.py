"""A unit that is mounted sideways, or accelerations that changed places, are left out and named."""

from __future__ import annotations

from dataclasses import replace

import pytest
from check_drives import check, drive, only

TURNS = ("roll", "pitch", "roll_rate", "pitch_rate")
SIGNALS = ("accel_x", "accel_y", "accel_z", "yaw_rate", "speed", "steering_wheel_angle", *TURNS)


def crossed(signals, x=1.0, y=1.0):
    """accel_x reads x times the lateral acceleration, accel_y reads y times the longitudinal one."""
    along, across = signals["accel_x"], signals["accel_y"]
    return signals | {
        "accel_x": replace(along, values=x * across.values, time_ns=across.time_ns),
        "accel_y": replace(across, values=y * along.values, time_ns=along.time_ns),
    }


@pytest.mark.parametrize(("x", "side"), [(1.0, "left"), (-1.0, "right")])
def test_a_unit_mounted_sideways_is_left_out_and_the_mapping_is_said(x, side) -> None:
    fixed, decisions = check(crossed(only(drive(), *SIGNALS), x, -x))
    (one,) = [each for each in decisions if "sideways" in each.found]
    assert one.applied
    assert f"points {side}" in one.found
    assert ("accel_x = -1 × accel_y's channel" in one.action) == (x > 0)
    assert not {"accel_x", "accel_y", *TURNS} & set(fixed)
    assert {"accel_z", "yaw_rate", "speed"} <= set(fixed)


def test_exchanged_channels_are_left_out_and_rates_are_kept() -> None:
    fixed, decisions = check(crossed(only(drive(), *SIGNALS)))
    (one,) = [each for each in decisions if "exchanged" in each.found]
    assert one.applied
    assert not {"accel_x", "accel_y"} & set(fixed)
    assert {"roll", "roll_rate", "pitch"} <= set(fixed)


@pytest.mark.parametrize("kind", ["slalom", "circle", "step", "dwell", "brake"])
def test_no_right_unit_is_called_sideways(kind) -> None:
    fixed, decisions = check(only(drive(kind), *SIGNALS))
    assert not any("sideways" in each.found or "exchanged" in each.found for each in decisions)
    assert {"accel_x", "accel_y"} <= set(fixed)


def test_without_changes_of_speed_nothing_is_said() -> None:
    """In a steady circle no log tells what accel_y shows."""
    _, decisions = check(crossed(only(drive("circle"), *SIGNALS)))
    assert not any("sideways" in each.found or "are exchanged" in each.found for each in decisions)
