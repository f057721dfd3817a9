"""Hills and reverse gear leave right signs alone; what pedals do tells wrong ones there too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEFLECTIONS, check, drive, found, only, same, scaled
from kinematic_log import kinematic, rolling_hills, times

from parsers.checks import unchecked
from parsers.drive import Signal

WRONG = [("accel_x",), ("pitch",), ("pitch_rate",), DEFLECTIONS, ("accel_x", *DEFLECTIONS)]


@pytest.mark.parametrize("pedals", [True, False])
@pytest.mark.parametrize("made_up", [0.5, 0.7, 0.85])
def test_right_signs_on_rolling_hills_are_left_alone(made_up: float, pedals: bool) -> None:
    """The vehicle is pushed uphill while it slows: accel_x and the springs go against the change of speed."""
    signals = rolling_hills(made_up, pedals=pedals)
    change = np.gradient(signals["speed"].values[::50])
    assert np.corrcoef(change, signals["accel_x"].values[::50])[0, 1] < -0.3
    fixed, decisions = check(signals)
    assert not found(decisions, "sign")
    assert same(fixed, signals)


def test_a_sign_that_hills_hide_is_said_to_be_untold() -> None:
    texts = unchecked(rolling_hills(0.5, pedals=False, steep=1.5), {})
    assert (
        "sign of accel_x: it goes against the change of speed, but that is so slow that hills may be why"
        in texts
    )


@pytest.mark.parametrize("kept", [("pitch",), ()])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nothing_is_held_against_an_accel_x_that_hills_hide(sign: float, kept: tuple[str, ...]) -> None:
    """A circle driven faster and slower within 40 s, so gently that grades could do it: a wrong accel_x turns neither pitch nor its rate."""
    t = times(120)
    signals = kinematic(12 + 8 * np.sin(2 * np.pi * t / 40), 0.1 + 0.0 * t, noise=0.02)
    signals = only(signals, *kept, "accel_x", "speed", "pitch_rate")
    wrong = scaled(signals, accel_x=sign)
    fixed, decisions = check(wrong)
    assert not found(decisions, "sign")
    assert same(fixed, wrong)


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("made_up", [0.5, 0.85])
def test_a_wrong_sign_is_found_on_hills_by_the_pedals(made_up: float, wrong: tuple[str, ...]) -> None:
    signals = rolling_hills(made_up)
    fixed, _ = check(scaled(signals, **dict.fromkeys(wrong, -1.0)))
    assert same(fixed, signals)


def test_an_odd_wheel_is_found_on_hills() -> None:
    signals = rolling_hills(0.7)
    _, decisions = check(scaled(signals, suspension_deflection_rl=-1.0))
    (out,) = [each for each in decisions if each.kind == "sign"]
    assert out.signal == "suspension_deflection_rl"
    assert "left out" in out.action


@pytest.mark.parametrize("stated", [True, False])
def test_hills_say_nothing_of_units(stated: bool) -> None:
    """accel_x is three times the change of speed, as a speed in mph taken for km/h would have it, and more."""
    _, decisions = check(rolling_hills(0.75, pedals=False), stated=stated)
    assert not found(decisions, "unit")


@pytest.mark.parametrize("wrong", [(), *WRONG[:1], *WRONG[3:4]])
def test_a_minute_with_a_brake_tells_signs(wrong: tuple[str, ...]) -> None:
    t = times(60)
    brake = -3 * ((t > 20) & (t < 23)) + 1.8 * ((t > 30) & (t < 35))
    signals = kinematic(15 + np.cumsum(brake) / 50, 0.1 * np.sin(t))
    fixed, _ = check(scaled(signals, **dict.fromkeys(wrong, -1.0)))
    assert same(fixed, signals)


def backwards() -> dict[str, Signal]:
    """Five minutes of a slalom in reverse gear, with a speed that is signed."""
    t = times(300)
    speed = (-6 - 2.5 * np.sin(2 * np.pi * t / 25)) * np.clip(t / 5, 0, 1)
    return kinematic(speed, 0.3 * np.sin(2 * np.pi * t / 12) * (1 + 0.5 * np.sin(2 * np.pi * t / 47)))


def test_a_drive_backwards_with_a_signed_speed_keeps_its_signs() -> None:
    signals = backwards()
    fixed, decisions = check(signals)
    assert not found(decisions, "sign")
    assert same(fixed, signals)


def test_driving_forth_and_back_tells_signs() -> None:
    t = times(300)
    signals = kinematic(6 * np.sin(2 * np.pi * t / 20), 0.3 * np.sin(2 * np.pi * t / 12))
    assert same(check(signals)[0], signals)
    assert same(check(scaled(signals, accel_x=-1.0))[0], signals)


def test_a_slow_speed_of_the_wrong_sign_turns_nothing_along_the_vehicle() -> None:
    """Slower than any speed that no reverse gear reaches: the speed or accel_x may be wrong, and that is said."""
    signals = only(drive(speed=8.0), "accel_x", "speed")
    wrong = scaled(signals, speed=-1.0)
    fixed, decisions = check(wrong)
    assert not found(decisions, "sign")
    assert same(fixed, wrong)
    assert any(
        text.startswith("sign of accel_x") and "a speed that is negative" in text
        for text in unchecked(wrong, {})
    )


@pytest.mark.parametrize("step", [0.1, 0.28])
def test_a_coarse_speed_tells_signs(step: float) -> None:
    signals = drive()
    speed = signals["speed"]
    signals["speed"] = replace(speed, values=np.round(speed.values / step) * step)
    fixed, _ = check(scaled(signals, accel_x=-1.0))
    assert np.array_equal(fixed["accel_x"].values, signals["accel_x"].values)
