"""A place that slopes, where the drive begins, is not the sensors' zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from roll_plane import RATE, G, Plane, drive, log_of, ride, slalom, turn, vehicle, verdict

from parsers.drive import Drive
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.rollover import assess_rollover
from pipelines.rollover.motion import prepare_motion
from pipelines.rollover.zero import DRIVEN_STD_G, PLACE_STD_G, UNKNOWN_STD_G, accel_zero, angle_zero
from pipelines.rollover_results import Rollover

PLANE = Plane()
KERB = np.radians(3.0)
LATERAL = np.concatenate((np.zeros(round(30 * RATE)), slalom(0.6)))


def parked(kerb: float, **more: FloatArray) -> Drive:
    """A drive whose first stand leans by `kerb`, then 27 s straight on, then a slalom."""
    slope = np.where(np.arange(len(LATERAL)) < 2.9 * RATE, kerb, 0.0)
    motion = ride(PLANE, LATERAL)
    # as it stood: gravity's part in the accelerometer, the angle against the horizon
    stood = replace(motion, accel_y=motion.accel_y + G * np.sin(slope))
    log = log_of(stood, forces=False)
    columns = {name: signal.values for name, signal in log.signals.items()}
    columns |= {"roll": motion.roll + slope, "roll_rate": motion.rate, "yaw_rate": LATERAL / 15.0} | more
    return drive(columns)


def assessed(log: Drive, **changes: ParameterEstimate) -> Rollover:
    return assess_rollover(verdict(PLANE, 0.01, **changes), vehicle(PLANE), log)


@pytest.mark.parametrize("kerb", [KERB, -KERB])
def test_the_peak_does_not_move_with_the_parking_place(kerb: float) -> None:
    level, sloped = assessed(parked(0.0)), assessed(parked(kerb))
    assert level.peak_lateral_acceleration_g is not None
    assert sloped.peak_lateral_acceleration_g == pytest.approx(level.peak_lateral_acceleration_g, abs=0.003)
    for before, after in zip(level.turns, sloped.turns, strict=True):
        assert before.least_margin_g is not None
        assert after.least_margin_g is not None
        assert after.least_margin_g.value == pytest.approx(before.least_margin_g.value, abs=0.003)


def test_a_measured_angle_has_its_zero_of_straight_driving_as_well() -> None:
    """Without a roll gradient the angle against the horizon is all there is: 3 degrees were in every limit."""
    nothing = ParameterEstimate("roll_gradient_degpg", None, None, None, None, "not_identifiable", "nobody")
    level, sloped = (
        assessed(parked(kerb), roll_gradient_degpg=nothing).turns[0].least_margin_g for kerb in (0.0, KERB)
    )
    assert level is not None
    assert sloped is not None
    assert sloped.value == pytest.approx(level.value, abs=0.003)


def test_the_zeros() -> None:
    prepared = prepare_motion(parked(KERB))
    zero, std, how = accel_zero(prepared)
    assert zero == pytest.approx(0.0, abs=0.02)
    assert std == DRIVEN_STD_G
    assert "straight driving" in how
    angle, sloped = angle_zero(prepared, prepared.columns["accel_y"], prepared.columns["roll"])
    assert angle == pytest.approx(0.0, abs=2e-3)
    assert not sloped


def test_without_straight_driving_the_place_is_in_the_spread() -> None:
    motion = ride(PLANE, turn(0.5, 0.5))
    signals = {n: s.values for n, s in log_of(motion, forces=False).signals.items()}
    turning = np.where(signals["speed"] > 0, 0.3, 0.0)
    prepared = prepare_motion(drive(signals | {"yaw_rate": turning}))
    _, std, how = accel_zero(prepared)
    assert std == pytest.approx(PLACE_STD_G, rel=0.01)
    assert "standstill" in how
    short = replace(prepared, columns={**prepared.columns, "speed": np.zeros(len(prepared.time_s))})
    assert angle_zero(short, short.columns["accel_y"], short.columns["roll"])[1]


def test_a_yaw_rate_that_is_dead_makes_no_straight_driving() -> None:
    """A circle of 0.5 g with no yaw rate at all is not an offset of 0.5 g."""
    circle = np.where(np.arange(len(LATERAL)) > 3 * RATE, 0.5 * G, 0.0)
    log = parked(0.0, accel_y=circle, yaw_rate=np.zeros(len(circle)))
    zero, std, _ = accel_zero(prepare_motion(log))
    assert zero == pytest.approx(0.0, abs=0.02)
    assert std == pytest.approx(PLACE_STD_G, rel=0.01)


def test_without_a_stand_and_without_a_speed_nothing_is_known() -> None:
    prepared = prepare_motion(drive({"accel_y": LATERAL}))
    assert accel_zero(prepared)[:2] == (0.0, UNKNOWN_STD_G)
    angle, sloped = angle_zero(prepared, LATERAL[: len(prepared.time_s)], np.full(len(prepared.time_s), 0.1))
    assert (angle, sloped) == (0.1, False)
