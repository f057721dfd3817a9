"""Checks against physics: faults that were planted are found, healthy drives yield nothing."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from parsers.checks import check_signals, unchecked
from parsers.drive import Signal
from parsers.load import load_drive

RATE = 50.0
NS = 1_000_000_000
DEG = np.pi / 180
G = 9.80665


def drive(kind="slalom", **options):
    """Signals of a drive; a new dictionary each time."""
    return dict(made_drive(kind, **options))


@cache
def made_drive(kind, seconds=60.0, noise=1.0, seed=1, speed=20.0):
    """A simple car: lagged yaw from steering, second-order roll, path, wheels; SI and ISO 8855."""
    rng = np.random.default_rng(seed)
    step = 1 / RATE
    t = np.arange(0, seconds, step)
    v = np.full(len(t), speed)
    steer = np.zeros(len(t))
    if kind == "slalom":
        v = speed + 4 * np.sin(2 * np.pi * t / 25) + 1.5 * np.sin(2 * np.pi * t / 7)
        steer = 0.6 * np.sin(2 * np.pi * 0.4 * t) * (t > 4)
    elif kind == "circle":
        steer = np.clip((t - 5) * 0.2, 0, 0.9)
    elif kind == "step":
        steer = 1.2 * (t > 10) * (t < 25) - 1.2 * (t > 35) * (t < 50)
    elif kind == "dwell":
        phase = (t - 10) * 0.7
        wave = np.where(phase < 0.75, np.sin(2 * np.pi * phase), -1.0)
        held_for = 0.75 + 0.5 * 0.7
        wave = np.where(phase > held_for, np.sin(2 * np.pi * (phase - 0.35)), wave)
        steer = 270 * DEG * wave * (phase > 0) * (phase < 1.35)
    elif kind == "brake":
        v = np.clip(30 - 9 * np.clip(t - 10, 0, 3), 2, None) + np.clip(t - 20, 0, 8) * 2.5
    gain = v / (16 * (2.7 + 0.003 * v**2))
    yaw = np.zeros(len(t))
    for k in range(1, len(t)):
        yaw[k] = yaw[k - 1] + step / 0.15 * (gain[k] * steer[k] - yaw[k - 1])
    lateral = v * yaw
    lateral = 8.5 * np.tanh(lateral / 8.5)
    yaw = lateral / v
    forward = np.gradient(v, step)
    roll, rate = np.zeros(len(t)), np.zeros(len(t))
    for k in range(1, len(t)):
        rate[k] = rate[k - 1] + step * (81 * (0.007 * lateral[k] - roll[k - 1]) - 6 * rate[k - 1])
        roll[k] = roll[k - 1] + step * rate[k]
    pitch = -0.004 * forward
    heading = np.cumsum(yaw) * step
    north, east = np.cumsum(v * np.sin(heading)) * step, np.cumsum(v * np.cos(heading)) * step
    made = {
        "accel_x": (forward, 0.15),
        "accel_y": (lateral + G * np.sin(roll), 0.15),
        "accel_z": (np.full(len(t), G), 0.3),
        "roll_rate": (rate, 0.006),
        "pitch_rate": (np.gradient(pitch, step), 0.006),
        "yaw_rate": (yaw, 0.003),
        "roll": (roll, 0.0005),
        "pitch": (pitch, 0.0005),
        "speed": (v, 0.03),
        "steering_wheel_angle": (steer, 0.002),
        "wheel_speed_rl": (v - 0.75 * yaw, 0.03),
        "wheel_speed_rr": (v + 0.75 * yaw, 0.03),
    }
    start = 1_700_000_000 * NS
    signals = {}
    for place, (name, (values, sigma)) in enumerate(made.items()):
        stamps = start + (t * NS).astype(np.int64) + place * 1_300_000 + rng.integers(0, 400_000, len(t))
        signals[name] = Signal(
            name, stamps, values + noise * sigma * rng.standard_normal(len(t)), name, group="bus"
        )
    thin = slice(None, None, 10)  # satellites at 5 Hz
    stamps = start + (t[thin] * NS).astype(np.int64)
    latitude = 52 + np.rad2deg(north[thin] / 6_371_000)
    longitude = 13 + np.rad2deg(east[thin] / (6_371_000 * np.cos(52 * DEG)))
    signals["latitude"] = Signal("latitude", stamps, latitude, "latitude", group="gps")
    signals["longitude"] = Signal("longitude", stamps, longitude, "longitude", group="gps")
    return signals


def only(signals, *names):
    return {name: signals[name] for name in names}


def scaled(signals, **factors):
    return signals | {
        name: replace(signals[name], values=signals[name].values * f) for name, f in factors.items()
    }


def found(decisions, kind):
    return {each.signal for each in decisions if each.kind == kind}


def check(signals, stated=True, fix=True):
    return check_signals(signals, fix=fix, units_stated=dict.fromkeys(signals, stated))


def same(one, other):
    return set(one) == set(other) and all(
        np.array_equal(one[n].values, other[n].values) and np.array_equal(one[n].time_ns, other[n].time_ns)
        for n in one
    )


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


SIGNS = ["accel_x", "accel_y", "yaw_rate", "roll", "pitch", "roll_rate", "steering_wheel_angle", "accel_z"]


@pytest.mark.parametrize("name", SIGNS)
def test_one_wrong_sign_is_found_and_repaired(name):
    signals = drive()
    fixed, decisions = check(scaled(signals, **{name: -1.0}))
    assert found(decisions, "sign") == {name}
    assert all(each.applied for each in decisions)
    assert same(fixed, signals)


def test_the_frame_of_the_real_log_is_found():
    """Yaw rate and roll angle turned, roll rate right: as Racelogic's box gives them."""
    signals = drive()
    fixed, decisions = check(scaled(signals, yaw_rate=-1, roll=-1))
    assert found(decisions, "sign") == {"yaw_rate", "roll"}
    assert same(fixed, signals)


def test_z_down_axes_are_found():
    """SAE J670e: y right, z down; a left turn has negative accel_y and yaw rate; accel_z is -9.81 at rest."""
    signals = drive()
    turned = scaled(
        signals, accel_y=-1, yaw_rate=-1, pitch=-1, pitch_rate=-1, accel_z=-1, steering_wheel_angle=-1
    )
    fixed, decisions = check(turned)
    expected = {"accel_y", "yaw_rate", "pitch", "accel_z", "steering_wheel_angle"}
    assert found(decisions, "sign") - {"pitch_rate"} == expected
    for name in expected:
        assert np.array_equal(fixed[name].values, signals[name].values)


def test_z_down_axes_are_found_without_satellites():
    signals = only(drive(), "accel_y", "accel_z", "yaw_rate", "roll", "speed")
    fixed, decisions = check(scaled(signals, accel_y=-1, yaw_rate=-1, accel_z=-1))
    assert found(decisions, "sign") == {"accel_y", "yaw_rate", "accel_z"}
    assert same(fixed, signals)


def test_two_signals_that_disagree_are_settled_by_convention():
    signals = only(drive(), "accel_y", "yaw_rate", "speed")
    fixed, decisions = check(scaled(signals, accel_y=-1))
    (one,) = decisions
    assert (one.signal, one.kind, one.applied) == ("yaw_rate", "sign", True)
    assert "by convention" in one.action
    assert np.array_equal(fixed["yaw_rate"].values, -signals["yaw_rate"].values)


def test_roll_and_yaw_without_lateral_acceleration():
    signals = only(drive(), "yaw_rate", "speed", "roll", "roll_rate")
    fixed, decisions = check(scaled(signals, roll=-1, roll_rate=-1))
    assert found(decisions, "sign") == {"roll", "roll_rate"}
    assert same(fixed, signals)


def test_deflections_that_count_extension_are_turned():
    signals = drive()
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        name = f"suspension_deflection_{wheel}"
        values = -side * 0.75 * signals["roll"].values
        signals[name] = replace(signals["roll"], name=name, values=values)
    fixed, decisions = check(signals)
    assert found(decisions, "sign") == {"suspension_deflection_fl"}
    turned = fixed["suspension_deflection_fr"].values
    assert np.array_equal(turned, -signals["suspension_deflection_fr"].values)


UNITS = {
    "yaw_rate": 1 / DEG,
    "accel_y": 1 / G,
    "accel_x": 1 / G,
    "accel_z": 1 / G,
    "roll": 1 / DEG,
    "roll_rate": 1 / DEG,
    "speed": 3.6,
    "steering_wheel_angle": 1 / DEG,
}


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("name", list(UNITS))
def test_one_wrong_unit_is_found_and_repaired(name, stated):
    signals = {n: replace(s, group=n) for n, s in drive().items()}
    fixed, decisions = check(scaled(signals, **{name: UNITS[name]}), stated)
    assert found(decisions, "unit") == {name}
    assert len(decisions) == 1
    assert decisions[0].applied
    assert np.allclose(fixed[name].values, signals[name].values)


def test_an_imu_in_degrees_and_g_is_repaired_whole():
    signals = drive()
    names = ("roll_rate", "pitch_rate", "yaw_rate")
    wrong = scaled(signals, **dict.fromkeys(names, 1 / DEG), accel_x=1 / G, accel_y=1 / G, accel_z=1 / G)
    fixed, decisions = check(wrong)
    assert found(decisions, "unit") == {*names, "accel_x", "accel_y", "accel_z"}
    assert all(np.allclose(fixed[n].values, signals[n].values) for n in signals)


@pytest.mark.parametrize(
    "few", [("accel_y", "yaw_rate", "speed", "accel_z"), ("accel_y", "yaw_rate", "speed", "roll")]
)
def test_degrees_per_second_are_found_with_few_signals(few):
    signals = only(drive(), *few)
    fixed, decisions = check(scaled(signals, yaw_rate=1 / DEG))
    assert found(decisions, "unit") == {"yaw_rate"}
    assert all(np.allclose(fixed[n].values, signals[n].values) for n in few)


@pytest.mark.parametrize("kind", ["slalom", "circle", "step", "dwell"])
def test_wrong_sign_and_wrong_unit_together(kind):
    signals = drive(kind)
    wrong = scaled({n: replace(s, group=n) for n, s in signals.items()}, yaw_rate=-1 / DEG, roll=-1 / DEG)
    fixed, decisions = check(wrong)
    assert found(decisions, "unit") == {"yaw_rate", "roll"}
    assert found(decisions, "sign") == {"yaw_rate", "roll"}
    assert all(np.allclose(fixed[n].values, signals[n].values) for n in signals)


def test_a_factor_that_is_no_unit_is_said_and_left():
    wrong = scaled({n: replace(s, group=n) for n, s in drive().items()}, yaw_rate=5.5)
    fixed, decisions = check(wrong)
    assert found(decisions, "scale") == {"accel_y"}
    assert not any(each.applied for each in decisions)
    assert same(fixed, wrong)


def test_a_factor_that_is_only_near_a_unit_is_said_and_left():
    wrong = scaled(only(drive(), "accel_y", "yaw_rate", "speed"), yaw_rate=5.5)
    fixed, decisions = check(wrong)
    assert [(each.signal, each.kind, each.applied) for each in decisions] == [("speed", "unit", False)]
    assert same(fixed, wrong)


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


def test_a_signal_that_is_impossible_throughout_is_left_and_said():
    t = np.arange(0, 10 * NS, NS // 10)
    signals = {"altitude": Signal("altitude", t, np.full(len(t), 50_000.0), "alt")}
    fixed, decisions = check(signals)
    assert found(decisions, "range") == {"altitude"}
    assert same(fixed, signals)


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


LOGS = Path(__file__).resolve().parents[3] / "shared" / "real_logs"


def real(name):
    path = LOGS / name
    if not path.exists():
        pytest.skip(f"{name} is not beside this repository")
    return load_drive([path])


def test_the_real_slalom():
    """Racelogic's box on a Volvo V40: what the log's README names, and nothing else."""
    record = real("volvo_v40_slalom_35kph.vbo").record
    made = {(each.signal, each.kind, each.applied) for each in record.decisions}
    assert made == {
        ("steering_wheel_angle", "spikes", True),
        ("yaw_rate", "sign", True),
        ("roll", "sign", True),
        ("pitch", "range", True),
        ("roll_rate", "offset", False),
        ("roll", "offset", False),
    }
    (offset,) = (each for each in record.decisions if (each.signal, each.kind) == ("roll_rate", "offset"))
    assert float(offset.found.split()[-2]) == pytest.approx(0.36, abs=0.03)


def test_the_real_standstill():
    record = real("volvo_v40_standstill.vbo").record
    made = {(each.signal, each.kind) for each in record.decisions}
    assert made == {("steering_wheel_angle", "spikes"), ("roll_rate", "offset")}


@pytest.mark.parametrize("name", ["husky_imu_odometry.bag", "truck_j1939.mf4"])
def test_the_real_robot_and_truck_are_left_alone(name):
    assert real(name).record.decisions == ()
