"""Signs of roll and pitch by what moves the body, on hills and banked roads too: a right rate is not turned to suit a wrong angle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import G, check, drive, found, only, same, scaled

from parsers.checks import unchecked
from parsers.drive import Signal

STEP = 1 / 50
PITCH, ROLL = ("pitch", "pitch_rate"), ("roll", "roll_rate")


def hilly(*, pedals: float = 1.0) -> dict[str, Signal]:
    """A drive whose roads bank and rise by more than the body leans and nods, within some seconds. pedals: how hard they are pressed."""
    signals = drive(seconds=180.0)
    t = np.arange(len(signals["roll"].values)) * STEP
    pushed = pedals * 2.5 * np.sin(2 * np.pi * t / 5) * np.sin(2 * np.pi * t / 23)
    bank, hill = 0.06 * np.sin(2 * np.pi * t / 17), 0.05 * np.sin(2 * np.pi * t / 19)
    rng = np.random.default_rng(8)
    noise = {name: 0.002 * rng.standard_normal(len(t)) for name in ("roll_rate", "pitch_rate", "accel_x")}
    roll, pitch = signals["roll"].values + bank, -0.005 * pushed + hill
    made = {
        "accel_x": pushed - G * np.sin(hill),
        "accel_y": signals["accel_y"].values + G * np.sin(bank),
        "speed": 20 + np.cumsum(pushed) * STEP,
        "roll": roll,
        "pitch": pitch,
        "roll_rate": np.gradient(roll, STEP),
        "pitch_rate": np.gradient(pitch, STEP),
    }
    wave = {n: replace(signals[n], values=v + noise.get(n, 0.0)) for n, v in made.items()}
    return only(signals, "accel_z", "yaw_rate", "steering_wheel_angle") | wave


@pytest.mark.parametrize(
    "names", [(), ("roll",), ("roll_rate",), ROLL, ("pitch",), ("pitch_rate",), PITCH, ("roll", "pitch_rate")]
)
def test_each_sign_is_told_by_what_moves_the_body(names: tuple[str, ...]) -> None:
    signals = hilly()
    fixed, decisions = check(scaled(signals, **dict.fromkeys(names, -1.0)))
    assert found(decisions, "sign") == set(names)
    assert same(fixed, signals)


@pytest.mark.parametrize("names", [(), PITCH])
def test_where_nothing_tells_angle_and_rate_are_both_listed(names: tuple[str, ...]) -> None:
    signals = scaled(hilly(pedals=0.0), **dict.fromkeys(names, -1.0))
    assert not found(check(signals)[1], "sign") & set(PITCH)
    said = unchecked(signals, {})
    assert {text.split(":")[0] for text in said} >= {"sign of pitch", "sign of pitch_rate"}


@pytest.mark.parametrize("name", PITCH)
def test_a_contradiction_that_nothing_decides_is_said_and_left(name: str) -> None:
    signals = scaled(hilly(pedals=0.0), **{name: -1.0})
    fixed, decisions = check(signals)
    (said,) = [each for each in decisions if each.signal == "pitch_rate" and each.kind == "sign"]
    assert not said.applied
    assert "opposite to the change of pitch" in said.found
    assert same(fixed, signals)


@pytest.mark.parametrize("names", [(), ("pitch",), ("pitch_rate",), PITCH])
def test_a_rate_that_the_springs_tell_tells_its_angle(names: tuple[str, ...]) -> None:
    """Without an acceleration along, nothing tells the sign of pitch by itself."""
    signals = only(drive("brake"), "accel_z", "speed", *PITCH)
    for wheel, end in (("fl", 1), ("fr", 1), ("rl", -1), ("rr", -1)):
        name = f"suspension_deflection_{wheel}"
        signals[name] = replace(
            signals["pitch"], name=name, source=name, values=0.01 + end * 1.3 * signals["pitch"].values
        )
    wrong = scaled(signals, **dict.fromkeys(names, -1.0))
    assert same(check(wrong)[0], signals)
    assert not any("pitch" in text for text in unchecked(wrong, {}))


def test_a_rate_that_goes_with_nothing_is_said_to_be_turned_by_other_things() -> None:
    """A lively gyro beside a lively acceleration that it does not follow, as on roads that bank: not a drive that moves too little."""
    signals = hilly()
    for name in ("roll", "pitch"):
        del signals[name]
    lively = 0.1 * np.random.default_rng(4).standard_normal(len(signals["roll_rate"].values))
    signals["roll_rate"] = replace(signals["roll_rate"], values=lively)
    (said,) = (text for text in unchecked(signals, {}) if text.startswith("sign of roll_rate"))
    assert "it goes clearly with nothing that would tell it (the change of accel_y)" in said


@pytest.mark.parametrize("names", [(), ("pitch_rate",)])
def test_a_stiff_lorry_that_pitches_at_several_hertz(names: tuple[str, ...]) -> None:
    """Its springs show braking as well, and that tells; the accelerometer, high above the pitch axis, feels the quick pitching instead."""
    rng = np.random.default_rng(6)
    t = STEP * np.arange(round(300 / STEP))
    braking = np.convolve(rng.standard_normal(len(t)), np.hanning(round(3 / STEP)), mode="same")
    braking *= 1.2 / braking.std()
    quick = np.sin(2 * np.pi * 3.6 * t + 0.15 * np.cumsum(rng.standard_normal(len(t))) * np.sqrt(STEP / 0.02))
    pitch = -0.008 * braking + 0.008 * quick
    plain = drive("straight", seconds=300.0)
    made = {
        "pitch_rate": np.gradient(pitch, STEP) + 0.002 * rng.standard_normal(len(t)),
        "accel_x": braking - 1.0 * quick,
    } | {
        f"suspension_deflection_{wheel}": (1 if wheel[0] == "f" else -1) * 1.5 * np.roll(pitch, round(0.06 / STEP))
        + 3e-4 * rng.standard_normal(len(t))
        for wheel in ("fl", "fr", "rl", "rr")
    }  # fmt: skip
    signals = {
        name: replace(plain["accel_x"], name=name, time_ns=(t * 1e9).astype(np.int64), values=values)
        for name, values in made.items()
    }
    _, decisions = check(scaled(signals, **dict.fromkeys(names, -1.0)))
    assert found(decisions, "sign") == set(names)


@pytest.mark.parametrize("right", [1.0, -1.0])
def test_a_circuit_that_leans_all_round_turns_no_pitch_rate(right: float) -> None:
    """A gyro that leans by the bank sees ψ' sin φ of the turning, which slows and quickens with the pedals as the pitch does not."""
    signals = drive(seconds=180.0)
    t = np.arange(len(signals["roll"].values)) * STEP
    pushed = 1.2 * np.sin(0.35 * t)
    speed = 14 + np.cumsum(pushed) * STEP
    yaw, pitch = speed / 90, -0.006 * pushed
    rng = np.random.default_rng(9)
    made = {
        "accel_x": pushed + 0.02 * rng.standard_normal(len(t)),
        "accel_y": speed * yaw - G * 0.2,
        "speed": speed,
        "yaw_rate": yaw,
        "pitch_rate": np.gradient(pitch, STEP) + right * yaw * 0.2 + 0.002 * rng.standard_normal(len(t)),
    }
    whole = {n: replace(signals[n], values=v) for n, v in made.items()}
    assert "pitch_rate" not in found(check(whole)[1], "sign")
