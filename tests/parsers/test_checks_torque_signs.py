"""A torque whose sign is wrong is named and turned; recuperation, hills and brakes of either sign are right as they are."""

from __future__ import annotations

import numpy as np
import pytest
from kinematic_log import HZ, beside, kinematic, rolling_hills, times
from test_checks_net_torque import MASS_RADIUS, check, stops

from parsers.channels import FloatArray
from parsers.checks.check import Checked
from parsers.drive import Decision, Signal

WHEELS = ("fl", "fr", "rl", "rr")


def told(checked: Checked) -> list[Decision]:
    return [each for each in checked.decisions if each.kind == "sign" and "torque" in each.signal]


@pytest.mark.parametrize("grade", [0.0, 0.05])
@pytest.mark.parametrize("brakes", ["none", "torque", "pressure"])
@pytest.mark.parametrize("recuperates", [0.0, 0.6, 1.0])
def test_a_drive_torque_against_the_change_of_speed_is_named_and_turned(
    grade: float, brakes: str, recuperates: float
) -> None:
    signals, drive, brake = stops(3.0, grade)
    drive = drive - recuperates * brake
    rest = (1 - recuperates) * brake
    beside_it = {"torque": {"brake_torque": rest}, "pressure": {"brake_pressure": rest / 25e-5}}.get(
        brakes, {}
    )
    right = check(signals, drive_torque=drive, **beside_it)
    assert not told(right)
    wrong = check(signals, drive_torque=-drive, **beside_it)
    (one,) = told(wrong)
    assert (one.signal, one.action, one.applied) == ("drive_torque", "inverted", True)
    assert "opposite to the change of speed" in one.found
    assert wrong.turned == ("drive_torque",)
    turned, straight = wrong.signals["drive_torque"].values, right.signals["drive_torque"].values
    # each has its own noise
    assert np.corrcoef(turned, straight)[0, 1] > 0.99


def test_a_net_torque_of_the_wrong_sign_still_tells_that_brakes_would_count_twice() -> None:
    signals, drive, brake = stops(6.0)
    checked = check(signals, drive_torque=brake - drive, brake_torque=brake)
    assert [each.signal for each in told(checked)] == ["drive_torque"]
    assert "brake_torque" not in checked.signals


def test_one_motor_that_turns_the_other_way_is_turned_alone() -> None:
    signals, drive, brake = stops(5.0)
    motors: dict[str, FloatArray] = {f"drive_torque_{w}": drive / 4 for w in WHEELS}
    assert not told(check(signals, **motors))
    checked = check(signals, **{**motors, "drive_torque_rr": -drive / 4}, brake_pressure=brake / 25e-5)
    assert checked.turned == ("drive_torque_rr",)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_brakes_have_either_sign_but_one(sign: float) -> None:
    signals, drive, brake = stops(5.0)
    brakes: dict[str, FloatArray] = {f"brake_torque_{w}": sign * brake / 4 for w in WHEELS}
    assert not told(check(signals, drive_torque=drive, **brakes))
    assert not told(check(signals, drive_torque=drive, brake_torque=sign * brake))
    odd = check(signals, drive_torque=drive, **{**brakes, "brake_torque_fr": -sign * brake / 4})
    minus = {"brake_torque_fr"} if sign > 0 else {f"brake_torque_{w}" for w in WHEELS if w != "fr"}
    assert set(odd.turned) == minus


def hilly(made_up: float) -> tuple[dict[str, Signal], FloatArray]:
    """Rolling hills, of whose grade the pedal makes up for a part: the vehicle slows while it is driven hardest."""
    signals = rolling_hills(made_up)
    speed, felt = signals["speed"].values, signals["accel_x"].values
    return signals, MASS_RADIUS * felt + 0.31 * (0.4 * speed**2 + 180)


@pytest.mark.parametrize("made_up", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("levelled", [False, True])
def test_hills_turn_no_torque(made_up: float, levelled: bool) -> None:
    signals, torque = hilly(made_up)
    if levelled:  # a unit that gives the change of speed and nothing of the grade
        signals = beside(signals, "accel_x", np.gradient(signals["speed"].values) * HZ)
    assert not told(check(signals, drive_torque=torque))


def test_steady_driving_and_driving_backwards_tell_nothing() -> None:
    t = times(120)
    steady = kinematic(np.full(len(t), 20.0), 0.05 * np.sin(t / 3))
    assert not told(check(steady, drive_torque=np.full(len(t), -200.0)))
    signals, drive, _ = stops(3.0)
    back = kinematic(-0.6 * signals["speed"].values, signals["yaw_rate"].values)
    for sign in (1.0, -1.0):  # logs differ in how they give a torque that drives backwards
        assert not told(check(back, drive_torque=sign * drive))


@pytest.mark.parametrize("noise", [-1.0, 1.0])
def test_what_is_left_at_wheels_that_are_not_driven_has_no_sign(noise: float) -> None:
    """A hundredth of the driven wheels' torque, against the change of speed: bearings that drag, or the sensor's crosstalk."""
    signals, drive, brake = stops(5.0)
    motors: dict[str, FloatArray] = {f"drive_torque_{w}": drive / 2 for w in ("fl", "fr")}
    motors |= {f"drive_torque_{w}": noise * drive / 100 for w in ("rl", "rr")}
    assert not told(check(signals, **motors, brake_pressure=brake / 25e-5))
