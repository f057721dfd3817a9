"""Wrong units that were planted are found and repaired; a factor that is no unit is said and left."""

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEG, G, check, drive, found, only, same, scaled

from parsers.checks.check import check_all
from parsers.load import load_drive

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


@pytest.mark.parametrize("kind", ["slalom", "step"])
def test_axes_that_state_another_unit_do_not_share_the_mistake_of_one(kind):
    """Yaw rate in deg/s that is called rad/s, beside roll and pitch rate that are called deg/s and are."""
    signals = only(drive(kind), "accel_x", "accel_y", "yaw_rate", "roll_rate", "pitch_rate", "speed")
    checked = check_all(
        scaled(signals, yaw_rate=1 / DEG),
        fix=True,
        units_stated={},
        units_taken={"yaw_rate": 1.0, "roll_rate": DEG, "pitch_rate": DEG},
    )
    assert found(checked.decisions, "unit") == {"yaw_rate"}
    assert all(np.allclose(checked.signals[name].values, signals[name].values) for name in signals)


def test_the_label_of_a_column_is_the_unit_that_its_axis_was_taken_in(tmp_path):
    signals = only(drive("circle"), "accel_y", "yaw_rate", "roll_rate", "pitch_rate", "speed")
    clock = signals["speed"].time_ns
    t = (clock - clock[0]) / 1e9
    columns = {
        "Time [s]": t,
        "Lateral acceleration [m/s2]": signals["accel_y"].values,
        "Vehicle speed [m/s]": signals["speed"].values,
        "Yaw rate [rad/s]": signals["yaw_rate"].values / DEG,
        "Roll rate [deg/s]": signals["roll_rate"].values / DEG,
        "Pitch rate [deg/s]": signals["pitch_rate"].values / DEG,
    }
    log = tmp_path / "drive.csv"
    rows = np.column_stack(list(columns.values()))
    np.savetxt(log, rows, fmt="%.6f", delimiter=",", header=",".join(columns), comments="")
    loaded = load_drive([log])
    assert found(loaded.record.decisions, "unit") == {"yaw_rate"}
    assert all(
        np.allclose(loaded.signals[n].values, signals[n].values, atol=1e-6)
        for n in ("roll_rate", "pitch_rate")
    )


def test_a_speed_that_cannot_be_does_not_hide_the_units_of_the_others():
    signals = only(drive(), "accel_y", "accel_x", "yaw_rate", "roll_rate", "speed")
    fixed, decisions = check(scaled(signals, speed=3.6e3, yaw_rate=1 / DEG, roll_rate=1 / DEG), stated=False)
    assert "speed" not in fixed
    assert found(decisions, "unit") == {"yaw_rate", "roll_rate"}
    assert np.allclose(fixed["yaw_rate"].values, signals["yaw_rate"].values)


def test_pitch_in_degrees_is_known_by_roll_of_the_same_table():
    signals = only(drive("circle"), "accel_y", "yaw_rate", "speed", "roll", "pitch")
    pitch = replace(signals["pitch"], values=0.04 * np.sin(np.arange(len(signals["pitch"].values)) / 70))
    signals |= {"pitch": pitch}
    fixed, decisions = check(scaled(signals, roll=1 / DEG, pitch=1 / DEG), stated=False)
    assert found(decisions, "unit") == {"roll", "pitch"}
    assert np.allclose(fixed["pitch"].values, pitch.values)


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


@pytest.mark.parametrize(("factor", "repaired"), [(4.72, False), (3.6, True)])
def test_a_speed_is_repaired_where_the_path_bears_it_out_and_else_left(factor, repaired):
    signals = only(drive(), "speed", "latitude", "longitude")
    # half as fast, so that no speed is beyond all roads
    slow = {
        n: replace(s, values=0.5 * s.values + (0 if n == "speed" else 0.5 * s.values[0]))
        for n, s in signals.items()
    }
    fixed, decisions = check(scaled(slow, speed=factor))
    assert ("speed", repaired) in {(each.signal, each.applied) for each in decisions}
    assert np.allclose(fixed["speed"].values, (1.0 if repaired else factor) * slow["speed"].values)


def creeping(signals, metres_per_second):
    """The same drive, whose satellites' place creeps north meanwhile."""
    latitude, longitude = signals["latitude"], signals["longitude"]
    t = (latitude.time_ns - latitude.time_ns[0]) / 1e9
    return signals | {
        "latitude": replace(latitude, values=52 + np.rad2deg(metres_per_second * t / 6_371_000)),
        "longitude": replace(longitude, values=np.full(len(t), 13.0)),
    }


@pytest.mark.parametrize("creep", [1.1, 4.0, 5.5])
@pytest.mark.parametrize("more", [(), ("roll", "pitch"), ("speed",), ("wheel_speed_rl", "wheel_speed_rr")])
def test_a_place_that_creeps_while_the_vehicle_drives_overrules_no_unit(creep, more):
    signals = only(drive(), "accel_x", "accel_y", "yaw_rate", "latitude", "longitude", *more)
    signals = creeping(signals, creep)
    fixed, decisions = check(signals)
    assert not any(each.applied for each in decisions)
    assert same(fixed, signals)


def test_an_axis_is_not_repaired_where_the_one_that_speaks_for_it_is_left():
    signals = only(drive("circle"), "accel_x", "accel_y", "yaw_rate", "speed")
    # 14 is further from g's 9.8 than banked bends explain, and at one speed accel_x has no evidence of its own
    _, decisions = check(scaled(signals, accel_x=14.0, accel_y=14.0))
    assert not any(each.applied and each.kind == "unit" for each in decisions)


def test_the_path_tells_a_unit_where_it_turns_as_the_vehicle_does():
    signals = only(drive(), "accel_x", "accel_y", "yaw_rate", "latitude", "longitude")
    fixed, decisions = check(scaled(signals, accel_x=1 / G, accel_y=1 / G))
    assert found(decisions, "unit") == {"accel_x", "accel_y"}
    assert np.allclose(fixed["accel_x"].values, signals["accel_x"].values)


def held(signals, every_s):
    """The place of each fix in the rows of a 50 Hz table until the next one."""
    rows = signals["speed"].time_ns
    fix = np.searchsorted(rows, rows[0] + ((rows - rows[0]) // int(every_s * 1e9)) * int(every_s * 1e9))
    made = {}
    for name in ("latitude", "longitude"):
        smooth = np.interp(rows, signals[name].time_ns, signals[name].values)
        made[name] = replace(signals[name], time_ns=rows, values=smooth[fix])
    return signals | made


@pytest.mark.parametrize("every_s", [1.0, 0.2])
@pytest.mark.parametrize("others", [("accel_x", "accel_y", "yaw_rate"), ()])
def test_places_held_between_fixes_contradict_no_speed(every_s, others):
    signals = only(held(drive(), every_s), "speed", "latitude", "longitude", *others)
    fixed, decisions = check(signals)
    assert not decisions
    assert same(fixed, signals)


def test_a_path_at_odds_with_a_speed_that_both_accelerations_bear_out_says_nothing_of_its_unit():
    signals = only(drive(), "speed", "latitude", "longitude", "accel_x", "accel_y", "yaw_rate")
    latitude, longitude = signals["latitude"], signals["longitude"]
    far = {
        each.name: replace(each, values=each.values[0] + 1.7 * (each.values - each.values[0]))
        for each in (latitude, longitude)
    }
    assert found(check(signals | far)[1], "unit") == set()
    without = only(signals | far, "speed", "latitude", "longitude")
    assert found(check(without)[1], "unit") == {"speed"}


def test_a_yaw_rate_that_is_off_is_no_matter_of_a_speed_that_is_felt():
    wrong = scaled(only(drive(), "accel_x", "accel_y", "yaw_rate", "speed"), yaw_rate=2.3)
    fixed, decisions = check(wrong)
    (said,) = [each for each in decisions if each.kind in ("unit", "scale")]
    assert (said.signal, said.kind, said.applied) == ("yaw_rate", "scale", False)
    assert "speed is right by accel_x" in said.found
    assert same(fixed, wrong)


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize(
    "few",
    [
        ("steering_wheel_angle", "yaw_rate", "speed"),
        ("steering_wheel_angle", "yaw_rate", "speed", "accel_y"),
        ("steering_wheel_angle", "yaw_rate", "speed", "roll", "roll_rate"),
        ("steering_wheel_angle", "yaw_rate", "speed", "accel_y", "wheel_speed_rl", "wheel_speed_rr", "roll"),
    ],
)
def test_the_angle_of_the_road_wheels_is_left_out_and_costs_no_other_its_unit(few, stated):
    wrong = scaled(only(drive(), *few), steering_wheel_angle=1 / 16)
    fixed, decisions = check(wrong, stated)
    assert [(each.signal, each.kind, each.applied) for each in decisions] == [
        ("steering_wheel_angle", "range", True)
    ]
    assert "angle of the road wheels" in decisions[0].found
    assert fixed.keys() == wrong.keys() - {"steering_wheel_angle"}
    assert all(np.allclose(fixed[name].values, wrong[name].values) for name in fixed)


def test_beside_the_angle_of_the_road_wheels_a_wrong_unit_is_still_found():
    signals = only(drive(), "steering_wheel_angle", "yaw_rate", "speed", "accel_y")
    fixed, decisions = check(scaled(signals, steering_wheel_angle=1 / 16, yaw_rate=1 / DEG))
    assert found(decisions, "unit") == {"yaw_rate"}
    assert found(decisions, "range") == {"steering_wheel_angle"}
    assert np.allclose(fixed["yaw_rate"].values, signals["yaw_rate"].values)


@pytest.mark.parametrize(
    "few",
    [
        ("speed", "accel_y", "roll"),
        ("speed", "accel_y", "yaw_rate", "roll"),
        ("accel_y", "roll", "roll_rate"),
        ("speed", "accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate"),
        ("speed", "accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch"),
    ],
)
def test_a_racing_cars_lean_overrules_no_unit_that_the_log_states(few):
    """0.6 degrees a g; a made drive's is 4."""
    taken = {"accel_x": G, "accel_y": G, "accel_z": G} | dict.fromkeys(
        ("roll", "pitch", "roll_rate", "pitch_rate", "yaw_rate"), DEG
    )
    signals = scaled(only(drive(), *few), **{name: 0.15 for name in few if name.startswith("roll")})
    checked = check_all(signals, fix=True, units_stated={}, units_taken=taken)
    assert not [each for each in checked.decisions if each.kind in ("unit", "scale")]
    assert all(np.allclose(checked.signals[name].values, signals[name].values) for name in few)
