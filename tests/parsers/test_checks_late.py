"""Channels that come late are told, by how much, and left as they are; a vehicle's own dynamics are no delay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import check, drive

from parsers.checks.grid import make_grid
from parsers.checks.late import delays
from parsers.drive import Decision, Signal

NS = 1_000_000_000


def held_back(signals: dict[str, Signal], name: str, seconds: float) -> dict[str, Signal]:
    """The same drive with one channel's samples stamped later."""
    late = replace(signals[name], time_ns=signals[name].time_ns + round(seconds * NS))
    return signals | {name: late}


def said(signals: dict[str, Signal]) -> list[Decision]:
    return [each for each in check(signals)[1] if each.kind == "delay"]


@pytest.mark.parametrize("kind", ["straight", "slalom", "circle", "step", "dwell", "brake"])
def test_a_drive_in_step_is_said_nothing_of(kind: str) -> None:
    assert said(drive(kind)) == []


@pytest.mark.parametrize("seconds", [0.12, 0.15, 0.3, -0.2])
def test_a_late_roll_channel_is_told_by_how_much(seconds: float) -> None:
    signals = held_back(drive("slalom"), "roll", seconds)
    (late,) = said(signals)
    assert late.signal == "roll"
    assert not late.applied
    (found,) = delays(make_grid(signals), ())
    # the cells are of a tenth of a second: what lies between them is told to a fifth of one
    assert found.seconds == pytest.approx(seconds, abs=0.02)
    assert (
        f"{1000 * abs(found.seconds):.0f} ms {'after' if seconds > 0 else 'before'} roll_rate" in late.found
    )


@pytest.mark.parametrize("seconds", [0.15, 0.3, -0.2])
def test_late_deflections_are_told_by_the_gyro(seconds: float) -> None:
    made = drive("slalom")
    signals = {n: s for n, s in made.items() if n not in ("roll", "pitch")}
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        name = f"suspension_deflection_{wheel}"
        spring = replace(made["roll"], name=name, values=side * 0.77 * made["roll"].values)
        signals = held_back(signals | {name: spring}, name, seconds)
    (late,) = said(signals)
    (found,) = delays(make_grid(signals), ())
    assert found.seconds == pytest.approx(seconds, abs=0.03)
    side = "after" if seconds > 0 else "before"
    assert (
        late.found == f"the suspension deflections come {1000 * abs(found.seconds):.0f} ms {side} roll_rate"
    )


def test_small_delays_and_channels_that_are_left_out_are_said_nothing_of() -> None:
    assert said(held_back(drive("slalom"), "roll", 0.04)) == []
    grid = make_grid(held_back(drive("slalom"), "roll", 0.3))
    assert delays(grid, {"roll"}) == []


def test_a_receiver_s_late_speed_is_told_by_the_acceleration() -> None:
    signals = held_back(drive("slalom"), "speed", 0.4)
    found = {each.first: each.seconds for each in delays(make_grid(signals), ())}
    assert found["speed"] == pytest.approx(0.4, abs=0.03)


def test_channels_of_nothing_but_noise_go_together_at_no_lag() -> None:
    rng = np.random.default_rng(2)
    signals = drive("slalom")
    noise = {n: replace(signals[n], values=rng.standard_normal(len(signals[n].values))) for n in ("roll", "roll_rate")}  # fmt: skip
    assert delays(make_grid(signals | noise), ()) == []


LATE = ("accel_y", "yaw_rate", "roll", "roll_rate", "steering_wheel_angle", "speed")


@pytest.mark.parametrize("seconds", [0.7, 1.0, 1.7, 3.0, -0.9])
@pytest.mark.parametrize("name", LATE)
def test_a_channel_that_is_seconds_late_turns_no_sign_and_is_told_by_how_much(
    name: str, seconds: float
) -> None:
    """Half a wave late is as good as inverted, to a check that looks at what is at hand only."""
    few = ("accel_x", "accel_y", "yaw_rate", "roll_rate", "speed", "steering_wheel_angle", "roll")
    made = {n: s for n, s in drive("weave", seconds=120.0).items() if n in few}
    if name == "roll_rate":
        del made["roll"]
    signals = held_back(made, name, seconds)
    fixed, decisions = check(signals)
    assert not [each.found for each in decisions if each.kind == "sign"]
    assert all(np.array_equal(fixed[n].values, signals[n].values) for n in signals)
    told = delays(make_grid(signals), ())
    assert told
    apart = [abs(each.seconds) for each in told if name in (each.first, each.second)]
    # tyres and springs hold back what they make by a tenth of a second
    assert apart
    assert all(abs(each - abs(seconds)) < 0.15 for each in apart)
    assert any("more than any fit allows" in each.action for each in decisions if each.kind == "delay")


@pytest.mark.parametrize("kind", ["weave", "slalom"])
@pytest.mark.parametrize("name", ["accel_y", "yaw_rate", "roll", "steering_wheel_angle"])
def test_what_is_inverted_is_so_for_all_that(kind: str, name: str) -> None:
    signals = drive(kind)
    fixed, decisions = check(signals | {name: replace(signals[name], values=-signals[name].values)})
    assert [(each.signal, each.kind) for each in decisions] == [(name, "sign")]
    assert np.allclose(fixed[name].values, signals[name].values)
