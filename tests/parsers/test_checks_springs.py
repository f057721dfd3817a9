"""Suspension deflections: braking tells their sign, and they tell that of the lateral signals and the pitch rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEFLECTIONS, check, drive, found, only, same, scaled, sprung

from parsers.drive import Signal

LATERAL = ("accel_y", "yaw_rate", "steering_wheel_angle")


def test_right_signs_are_left_alone() -> None:
    signals = sprung()
    fixed, decisions = check(signals)
    assert found(decisions, "sign") == set()
    assert same(fixed, signals)


@pytest.mark.parametrize("kind", ["slalom", "brake"])
def test_extension_taken_for_compression_is_found_in_braking(kind: str) -> None:
    """With or without a bend in the drive."""
    signals = sprung(kind)
    fixed, decisions = check(scaled(signals, **dict.fromkeys(DEFLECTIONS, -1.0)))
    (one,) = [each for each in decisions if each.kind == "sign"]
    assert one.applied
    assert "extension was taken for compression" in one.found
    assert all(np.array_equal(fixed[name].values, signals[name].values) for name in DEFLECTIONS)


@pytest.mark.parametrize("down", [True, False])
def test_axes_with_y_to_the_right_are_turned_not_the_springs(down: bool) -> None:
    """SAE J670, z down or up: lateral signals agree with each other, and all of them disagree with the springs."""
    signals = sprung()
    names = (*LATERAL, "pitch_rate", *(("accel_z",) if down else ()))
    fixed, decisions = check(scaled(signals, **dict.fromkeys(names, -1.0)))
    assert found(decisions, "sign") == set(names)
    assert same(fixed, signals)
    (yaw,) = [each for each in decisions if each.signal == "yaw_rate"]
    assert "goes with accel_y, which has the sign opposite to the springs" in yaw.found
    assert ("SAE J670" in yaw.action) == down


def test_z_down_axes_are_found_by_the_roll_rate_alone() -> None:
    signals = only(sprung(), *LATERAL, "accel_z", "roll_rate", "speed")
    fixed, decisions = check(scaled(signals, **dict.fromkeys((*LATERAL, "accel_z"), -1.0)))
    assert found(decisions, "sign") == {*LATERAL, "accel_z"}
    assert same(fixed, signals)


def test_springs_tell_the_pitch_rate() -> None:
    signals = sprung("brake")
    fixed, decisions = check(scaled(signals, pitch_rate=-1.0))
    assert found(decisions, "sign") == {"pitch_rate"}
    assert "that the springs show" in next(d.found for d in decisions if d.kind == "sign")
    assert np.array_equal(fixed["pitch_rate"].values, signals["pitch_rate"].values)


WAYS = [({"f": "r", "r": "f"}, "front and rear"), ({"l": "r", "r": "l"}, "left and right")]


def exchanged(signals: dict[str, Signal], turn: dict[str, str]) -> dict[str, Signal]:
    """The signals with the deflections of two wheels each under the other's name."""
    wrong = dict(signals)
    for name in DEFLECTIONS:
        end, side = name[-2:]
        other = turn[end] + side if "f" in turn else end + turn[side]
        wrong[name] = replace(signals[f"{name[:-2]}{other}"], name=name)
    return wrong


@pytest.mark.parametrize(("turn", "pair"), WAYS)
@pytest.mark.parametrize("more", [("roll", "wheel_speed_rl", "wheel_speed_rr"), ("roll",), ()])
def test_wheels_that_are_exchanged_are_no_matter_of_sign(
    turn: dict[str, str], pair: str, more: tuple[str, ...]
) -> None:
    """Braking and bends contradict each other: inverting makes one of them right and the other wrong.

    With wheel speeds or without: roll, or its rate, is enough to tell that the lateral signals are right.
    """
    signals = sprung() | only(drive("slalom"), *more)
    fixed, decisions = check(exchanged(signals, turn))
    (said,) = [each for each in decisions if each.kind == "sign"]
    assert f"deflections of {pair} wheels look exchanged" in said.found
    assert not set(DEFLECTIONS) & set(fixed)
    assert same(fixed, {name: signal for name, signal in signals.items() if name not in DEFLECTIONS})


@pytest.mark.parametrize("kept", [("accel_y", "yaw_rate"), ("accel_y", "steering_wheel_angle")])
def test_two_lateral_signals_and_the_roll_rate_outweigh_exchanged_springs(kept: tuple[str, ...]) -> None:
    signals = only(sprung(), *kept, "roll_rate", "speed", *DEFLECTIONS)
    fixed, _ = check(exchanged(signals, WAYS[1][0]))
    assert same(fixed, only(signals, *kept, "roll_rate", "speed"))
