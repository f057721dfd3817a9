"""Undeclared codes for "no value" go before units are judged: a stated unit stands, and only the code's samples go."""

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEG, check, drive, found, only, scaled

from parsers.checks.wording import show

SECOND = slice(500, 550)
CODES = [
    ("steering_wheel_angle", 3276.7 * DEG),
    ("yaw_rate", 655.35 * DEG),
    ("yaw_rate", 327.67 * DEG),
    ("pitch", 327.67 * DEG),
    ("accel_x", -65.0),
]


def with_code(signals, name, value, where=SECOND):
    values = signals[name].values.copy()
    values[where] = value
    return signals | {name: replace(signals[name], values=values)}


@pytest.mark.parametrize(("name", "value"), CODES)
@pytest.mark.parametrize("stated", [True, False])
def test_a_second_of_a_code_is_removed_and_changes_no_unit(name, value, stated):
    signals = drive()
    fixed, decisions = check(with_code(signals, name, value), stated)
    assert [(each.signal, each.kind) for each in decisions] == [(name, "spikes")]
    assert "50 samples" in decisions[0].found
    assert np.array_equal(fixed[name].values, np.delete(signals[name].values, SECOND))


@pytest.mark.parametrize("code", [-9999.0, 32767.0, -32768.0, 65535.0])
def test_single_samples_of_what_loggers_write_for_no_value_are_removed_from_a_torque(code):
    signals = drive()
    pattern = signals["accel_x"]
    torque = replace(pattern, name="drive_torque", values=600 * pattern.values)
    at = np.array([300, 301, 900, 1500])
    fixed, decisions = check(with_code(signals | {"drive_torque": torque}, "drive_torque", code, at))
    assert [(each.signal, each.kind) for each in decisions] == [("drive_torque", "spikes")]
    assert np.array_equal(fixed["drive_torque"].values, np.delete(torque.values, at))


def test_a_torque_that_comes_near_such_a_value_keeps_it():
    signals = drive()
    pattern = signals["accel_x"]
    values = 9999 * np.sin(pattern.time_ns / 1e10)
    values[500] = 9999.0
    fixed, decisions = check(signals | {"drive_torque": replace(pattern, name="drive_torque", values=values)})
    assert not decisions
    assert len(fixed["drive_torque"].values) == len(values)


def test_a_kerb_strike_stays_beside_a_code():
    signals = with_code(drive(), "accel_x", 30.0, slice(2000, 2001))
    fixed, decisions = check(with_code(signals, "accel_x", -65.0))
    assert "50 samples" in decisions[0].found
    assert np.array_equal(fixed["accel_x"].values, np.delete(signals["accel_x"].values, SECOND))


def test_a_code_does_not_hide_a_unit_that_is_wrong():
    signals = {n: replace(s, group=n) for n, s in drive().items()}
    wrong = with_code(scaled(signals, yaw_rate=1 / DEG), "yaw_rate", 655.35)
    fixed, decisions = check(wrong, stated=False)
    assert found(decisions, "unit") == {"yaw_rate"}
    assert np.allclose(fixed["yaw_rate"].values, np.delete(signals["yaw_rate"].values, SECOND))


def test_half_a_drive_of_a_code_leaves_the_signal_out_with_its_unit_as_stated():
    signals = drive()
    fixed, decisions = check(
        with_code(signals, "steering_wheel_angle", 3276.7 * DEG, slice(0, 1200)), stated=True
    )
    assert "steering_wheel_angle" not in fixed
    assert [(each.signal, each.kind) for each in decisions] == [("steering_wheel_angle", "range")]


def test_a_steering_wheel_in_degrees_that_is_mostly_straight_is_no_code():
    steering = drive("dwell")["steering_wheel_angle"]
    assert np.mean(np.abs(steering.values) > 35 * DEG) < 0.05
    fixed, decisions = check(
        scaled(only(drive("dwell"), "steering_wheel_angle"), steering_wheel_angle=1 / DEG)
    )
    assert found(decisions, "unit") == {"steering_wheel_angle"}
    assert np.allclose(fixed["steering_wheel_angle"].values, steering.values)


def test_a_number_that_damage_left_is_shown_in_three_figures() -> None:
    assert show("accel_x", 8.5246934786344e304) == "8.52e+304 m/s²"
    assert show("suspension_force_fl", 123456.0) == "123456 N"
