"""Checks against physics: faults that were planted are found, healthy drives yield nothing."""

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEG, NS, G, check, drive, found, same, scaled

from parsers.checks import unchecked
from parsers.drive import Signal


@pytest.mark.parametrize("kind", ["slalom", "circle", "step", "dwell", "brake", "straight"])
@pytest.mark.parametrize("noise", [0.2, 1.0, 4.0])
def test_healthy_drives_yield_nothing(kind, noise):
    signals = drive(kind, noise=noise)
    fixed, decisions = check(signals, stated=False)
    assert decisions == ()
    assert same(fixed, signals)


def test_a_kerb_strike_is_no_spike():
    signals = drive("slalom")
    values = signals["accel_z"].values.copy()
    values[500:505] += [30, 60, -40, 25, -10]
    values[900] += 50
    signals["accel_z"] = replace(signals["accel_z"], values=values)
    rate = signals["roll_rate"].values.copy()
    rate[500:504] += [0.4, 0.8, -0.6, 0.2]
    signals["roll_rate"] = replace(signals["roll_rate"], values=rate)
    assert check(signals)[1] == ()


@pytest.mark.parametrize("name", ["accel_x", "accel_y"])
def test_a_sample_that_jumps_by_six_g_across_is_a_spike(name):
    signals = drive("slalom")
    values = signals[name].values.copy()
    values[[500, 900, 1400]] += 60
    fixed, decisions = check(signals | {name: replace(signals[name], values=values)})
    assert [(each.signal, each.kind) for each in decisions] == [(name, "spikes")]
    assert np.array_equal(fixed[name].values, np.delete(signals[name].values, [500, 900, 1400]))


def with_spikes(signals, name, places, value):
    values = signals[name].values.copy()
    values[places] = value
    return signals | {name: replace(signals[name], values=values)}


def test_steering_spikes_are_removed_and_not_filled():
    signals = drive()
    places = [100, 400, 401, 900, 2000, 2500]
    wrong = with_spikes(signals, "steering_wheel_angle", places, [480, -20, -20, 27.0, -480, 9])
    fixed, decisions = check(wrong)
    assert found(decisions, "spikes") == {"steering_wheel_angle"}
    assert len(decisions) == 2
    assert "27502°" in " ".join(each.evidence for each in decisions)
    kept = np.delete(signals["steering_wheel_angle"].values, places)
    assert np.array_equal(fixed["steering_wheel_angle"].values, kept)
    assert len(fixed["steering_wheel_angle"].time_ns) == len(kept)


def test_no_value_codes_of_a_speed_are_removed():
    signals = drive("brake")
    wrong = with_spikes(signals, "speed", slice(0, 60), 255.996 / 3.6)
    fixed, decisions = check(wrong)
    assert found(decisions, "spikes") == {"speed"}
    assert len(fixed["speed"].values) == len(signals["speed"].values) - 60


def test_spikes_do_not_hide_a_wrong_sign():
    wrong = with_spikes(scaled(drive(), yaw_rate=-1), "yaw_rate", np.arange(50, 2900, 97), 9.0)
    _, decisions = check(wrong)
    assert found(decisions, "sign") == {"yaw_rate"}
    assert found(decisions, "spikes") == {"yaw_rate"}


def test_without_fix_nothing_changes_and_all_is_said():
    wrong = scaled(with_spikes(drive(), "steering_wheel_angle", [9], 30.0), yaw_rate=-1, accel_z=1 / G)
    wrong = {n: replace(s, group=n) for n, s in wrong.items()}
    fixed, decisions = check(wrong, fix=False)
    assert same(fixed, wrong)
    assert {each.kind for each in decisions} == {"sign", "spikes", "unit"}
    assert not any(each.applied for each in decisions)


def test_without_excitation_nothing_is_decided():
    signals = drive("straight", noise=1.0)
    turned = scaled(signals, yaw_rate=-1, roll=-1, roll_rate=-1, accel_x=-1, pitch=-1)
    assert check(turned)[1] == ()
    said = " ".join(unchecked(turned, {"roll": False}))
    for word in ("lateral signs", "accel_x", "pitch", "roll_rate", "unit of roll"):
        assert word in said
    many = unchecked(turned, {"roll": False, "speed": False, "accel_y": False})
    assert sum("the log does not say" in text for text in many) == 1
    assert any(text.startswith("units of accel_y, roll, speed") for text in many)


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_is_no_evidence(seed):
    rng = np.random.default_rng(seed)
    t = np.arange(0, 60 * NS, NS // 50)
    names = ["accel_x", "accel_y", "yaw_rate", "roll", "pitch", "roll_rate", "pitch_rate", "speed"]
    signals = {
        n: Signal(n, t, rng.standard_normal(len(t)) * (0.3 if n[:3] != "spe" else 0) + 0.2, n) for n in names
    }
    _, decisions = check(signals, stated=False)
    assert found(decisions, "sign") | found(decisions, "unit") | found(decisions, "spikes") == set()


def test_gyro_offset_at_standstill_and_on_the_move():
    signals = drive()
    moved = signals["roll_rate"].values + 0.36 * DEG
    signals["roll_rate"] = replace(signals["roll_rate"], values=moved)
    fixed, decisions = check(signals)
    (one,) = decisions
    assert (one.signal, one.kind, one.applied) == ("roll_rate", "offset", False)
    assert float(one.found.split()[-2]) == pytest.approx(0.36, abs=0.005)
    assert np.array_equal(fixed["roll_rate"].values, moved)
    rng = np.random.default_rng(0)
    t = np.arange(0, 20 * NS, NS // 100)
    still = {
        "speed": Signal("speed", t, np.zeros(len(t)), "v"),
        "yaw_rate": Signal("yaw_rate", t, -0.01 + 0.003 * rng.standard_normal(len(t)), "r"),
    }
    (one,) = check(still)[1]
    assert "-0.57" in one.found
    assert "standstill" in one.evidence


@pytest.mark.parametrize("kind", ["slalom", "step"])
def test_a_mounting_offset_of_the_roll_angle_is_said(kind):
    signals = drive(kind)
    signals["roll"] = replace(signals["roll"], values=signals["roll"].values - 1.2 * DEG)
    (one,) = check(signals)[1]
    assert (one.signal, one.kind, one.applied) == ("roll", "offset", False)
    assert float(one.found.split()[-1].rstrip("°")) == pytest.approx(-1.2, abs=0.05)


def test_a_stuck_channel_is_left_out():
    signals = drive()
    signals["pitch"] = replace(signals["pitch"], values=np.zeros(len(signals["pitch"].values)))
    fixed, decisions = check(signals)
    (one,) = decisions
    assert (one.signal, one.kind, one.applied) == ("pitch", "range", True)
    assert "pitch" not in fixed


def test_coarse_steps_are_said():
    signals = drive()
    signals["roll"] = replace(signals["roll"], values=np.round(signals["roll"].values / 0.035) * 0.035)
    assert found(check(signals)[1], "scale") == {"roll"}


def test_a_signal_that_is_impossible_throughout_is_left_out_and_said():
    t = np.arange(0, 10 * NS, NS // 10)
    signals = {
        "altitude": Signal("altitude", t, np.full(len(t), 50_000.0), "alt"),
        "speed": Signal("speed", t, np.linspace(0, 20, len(t)), "v"),
    }
    fixed, decisions = check(signals)
    assert found(decisions, "range") == {"altitude"}
    assert all(each.action.startswith("left out") for each in decisions if each.kind == "range")
    assert same(fixed, {"speed": signals["speed"]})


@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_almost_nothing_is_no_trouble(count):
    t = np.arange(count, dtype=np.int64) * NS
    names = ["accel_y", "yaw_rate", "speed", "roll", "latitude", "longitude", "accel_z"]
    _, decisions = check({n: Signal(n, t, np.full(count, 3.0), n) for n in names})
    assert isinstance(decisions, tuple)
    assert check({}) == ({}, ())


def test_gaps_and_different_rates_are_bridged_only_when_short():
    signals = scaled(drive(), yaw_rate=-1)
    for place, (name, signal) in enumerate(sorted(signals.items())):
        keep = np.arange(len(signal.values)) % (1 + place % 3) == 0
        seconds = (signal.time_ns - signal.time_ns[0]) / NS
        keep &= (seconds < 20) | (seconds > 32)
        signals[name] = replace(signal, time_ns=signal.time_ns[keep], values=signal.values[keep])
    _, decisions = check(signals)
    assert found(decisions, "sign") == {"yaw_rate"}


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_a_vertical_acceleration_without_gravity_is_left_out(up):
    signals = drive("slalom")
    light = replace(signals["accel_z"], values=up * (signals["accel_z"].values - 9.81))
    fixed, decisions = check(signals | {"accel_z": light})
    assert [(each.signal, each.kind, each.applied) for each in decisions] == [("accel_z", "choice", True)]
    assert fixed.keys() == signals.keys() - {"accel_z"}
