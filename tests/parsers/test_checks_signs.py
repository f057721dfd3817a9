"""Wrong signs that were planted are found and repaired."""

from dataclasses import replace

import numpy as np
import pytest
from check_drives import check, drive, found, only, same, scaled

from parsers.checks import unchecked

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


@pytest.mark.parametrize("more", [("roll",), ("roll", "pitch", "pitch_rate")])
def test_yaw_rate_turns_with_the_other_axes_without_a_speed(more):
    signals = only(drive(), "accel_x", "accel_y", "accel_z", "yaw_rate", "roll_rate", *more)
    down = {n: -1 for n in ("accel_y", "accel_z", "yaw_rate", "pitch", "pitch_rate") if n in signals}
    fixed, decisions = check(scaled(signals, **down))
    assert found(decisions, "sign") >= {"accel_y", "accel_z", "yaw_rate"}
    assert same(fixed, signals)
    assert not any("× speed" in f"{each.found} {each.evidence}" for each in decisions)


def test_a_yaw_rate_that_goes_with_no_turned_axis_is_named():
    signals = only(drive(), "accel_y", "accel_z", "roll", "yaw_rate")
    noise = np.random.default_rng(3).normal(0, 0.2, len(signals["yaw_rate"].values))
    signals |= {"yaw_rate": replace(signals["yaw_rate"], values=noise)}
    wrong = scaled(signals, accel_y=-1, accel_z=-1)
    _, decisions = check(wrong)
    assert found(decisions, "sign") == {"accel_y", "accel_z"}
    assert any(text.startswith("sign of yaw_rate") for text in unchecked(wrong, {}))


def test_pitch_turns_with_the_other_axes_where_the_drive_cannot_tell_its_sign():
    signals = only(drive("circle"), "accel_y", "accel_z", "yaw_rate", "roll", "speed", "pitch", "pitch_rate")
    turned = scaled(signals, accel_y=-1, yaw_rate=-1, accel_z=-1, pitch=-1, pitch_rate=-1)
    fixed, decisions = check(turned)
    assert found(decisions, "sign") >= {"pitch", "pitch_rate"}
    assert same(fixed, signals)
    assert any("axes of SAE J670, in which nose up" in each.found for each in decisions)


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


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_sign_of_pitch_is_told_in_hills_by_its_quick_changes(sign):
    signals = drive()
    seconds = (signals["pitch"].time_ns - signals["pitch"].time_ns[0]) / 1e9
    grade = 0.05 * np.sin(2 * np.pi * seconds / 70)
    pitch, forward = signals["pitch"], signals["accel_x"]
    signals |= {
        "pitch": replace(pitch, values=pitch.values - grade),
        "accel_x": replace(forward, values=forward.values + 9.81 * grade),
    }
    plain = np.corrcoef(signals["pitch"].values, signals["accel_x"].values)[0, 1]
    assert abs(plain) < 0.65
    fixed, decisions = check(scaled(signals, pitch=sign))
    assert ("pitch" in found(decisions, "sign")) is (sign < 0)
    assert np.array_equal(fixed["pitch"].values, signals["pitch"].values)
    assert all(
        "changes of both" in each.evidence
        for each in decisions
        if each.signal == "pitch" and each.kind == "sign"
    )


@pytest.mark.parametrize("names", [("speed",), ("speed", "wheel_speed_rl", "wheel_speed_rr")])
@pytest.mark.parametrize("kept", [("roll", "steering_wheel_angle"), ()])
def test_a_speed_that_is_negative_all_the_way_is_inverted_and_nothing_else(names, kept):
    signals = only(drive(), "accel_x", "accel_y", "accel_z", "yaw_rate", "roll_rate", *names, *kept)
    fixed, decisions = check(scaled(signals, **dict.fromkeys(names, -1.0)))
    assert found(decisions, "sign") == set(names)
    assert same(fixed, signals)


def test_a_drive_in_reverse_gear_keeps_its_sign():
    signals = only(drive(speed=8.0), "accel_x", "accel_y", "accel_z", "yaw_rate", "speed")
    back = scaled(signals, speed=-1.0, yaw_rate=-1.0)
    assert "speed" not in found(check(back)[1], "sign")
