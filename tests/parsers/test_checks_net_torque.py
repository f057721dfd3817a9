"""A wheel torque that holds the brakes' part: found by how it goes with braking, told from drives and from motors that recuperate."""

from __future__ import annotations

import numpy as np
import pytest
from kinematic_log import HZ, beside, kinematic, times

from parsers.channels import FloatArray
from parsers.checks import check_all
from parsers.checks.check import Checked
from parsers.drive import Decision, Signal

MASS_RADIUS = 1600 * 0.31
WHEELS = ("fl", "fr", "rl", "rr")


def stops(hard: float = 5.0, grade: float = 0.0) -> tuple[dict[str, Signal], FloatArray, FloatArray]:
    """Three minutes of pulling away and braking on hills; with the torque at the wheels that drives, and that of the brakes (+)."""
    t = times(180)
    phase = t % 20
    change = 1.8 * (phase < 8) - hard * ((phase >= 12) & (phase < 12 + 1.8 * 8 / hard))
    change = np.convolve(change, np.ones(15) / 15, mode="same")
    speed = np.maximum(3 + np.cumsum(change) / HZ, 0.5)
    hills = grade * np.sin(2 * np.pi * t / 37)
    signals = kinematic(speed, 0.05 * np.sin(t / 3), hills)
    whole = MASS_RADIUS * (np.gradient(speed) * HZ + 9.81 * hills) + 0.31 * (0.4 * speed**2 + 180)
    brake = np.where(change < -0.3, np.maximum(-whole, 0.0), 0.0)
    return signals, whole + brake, brake


def told(checked: Checked) -> list[Decision]:
    return [each for each in checked.decisions if "of the brakes as well" in each.found]


def check(signals: dict[str, Signal], **columns: FloatArray) -> Checked:
    for name, values in columns.items():
        noise = np.random.default_rng(4).standard_normal(len(values))
        signals = beside(signals, name, values + 0.005 * float(np.max(np.abs(values))) * noise)
    return check_all(signals, fix=True, units_stated={})


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("grade", [0.0, 0.05])
@pytest.mark.parametrize("hard", [2.5, 6.0])
def test_a_net_torque_beside_a_brake_torque_leaves_the_brakes_out(
    sign: float, grade: float, hard: float
) -> None:
    signals, drive, brake = stops(hard, grade)
    checked = check(
        signals, drive_torque=drive - brake, brake_torque=sign * brake, brake_pressure=brake / 25e-5
    )
    assert {each.signal for each in told(checked)} == {"brake_torque", "brake_pressure"}
    # what the terminal takes away from the front of it
    assert all(each.action.startswith("left out: ") for each in told(checked))
    assert {"brake_torque", "brake_pressure"} & checked.signals.keys() == set()
    assert "drive_torque" in checked.signals


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("grade", [0.0, 0.05])
@pytest.mark.parametrize("hard", [2.5, 6.0])
def test_a_drive_torque_beside_its_brakes_is_left_alone(sign: float, grade: float, hard: float) -> None:
    signals, drive, brake = stops(hard, grade)
    checked = check(signals, drive_torque=drive, brake_torque=sign * brake, brake_pressure=brake / 25e-5)
    assert not told(checked)
    assert {"brake_torque", "brake_pressure", "drive_torque"} <= checked.signals.keys()
    assert not told(check(signals, drive_torque=drive, brake_pressure=brake / 25e-5))


def test_a_pressure_alone_needs_braking_that_no_motor_does() -> None:
    signals, drive, brake = stops(6.0)
    hard = check(signals, drive_torque=drive - brake, brake_pressure=brake / 25e-5)
    assert [(each.signal, each.applied) for each in told(hard)] == [("brake_pressure", True)]
    signals, drive, brake = stops(2.5)
    soft = check(signals, drive_torque=drive - brake, brake_pressure=brake / 25e-5)
    (one,) = told(soft)
    assert (one.signal, one.applied) == ("drive_torque", False)
    assert "may be" in one.found
    assert "brake_pressure" in soft.signals


@pytest.mark.parametrize("most", [0.3, 0.6])
def test_a_motor_that_takes_a_part_of_the_braking_is_left_alone(most: float) -> None:
    signals, drive, brake = stops(4.5)
    motor = most * brake
    assert not told(check(signals, drive_torque=drive - motor, brake_torque=brake - motor))
    assert not told(check(signals, drive_torque=drive - motor, brake_pressure=(brake - motor) / 25e-5))


def test_wheels_one_by_one() -> None:
    signals, drive, brake = stops(5.0)
    columns = {f"drive_torque_{w}": (drive - brake) / 4 for w in WHEELS}
    columns |= {f"brake_torque_{w}": brake / 4 for w in WHEELS}
    checked = check(signals, **columns)
    assert {each.signal for each in told(checked)} == {f"brake_torque_{w}" for w in WHEELS}
    # the drive of one axle, net, with the brakes of all: the other axle's are not in it
    part = {f"drive_torque_r{s}": drive / 2 - 0.15 * brake for s in "lr"}
    part |= {f"brake_torque_{w}": brake * (0.35 if w[0] == "f" else 0.15) for w in WHEELS}
    assert not told(check(signals, **part))


def test_without_braking_or_without_a_pedal_that_pulls_nothing_is_said() -> None:
    signals, drive, brake = stops(5.0)
    assert not told(check(signals, drive_torque=drive - brake, brake_torque=0.0 * brake))
    assert not told(check(signals, drive_torque=-brake, brake_torque=brake))
    without = {name: each for name, each in signals.items() if name not in ("accel_x", "speed")}
    like = {**without, "accel_x": signals["accel_x"]}
    assert not told(check(like, drive_torque=drive - brake, brake_torque=brake))
