"""Units that nobody states: told by size where nothing else can be, said where several could be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import check, drive, found, only, scaled
from test_checks_springs import DEFLECTIONS, sprung

from parsers.checks import check_signals
from parsers.checks.grid import make_grid
from parsers.checks.sizes import pressure_faults
from parsers.drive import Signal

WHEELS = ("wheel_speed_rl", "wheel_speed_rr")


def test_deflections_in_mm() -> None:
    signals = sprung()
    wrong = scaled(signals, **dict.fromkeys(DEFLECTIONS, 1000.0))
    fixed, decisions = check(wrong, stated=False)
    assert {each.signal for each in decisions if each.kind == "unit"} == set(DEFLECTIONS)
    assert all(np.allclose(fixed[name].values, signals[name].values) for name in DEFLECTIONS)
    _, stated = check(wrong)
    assert found(stated, "unit") == set()


@pytest.mark.parametrize("radius", [0.30, 0.33, 0.38])
def test_wheel_speeds_in_turns(radius: float) -> None:
    signals = drive()
    fixed, decisions = check(scaled(signals, **dict.fromkeys(WHEELS, 1 / radius)), stated=False)
    assert found(decisions, "unit") == set(WHEELS)
    assert all("rad/s" in each.found and each.applied for each in decisions if each.kind == "unit")
    assert np.allclose(fixed[WHEELS[0]].values, signals[WHEELS[0]].values, rtol=0.01)


def test_wheel_speeds_of_no_known_unit_are_not_bent_to_fit() -> None:
    """A ratio of 3.1 is near 3.6, but km/h it is not; where the log states m/s it is left alone."""
    fixed, decisions = check(scaled(drive(), **dict.fromkeys(WHEELS, 3.06)))
    assert found([each for each in decisions if each.applied], "unit") == set()
    assert np.mean(fixed[WHEELS[0]].values) == pytest.approx(3.06 * np.mean(drive()[WHEELS[0]].values))


def test_a_speed_in_km_per_hour_is_told_from_miles_and_knots() -> None:
    signals = only(drive(), "accel_x", "accel_y", "yaw_rate", "speed")
    fixed, decisions = check(scaled(signals, speed=3.6))
    (one,) = [each for each in decisions if each.kind == "unit"]
    assert (one.signal, one.applied, one.action) == ("speed", True, "divided by 3.6")
    assert np.allclose(fixed["speed"].values, signals["speed"].values)


def test_what_was_taken_for_si_is_not_said_to_be_si() -> None:
    """The road wheels' angle in rad is no steering-wheel angle, but it was not taken for degrees."""
    signals = only(drive(), "accel_y", "yaw_rate", "speed", "steering_wheel_angle")
    _, decisions = check(scaled(signals, steering_wheel_angle=1 / 16), stated=False)
    assert [(each.kind, each.applied) for each in decisions] == [("range", True)]
    assert "road wheels" in decisions[0].found


@pytest.mark.parametrize("factor", [3.6, 1 / 0.44704])
@pytest.mark.parametrize("beside", [(), ("roll_rate",), ("roll", "roll_rate")])
def test_a_speed_that_no_vehicle_has_is_left_out_where_nothing_tells_its_unit(factor, beside) -> None:
    """`drive("brake")` brakes with 9 m/s² and no more."""
    wrong = scaled(only(drive("brake"), "speed", *beside), speed=factor)
    fixed, decisions = check(wrong, stated=False)
    assert [(each.signal, each.kind, each.applied) for each in decisions] == [("speed", "range", True)]
    assert "km/h or mph" in decisions[0].found
    assert fixed.keys() == set(beside)


@pytest.mark.parametrize("stated", [False, True])
def test_a_speed_in_metres_a_second_and_a_receivers_jump_are_left_alone(stated) -> None:
    signals = only(drive("brake"), "speed")
    values = signals["speed"].values.copy()
    values[1000:] += 20.0
    jumped = {"speed": replace(signals["speed"], values=values)}
    for each in (signals, jumped):
        assert not [d for d in check(each, stated)[1] if d.kind == "range"]


@pytest.mark.parametrize("stated", [False, True])
@pytest.mark.parametrize("beside", [("accel_x", "speed"), ("accel_x",)])
def test_a_brake_pressure_that_is_no_pascals_is_left_out(stated: bool, beside: tuple[str, ...]) -> None:
    signals = only(drive("brake"), *beside)
    braking = np.clip(-signals["accel_x"].values, 0, None) * 1e6
    pressure = replace(signals["accel_x"], name="brake_pressure", values=braking / 1e5)
    wrong = {**signals, "brake_pressure": pressure}
    kept, decisions = check_signals(wrong, fix=True, units_stated={"brake_pressure": stated})
    (one,) = [each for each in decisions if each.signal == "brake_pressure"]
    assert "bar, MPa, kPa or psi" in one.found
    assert one.applied
    assert "brake_pressure" not in kept


@pytest.mark.parametrize(("pascal", "said"), [(3e6, ""), (1e6, ""), (5e5, ""), (1e5, "MPa called bar")])
def test_a_stated_pressure_that_brakes_ten_times_too_well_is_said(pascal: float, said: str) -> None:
    _, decisions = check_signals(_braked(pascal), fix=True, units_stated={})
    found = [each for each in decisions if each.signal == "brake_pressure" and each.kind == "unit"]
    assert [(said in each.found, each.applied) for each in found] == [(True, False)] * bool(said)


def test_a_pressure_that_is_impossible_whenever_it_brakes_is_left_out() -> None:
    signals = _braked(1e7)
    braking = signals["brake_pressure"]
    rest = np.concatenate([braking.values * 3, np.zeros(len(braking.values))])
    time_ns = braking.time_ns[0] + np.arange(len(rest)) * int(np.diff(braking.time_ns)[0])
    signals["brake_pressure"] = replace(braking, time_ns=time_ns, values=rest)
    kept, decisions = check_signals(signals, fix=True, units_stated={})
    share = float(np.mean(rest > 3.5e7))
    assert 0.02 < share < 0.2
    assert "brake_pressure" not in kept
    (one,) = (each for each in decisions if each.signal == "brake_pressure")
    assert "its unit or scale may be wrong" in one.found


@pytest.mark.parametrize(("pascal", "kept"), [(6e4, True), (600.0, False), (0.6, False)])
def test_air_brakes_that_are_hardly_used_are_in_pascals(pascal: float, kept: bool) -> None:
    """A lorry that slows by half a m/s² for a few seconds brakes with 0.3 bar, which is no pressure in kPa or bar."""
    signals = _braked(pascal)
    gently = {name: replace(s, values=0.08 * s.values) for name, s in signals.items() if name != "speed"}
    speed = signals["speed"]
    mean = float(np.mean(speed.values))
    gently["speed"] = replace(speed, values=mean + 0.08 * (speed.values - mean))
    assert 0 < np.ptp(gently["brake_pressure"].values) < 5e4
    left, _ = check_signals(gently, fix=True, units_stated={})
    assert ("brake_pressure" in left) is kept


def test_a_pressure_that_brakes_ten_times_too_badly_is_said() -> None:
    (one,) = pressure_faults(make_grid(_braked(6e6)), {}, [])
    assert "bar called MPa" in one.found
    assert not one.applied
    kept, decisions = check_signals(_braked(6e6), fix=True, units_stated={})
    (left_out,) = (each for each in decisions if each.signal == "brake_pressure")
    assert "brake_pressure" not in kept
    assert "bar called MPa" in left_out.evidence


def _braked(pascal: float) -> dict[str, Signal]:
    """A drive with the pressure, Pa, that slows by 1 m/s² for every `pascal`."""
    signals = drive("brake")
    braking = np.maximum(-signals["accel_x"].values, 0)
    return {
        **signals,
        "brake_pressure": replace(signals["accel_x"], name="brake_pressure", values=braking * pascal),
    }


def _said_of_brakes(signals: dict[str, Signal], **stated: bool) -> list[str]:
    _, decisions = check_signals(signals, fix=True, units_stated=stated)
    return [each.found for each in decisions if each.signal == "brake_pressure"]


@pytest.mark.parametrize("factor", [3.6, 1 / 0.44704])
@pytest.mark.parametrize("fix", [True, False])
def test_a_pressure_is_judged_by_the_speed_whose_unit_is_repaired(factor: float, fix: bool) -> None:
    """km/h called m/s make brakes look 3.6 times too good: of right pressures nothing is said, of wrong ones the true figure."""
    for pascal in (5e5, 1e5):
        wrong = scaled(_braked(pascal), speed=factor)
        _, decisions = check_signals(wrong, fix=fix, units_stated={})
        (speed,) = [each for each in decisions if each.signal == "speed"]
        assert speed.applied is fix
        heard = [each.found for each in decisions if each.signal == "brake_pressure"]
        assert heard == _said_of_brakes(_braked(pascal))
        assert len(heard) == (pascal == 1e5)


def test_a_speed_in_doubt_says_nothing_of_a_pressure() -> None:
    right = only(_braked(4e5), "speed", "brake_pressure", "accel_x")
    assert _said_of_brakes(right) == []
    doubled = scaled(right, speed=2.0)
    _, decisions = check_signals(doubled, fix=True, units_stated={})
    assert [(each.signal, each.applied) for each in decisions] == [("speed", False)]


def test_a_speed_of_no_stated_unit_says_nothing_of_a_pressure_unless_it_is_felt() -> None:
    wrong = scaled(only(_braked(5e5), "speed", "brake_pressure"), speed=3.6)
    assert _said_of_brakes(wrong, speed=False) == []
    felt = only(_braked(1e5), "speed", "brake_pressure", "accel_x")
    assert len(_said_of_brakes(felt, speed=False)) == 1
