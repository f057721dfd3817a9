"""Inertial signals, deflections and forces that are cut off at the end of a range lose those samples; nothing else that stays at an extreme does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import check, drive, same

from parsers.checks.flat_tops import flat_tops
from parsers.drive import Signal


def cut(signals: dict[str, Signal], name: str, low: float, high: float) -> dict[str, Signal]:
    return signals | {name: replace(signals[name], values=np.clip(signals[name].values, low, high))}


@pytest.mark.parametrize(("low", "high"), [(-3.0, 3.0), (-3.0, np.inf), (-np.inf, 3.0)])
def test_what_is_cut_off_is_removed_and_counted(low: float, high: float) -> None:
    signals = drive()
    wrong = cut(signals, "accel_y", low, high)
    values = wrong["accel_y"].values
    away = (values == low) | (values == high)
    fixed, decisions = check(wrong)
    (one,) = decisions
    assert (one.signal, one.applied) == ("accel_y", True)
    assert f"{np.count_nonzero(away)} samples of accel_y stand at its largest value" in one.found
    assert f"{away.mean():.2%}" in one.evidence
    assert np.array_equal(fixed["accel_y"].values, values[~away])
    assert np.array_equal(fixed["accel_y"].time_ns, wrong["accel_y"].time_ns[~away])
    assert same(
        {n: s for n, s in fixed.items() if n != "accel_y"}, {n: s for n, s in wrong.items() if n != "accel_y"}
    )


def test_a_stray_value_does_not_hide_it() -> None:
    wrong = cut(drive(), "roll_rate", -0.05, 0.05)
    values = wrong["roll_rate"].values.copy()
    values[[700, 1900]] = 9.0
    fixed, decisions = check(wrong | {"roll_rate": replace(wrong["roll_rate"], values=values)})
    assert any("cuts it off" in each.found for each in decisions)
    assert float(np.abs(fixed["roll_rate"].values).max()) < 0.05


@pytest.mark.parametrize("top", [0.03, 0.02])
def test_a_deflection_sensor_at_the_end_of_its_range_tells_nothing_there(top: float) -> None:
    """A blind checker's: four wheels cut off at 30 mm, and the roll gradient was 16 % low at six standard deviations."""
    rng = np.random.default_rng(3)
    moves = 0.04 * np.sin(np.arange(6000) / 40) + 0.0004 * rng.standard_normal(6000)
    limits = flat_tops("suspension_deflection_fl", np.minimum(moves, top))
    assert limits is not None
    assert limits.high == top
    # a stop holds the spring, and not the noise; and a sensor without noise may be held by a simulator's stop
    on_stop = np.minimum(0.04 * np.sin(np.arange(6000) / 40), top)
    assert flat_tops("suspension_deflection_fl", on_stop) is None
    assert flat_tops("suspension_deflection_fl", on_stop + 0.0004 * rng.standard_normal(6000)) is None


def test_a_wheel_that_hangs_in_the_air_carries_nothing_and_is_no_limit() -> None:
    rng = np.random.default_rng(4)
    force = np.maximum(3000 * np.sin(np.arange(6000) / 40) + 40 * rng.standard_normal(6000), 0.0)
    assert flat_tops("tire_normal_force_fl", force) is None


@pytest.mark.parametrize("name", ["speed", "steering_wheel_angle", "brake_pressure"])
def test_signals_that_may_stay_at_an_extreme_are_left_alone(name: str) -> None:
    values = np.clip(drive()["accel_y"].values, -3.0, 3.0)
    assert flat_tops("accel_y", values) is not None
    assert flat_tops(name, values) is None


@pytest.mark.parametrize("step", [0.01, 0.05, 0.3, 1.0])
def test_whole_steps_of_a_recorder_are_no_limit(step: float) -> None:
    for kind in ("slalom", "circle", "step", "brake"):
        for name in ("accel_x", "accel_y", "yaw_rate", "roll_rate"):
            size = step * (1 if name.startswith("accel") else 0.1)
            values = np.round(drive(kind)[name].values / size) * size
            assert flat_tops(name, values) is None, (kind, name)


def test_a_simulator_that_holds_its_acceleration_is_left_alone() -> None:
    """Equal brakings, without noise: the vehicle itself stays at its largest value."""
    values = -3.0 * np.clip(1.5 * np.sin(np.arange(6000) / 80.0), 0.0, 1.0)
    assert flat_tops("accel_x", values) is None


@pytest.mark.parametrize(("noise", "found"), [(0.03, True), (0.0, False)])
def test_a_fast_motion_with_noise_is_cut_off_and_one_without_is_held(noise: float, found: bool) -> None:
    """A slalom at 40 Hz: each flank passes within some samples, so that it hardly ever turns round between."""
    rng = np.random.default_rng(0)
    motion = 5.0 * np.sin(2 * np.pi * 0.4 * np.arange(2000) / 40.0)
    values = np.round(np.clip(motion + noise * rng.standard_normal(2000), -3.0, 3.0), 4)
    limits = flat_tops("accel_y", values)
    assert (limits is not None) is found
    assert limits is None or (limits.low, limits.high) == (-3.0, 3.0)
