"""Sensors that die or freeze in mid-drive are left out and named; what moves little for a reason is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import NS, check, drive, only
from kinematic_log import HZ, kinematic, times

from parsers.checks.frozen import IDLE
from parsers.drive import Signal
from parsers.signals import WHEELS

RR = "suspension_deflection_rr"


def with_wheels(seconds: float = 100.0, rear: float = 1.0, size: float = 0.006) -> dict[str, Signal]:
    """A slalom with four deflections (m) that follow the body and the road. rear: how much the rear ones move of the front's."""
    signals = drive(seconds=seconds)
    # the deflections are of any size here: a gyro would contradict them
    del signals["roll_rate"]
    rng = np.random.default_rng(3)
    roll, time_ns = signals["roll"].values, signals["roll"].time_ns
    for wheel in WHEELS:
        side, share = (-1 if wheel[1] == "l" else 1), (1.0 if wheel[0] == "f" else rear)
        road = np.convolve(rng.standard_normal(len(roll)), np.ones(15) / 4, mode="same")
        moved = share * size * (side * roll / np.std(roll) + 0.5 * road)
        name = f"suspension_deflection_{wheel}"
        signals[name] = Signal(name, time_ns, 0.02 + moved + 0.0001 * rng.standard_normal(len(roll)), name)
    return signals


def hold(
    signals: dict[str, Signal], name: str, share: tuple[float, float], noise: float = 0.0
) -> dict[str, Signal]:
    """A channel that keeps its value from one share of the drive to another."""
    values = signals[name].values.copy()
    begin, end = (int(each * len(values)) for each in share)
    values[begin:end] = values[begin] + noise * np.random.default_rng(8).standard_normal(end - begin)
    return signals | {name: replace(signals[name], values=values)}


def test_a_healthy_drive_has_none() -> None:
    for rear in (1.0, 0.25, 3.0):
        fixed, decisions = check(with_wheels(rear=rear))
        assert RR in fixed
        assert not [each for each in decisions if "suspension_deflection" in each.signal]


def with_accelerations(kind: str, size: float = 3.0) -> dict[str, Signal]:
    """A slalom with four vertical accelerations of hubs or of the body above them; rear hubs are the livelier ones."""
    signals = drive()
    rng = np.random.default_rng(5)
    time_ns = signals["roll"].time_ns
    for wheel in WHEELS:
        name = f"{kind}_{wheel}"
        road = size * (1.0 if wheel[0] == "f" else 2.0) * rng.standard_normal(len(time_ns))
        signals[name] = Signal(name, time_ns, 9.81 + road, name)
    return signals


@pytest.mark.parametrize("kind", ["accel_z_unsprung", "accel_z_sprung"])
@pytest.mark.parametrize("dead", ["fl", "rr"])
@pytest.mark.parametrize("since", [0.0, 0.5])
def test_a_dead_acceleration_at_one_wheel_is_left_out(kind: str, dead: str, since: float) -> None:
    """A hub's that stood at 9.81 put the CG 55 mm to one side, identified, at 4.5 standard deviations."""
    name = f"{kind}_{dead}"
    fixed, decisions = check(hold(with_accelerations(kind), name, (since, 1.0)))
    (found,) = [each for each in decisions if each.signal.startswith(kind)]
    assert (found.signal, found.applied) == (name, True)
    assert "does not move with the other wheels" in found.found
    assert name not in fixed
    assert {f"{kind}_{w}" for w in WHEELS if w != dead} <= set(fixed)


@pytest.mark.parametrize("size", [0.05, 3.0])
@pytest.mark.parametrize("kind", ["accel_z_unsprung", "accel_z_sprung"])
def test_accelerations_that_are_as_lively_as_their_axle_stay(kind: str, size: float) -> None:
    fixed, decisions = check(with_accelerations(kind, size))
    assert {f"{kind}_{w}" for w in WHEELS} <= set(fixed)
    assert not [each for each in decisions if each.signal.startswith(kind)]


@pytest.mark.parametrize("noise", [0.0, 0.0002])
@pytest.mark.parametrize("since", [0.0, 0.5])
def test_a_dead_or_frozen_wheel_is_left_out_with_its_time(since: float, noise: float) -> None:
    fixed, decisions = check(hold(with_wheels(), RR, (since, 1.0), noise))
    (found,) = [each for each in decisions if each.signal == RR]
    assert found.applied
    assert RR not in fixed
    assert {f"suspension_deflection_{w}" for w in ("fl", "fr", "rl")} <= set(fixed)
    assert f"from {100 * since:.0f} s on" in found.found or f"from {100 * since + 5:.0f} s on" in found.found
    assert "other wheels" in found.evidence


def test_what_is_too_short_to_matter_stays_and_is_named() -> None:
    seconds = 400.0
    fixed, decisions = check(hold(with_wheels(seconds), RR, (0.5, 0.57)))
    (found,) = [each for each in decisions if each.signal == RR]
    assert not found.applied
    assert RR in fixed


def test_wheels_that_hardly_move_say_nothing() -> None:
    fixed, _ = check(hold(with_wheels(size=0.0003), RR, (0.0, 1.0)))
    assert RR in fixed


def test_two_axles_that_differ_by_less_than_the_limit_are_healthy() -> None:
    fixed, _ = check(with_wheels(rear=2 * IDLE))
    assert RR in fixed


@pytest.mark.parametrize("name", ["roll", "accel_y", "yaw_rate", "pitch"])
def test_a_signal_that_repeats_one_value_is_left_out(name: str) -> None:
    fixed, decisions = check(hold(drive(seconds=100), name, (0.4, 1.0)))
    found = [each for each in decisions if each.signal == name and "keeps the value" in each.found]
    assert len(found) == 1
    assert found[0].applied
    assert name not in fixed


def test_steps_and_slow_updates_are_no_frozen_signals() -> None:
    """A roll angle in steps of a tenth of a degree on a straight, and axle loads that are renewed once in two seconds."""
    signals = drive(seconds=100)
    coarse = np.deg2rad(0.1) * np.round(np.rad2deg(signals["roll"].values) / 0.1)
    time_ns = signals["roll"].time_ns
    load = 8000 + 300 * np.random.default_rng(4).standard_normal(60)
    held = load[((time_ns - time_ns[0]) // (2 * NS)).astype(int)]
    signals |= {"roll": replace(signals["roll"], values=coarse)}
    signals |= {n: Signal(n, time_ns, held, n) for n in ("axle_load_front", "axle_load_rear")}
    fixed, decisions = check(signals)
    assert {"roll", "axle_load_front", "axle_load_rear"} <= set(fixed)
    assert not [each for each in decisions if "keeps the value" in each.found]


def test_a_signal_that_stands_for_a_fifth_of_a_short_log_is_left_out() -> None:
    fixed, decisions = check(hold(drive(seconds=45), "roll", (0.33, 0.53)))
    assert [each.signal for each in decisions if "keeps the value" in each.found] == ["roll"]
    assert "roll" not in fixed


@pytest.mark.parametrize("share", [(0.0, 1.0), (0.1, 0.9)])
def test_a_speed_that_stands_still_while_the_wheels_change_is_left_out(share: tuple[float, float]) -> None:
    """It is not said to be of another unit, and no sign is judged by it."""
    fixed, decisions = check(hold(drive("slalom", seconds=100), "speed", share))
    (found,) = [each for each in decisions if each.signal == "speed"]
    assert "does not move with the wheels" in found.found
    assert "speed" not in fixed
    assert not [each for each in decisions if each.kind in ("unit", "sign")]


COARSE = [("yaw_rate", 0.025), ("roll", 0.01), ("roll_rate", 0.03), ("accel_y", 1.0)]


def with_a_straight(name: str, step: float) -> dict[str, Signal]:
    """Six minutes of bends but for 70 s of straight road in the middle, and one signal in coarse steps."""
    t = times(360)
    yaw = 0.12 * np.sin(2 * np.pi * t / 9) * (1 + 0.5 * np.sin(2 * np.pi * t / 47)) * ((t < 150) | (t > 220))
    signals = kinematic(20 + 4 * np.sin(2 * np.pi * t / 50), yaw)
    coarse = step * np.round(signals[name].values / step)
    return signals | {name: replace(signals[name], values=coarse)}


@pytest.mark.parametrize(("name", "step"), COARSE)
def test_coarse_steps_on_a_straight_are_no_frozen_sensor(name: str, step: float) -> None:
    signals = with_a_straight(name, step)
    inside = signals[name].values[round(160 * HZ) : round(210 * HZ)]
    assert np.ptp(inside) < 1.5 * step
    fixed, decisions = check(signals)
    assert name in fixed
    assert not [each for each in decisions if "keeps the value" in each.found]


@pytest.mark.parametrize(("name", "step"), [each for each in COARSE if each[0] != "roll_rate"])
def test_a_coarse_sensor_that_freezes_in_bends_is_left_out(name: str, step: float) -> None:
    fixed, decisions = check(hold(with_a_straight(name, step), name, (0.7, 1.0)))
    (found,) = [each for each in decisions if "keeps the value" in each.found]
    assert found.applied
    assert name not in fixed


def test_an_inertial_unit_that_freezes_altogether_is_left_out() -> None:
    signals = only(drive(seconds=100), "accel_x", "accel_y", "accel_z", "roll_rate", "yaw_rate", "speed")
    unit = set(signals) - {"speed"}
    for name in unit:
        signals = hold(signals, name, (0.5, 1.0))
    assert not unit & set(check(signals)[0])


@pytest.mark.parametrize("since", [0.0, 0.4, 0.6, 0.97])
def test_four_wheels_that_freeze_at_once_are_seen_by_how_the_body_is_shaken(since: float) -> None:
    """A recorder that goes on sending the last values: no wheel is unlike the others. One that never moved is told by what never changes."""
    signals = with_wheels(seconds=150.0)
    for wheel in WHEELS:
        signals = hold(signals, f"suspension_deflection_{wheel}", (since, 1.0), 1e-5)
    fixed, decisions = check(signals)
    found = [each for each in decisions if "does not move with the body" in each.found]
    if since in (0.4, 0.6):
        assert {each.signal for each in found} == {f"suspension_deflection_{w}" for w in WHEELS}
        assert all(each.applied for each in found)
        assert not any(name.startswith("suspension_deflection") for name in fixed)
        assert f"from {150 * since:.0f} s on" in found[0].found
    else:
        assert not found
