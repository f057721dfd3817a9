"""An inertial unit that is mounted backwards is turned as a whole, or what contradicts that is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEFLECTIONS, check, drive, found, only, same, scaled, sprung

from parsers.checks.check import check_all

FORCES = ("accel_x", "accel_y")
ANGLES = ("roll", "pitch", "roll_rate", "pitch_rate")
OTHERS = ("accel_z", "yaw_rate", "speed", "steering_wheel_angle", "wheel_speed_rl", "wheel_speed_rr")


@pytest.mark.parametrize("others", [OTHERS, ("accel_z", "yaw_rate", "speed")])
def test_a_unit_mounted_backwards_is_turned_in_one_decision(others: tuple[str, ...]) -> None:
    signals = only(drive(), *FORCES, *ANGLES, *others)
    fixed, decisions = check(scaled(signals, **dict.fromkeys((*FORCES, *ANGLES), -1.0)))
    (one,) = [each for each in decisions if each.kind == "sign"]
    assert "mounted backwards" in one.found
    assert one.applied
    assert all(name in one.action for name in (*FORCES, *ANGLES))
    assert same(fixed, signals)


def test_pitch_that_the_drive_does_not_tell_is_turned_along() -> None:
    still = drive("circle")
    signals = only(drive(), *FORCES, *OTHERS, "roll", "roll_rate") | only(still, "pitch", "pitch_rate")
    fixed, decisions = check(scaled(signals, **dict.fromkeys((*FORCES, *ANGLES), -1.0)))
    (one,) = [each for each in decisions if each.kind == "sign"]
    assert "does not tell pitch" in one.evidence
    assert same(fixed, signals)


def test_what_contradicts_a_unit_mounted_backwards_is_named() -> None:
    """A roll angle from elsewhere: accelerations and rates are turned one by one, and the contradiction is said."""
    signals = only(drive(), *FORCES, *ANGLES, *OTHERS)
    fixed, decisions = check(scaled(signals, accel_x=-1.0, accel_y=-1.0, pitch=-1.0, pitch_rate=-1.0))
    (said,) = [each for each in decisions if "mounted backwards" in each.found]
    assert not said.applied
    assert "roll" in said.found
    assert found(decisions, "sign") >= {"accel_x", "accel_y", "pitch"}
    assert same(fixed, signals)


def test_accelerations_that_are_all_reactions_are_no_unit_mounted_backwards() -> None:
    signals = only(drive(), *FORCES, *ANGLES, *OTHERS)
    fixed, decisions = check(scaled(signals, accel_x=-1.0, accel_y=-1.0, accel_z=-1.0))
    assert not any("mounted backwards" in each.found for each in decisions)
    assert found(decisions, "sign") >= {"accel_x", "accel_z"}
    assert all((fixed[name].values == signals[name].values).all() for name in ("accel_x", "accel_z", "pitch"))


@pytest.mark.parametrize("turns", [ANGLES, ("roll_rate", "pitch_rate"), ("roll", "pitch")])
def test_two_accelerations_of_the_other_sign_are_no_unit_mounted_backwards(turns: tuple[str, ...]) -> None:
    signals = only(drive(), *FORCES, *turns, *OTHERS)
    fixed, decisions = check(scaled(signals, accel_x=-1.0, accel_y=-1.0))
    assert found(decisions, "sign") == set(FORCES)
    assert same(fixed, signals)


def test_angles_that_no_bend_or_braking_moves_make_no_unit_mounted_backwards() -> None:
    """Rates that are noise alone say nothing of how the unit is held."""
    rng = np.random.default_rng(6)
    signals = only(drive(), *FORCES, *OTHERS, "roll_rate", "pitch_rate")
    for name in ("roll_rate", "pitch_rate"):
        noise = 0.02 * rng.standard_normal(len(signals[name].values))
        signals[name] = replace(signals[name], values=noise)
    fixed, decisions = check(scaled(signals, accel_x=-1.0, accel_y=-1.0))
    assert not any(each.applied and "mounted backwards" in each.found for each in decisions)
    assert same(fixed, signals)


@pytest.mark.parametrize(
    "wrong", [(*FORCES, *ANGLES), ("yaw_rate",), DEFLECTIONS, ("suspension_deflection_fr", "suspension_deflection_rr")]
)  # fmt: skip
def test_all_that_was_turned_is_listed_whatever_the_decisions_say(wrong: tuple[str, ...]) -> None:
    signals = sprung("brake" if wrong == DEFLECTIONS else "slalom")
    signals |= {n: s for n, s in drive().items() if n in wrong}
    signals = scaled(signals, **dict.fromkeys(wrong, -1.0))
    assert check_all(signals, fix=True, units_stated={}).turned == tuple(sorted(wrong))
    assert check_all(signals, fix=False, units_stated={}).turned == ()
