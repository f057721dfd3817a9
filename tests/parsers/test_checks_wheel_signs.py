"""One wheel or one axle of deflections that moves otherwise than the others: put right where its sign alone is wrong, else left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEFLECTIONS, check, drive, found, only, same, scaled, sprung

from parsers.checks.grid import make_grid
from parsers.checks.held import fixes
from parsers.checks.wheel_signs import marks_of
from parsers.drive import Signal

FL, FR, RL, RR = DEFLECTIONS


def steady() -> dict[str, Signal]:
    """A drive that hardly brakes."""
    signals = sprung("step")
    return {name: signal for name, signal in signals.items() if name != "accel_x"}


def changed(signals: dict[str, Signal], one: str, other: str) -> dict[str, Signal]:
    return signals | {one: replace(signals[other], name=one), other: replace(signals[one], name=other)}


@pytest.mark.parametrize("names", [(FL, FR), (RL, RR), (FL, RL), (FR, RR), (FL, FR, RL)])
@pytest.mark.parametrize("turned", [(), ("accel_y", "yaw_rate", "steering_wheel_angle")])
def test_wheels_whose_sign_alone_is_wrong_are_put_right(
    names: tuple[str, ...], turned: tuple[str, ...]
) -> None:
    """Whatever the signs of the lateral signals are: those are told as ever."""
    signals = sprung()
    fixed, decisions = check(scaled(signals, **dict.fromkeys((*names, *turned), -1.0)))
    assert found(decisions, "sign") == {names[0], *turned}
    assert same(fixed, signals)


@pytest.mark.parametrize("make", [sprung, steady])
@pytest.mark.parametrize("name", DEFLECTIONS)
def test_a_single_wheel_of_the_other_sign_is_left_out(make, name: str) -> None:
    signals = make()
    fixed, decisions = check(scaled(signals, **{name: -1.0}))
    assert found(decisions, "sign") == {name}
    assert same(fixed, {each: signal for each, signal in signals.items() if each != name})


@pytest.mark.parametrize("pair", [(FL, FR), (RL, RR)])
def test_left_and_right_exchanged_on_one_axle_leave_it_out(pair: tuple[str, str]) -> None:
    signals = sprung()
    fixed, decisions = check(changed(signals, *pair))
    assert found(decisions, "sign") == set(pair)
    assert "exchanged" in decisions[0].found
    assert same(fixed, {name: signal for name, signal in signals.items() if name not in pair})


def test_front_and_rear_exchanged_on_one_side_leave_it_out() -> None:
    signals = sprung()
    fixed, _ = check(changed(signals, FL, RL))
    assert same(fixed, {name: signal for name, signal in signals.items() if name not in (FL, RL)})


def test_without_a_witness_beside_the_springs_none_is_used() -> None:
    """Two axles that contradict each other in bends, and nothing that tells which way the vehicle turned."""
    signals = only(steady(), "accel_y", "yaw_rate", "speed", *DEFLECTIONS)
    fixed, decisions = check(changed(signals, FL, FR))
    assert same(fixed, only(signals, "accel_y", "yaw_rate", "speed"))
    assert "nothing tells" in decisions[0].found


@pytest.mark.parametrize("make", [sprung, steady, lambda: sprung("brake"), lambda: sprung("circle")])
def test_right_wheels_are_left_alone_on_rough_ground(make) -> None:
    signals = make()
    rng = np.random.default_rng(4)
    rough = {
        name: replace(
            signals[name], values=signals[name].values + 0.01 * rng.standard_normal(len(signals[name].values))
        )
        for name in DEFLECTIONS
    }
    assert same(check(signals | rough)[0], signals | rough)


@pytest.mark.parametrize("axle", [(FL, FR), (RL, RR)])
def test_an_axle_that_its_links_hold_up_in_braking_is_right(axle: tuple[str, str]) -> None:
    signals = sprung()
    pitch = drive()["pitch"]
    held = {}
    for name in axle:
        end = 1 if "_f" in name else -1
        nod = np.interp(signals[name].time_ns, pitch.time_ns, pitch.values)
        held[name] = replace(signals[name], values=signals[name].values - 2.0 * end * 1.3 * nod)
    assert not set(axle) & found(check(signals | held)[1], "sign")


def live_axle(side: int) -> dict[str, Signal]:
    """A drive of a car whose driven rear axle its links lift, while the torque of the propeller shaft rolls the body over it. side: +1 where
    that raises the body on the right, -1 on the left."""
    signals = sprung()
    forward, pitch = drive()["accel_x"], drive()["pitch"]
    rolled = dict(signals)
    for name in DEFLECTIONS:
        time_ns = signals[name].time_ns
        torque = np.maximum(np.interp(time_ns, forward.time_ns, forward.values), 0.0)
        right = 1 if name.endswith("r") else -1
        values = signals[name].values - side * right * (0.0008 if "_f" in name else 0.004) * torque
        if "_r" in name.removeprefix("suspension"):
            values = values + 0.9 * 1.3 * np.interp(time_ns, pitch.time_ns, pitch.values)
        rolled[name] = replace(signals[name], values=values)
    return rolled


@pytest.mark.parametrize("side", [1, -1])
def test_a_wheel_of_a_driven_live_axle_that_its_torque_lifts_is_right(side: int) -> None:
    """It alone is odd in braking, and no wrong channel is odd there alone while it is right in bends."""
    signals = live_axle(side)
    marks = marks_of(make_grid(fixes(signals)))
    assert marks is not None
    odd = RR if side > 0 else RL
    assert [name for name, sign in zip(DEFLECTIONS, marks.braking.values(), strict=True) if sign < 0] == [odd]
    assert same(check(signals)[0], signals)


@pytest.mark.parametrize("side", [1, -1])
def test_all_four_of_a_driven_live_axle_are_put_right_together(side: int) -> None:
    signals = live_axle(side)
    assert same(check(scaled(signals, **dict.fromkeys(DEFLECTIONS, -1.0)))[0], signals)


@pytest.mark.parametrize("name", DEFLECTIONS)
def test_a_single_wheel_of_the_other_sign_shows_on_a_driven_live_axle(name: str) -> None:
    fixed, _ = check(scaled(live_axle(1), **{name: -1.0}))
    assert name not in fixed


def test_front_and_rear_exchanged_show_on_a_driven_live_axle() -> None:
    """On the side that its torque presses down."""
    fixed, _ = check(changed(live_axle(1), FL, RL))
    assert not {FL, RL} & set(fixed)
