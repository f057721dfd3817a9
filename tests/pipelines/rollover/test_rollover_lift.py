"""Wheel lift from tyre forces: turns' lifts found, bounces told apart, sensors' faults passed by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from roll_plane import RATE, Plane, Ride, drive, log_of, ride, slalom, turn, vehicle, verdict

from parsers.drive import Drive
from pipelines.results import FloatArray
from pipelines.rollover import assess_rollover
from pipelines.rollover_results import Rollover

TALL = replace(Plane(), high=1.0, stiffness=120_000.0)
PLANE = Plane()


def assess(plane: Plane, log: Drive) -> Rollover:
    return assess_rollover(verdict(plane), vehicle(plane), log)


def with_forces(found: Ride, changed: dict[str, FloatArray]) -> Drive:
    """The ride's log with noise on the forces, some of them replaced."""
    return log_of(replace(found, force=found.force | changed), noise=1.0)


def lifted_span(found: Ride) -> tuple[float, float]:
    rows = np.flatnonzero(found.coefficient <= -1)
    return float(found.time_s[rows[0]]), float(found.time_s[rows[-1]])


def test_both_wheels_of_the_inner_side() -> None:
    motion = ride(TALL, turn(0.95, 0.4))
    start, end = lifted_span(motion)
    found = assess(TALL, log_of(motion, noise=1.0))
    assert {event.wheel for event in found.lifts} == {"fl", "rl"}
    assert {event.kind for event in found.lifts} == {"side"}
    for event in found.lifts:
        assert event.start_s == pytest.approx(start, abs=0.3)
        assert event.start_s + event.duration_s == pytest.approx(end, abs=0.3)
        assert event.probability > 0.9
        assert event.lateral_acceleration_g is not None
        assert event.lateral_acceleration_g > 0.8
    assert found.exceedance is not None
    assert found.exceedance.probability == found.turns[0].probability
    assert found.turns[0].probability > 0.9
    assert found.turns[1].probability == 0.0
    assert found.coefficient_source.startswith("tyre forces")


def test_one_inner_wheel_alone() -> None:
    motion = ride(PLANE, turn(0.8, 0.3))
    rear = motion.force["rl"] - 0.6 * (motion.force["rl"][0] - motion.force["rl"])
    front = motion.force["fl"] + motion.force["rl"] - np.maximum(rear, 0.0)
    found = assess(PLANE, with_forces(motion, {"rl": np.maximum(rear, 0.0), "fl": front}))
    assert {(event.wheel, event.kind) for event in found.lifts} == {("rl", "wheel")}
    assert found.exceedance is not None
    assert found.exceedance.probability == 0.0
    assert found.exceedance.text == "less than 1 %"


def test_no_lift_in_a_mild_drive() -> None:
    found = assess(PLANE, log_of(ride(PLANE, slalom(0.6)), noise=1.0))
    assert found.lifts == ()
    assert "measured" in found.lift_source
    assert found.check is not None
    assert found.check.consistent
    assert found.check.slope.value == pytest.approx(1.0, abs=0.02)


def test_a_height_that_is_wrong_is_seen_in_the_forces() -> None:
    log = log_of(ride(PLANE, slalom(0.6)), noise=1.0)
    entry = verdict(PLANE)["cg_height_m"]
    assert entry.value is not None
    wrong = replace(
        entry, value=0.85 * entry.value, low=0.84 * entry.value, high=0.86 * entry.value, std=0.005
    )
    found = assess_rollover(verdict(PLANE, cg_height_m=wrong), vehicle(PLANE), log)
    assert found.check is not None
    assert not found.check.consistent
    assert found.check.slope.value is not None
    assert found.check.slope.value > 1.1
    assert "in doubt" in found.check.text


def test_bounces_on_rough_ground_are_not_a_turns_lift() -> None:
    motion = ride(PLANE, turn(0.45, 0.45))
    time = motion.time_s
    # a wheel thrown up for a tenth of a second, now and then, also in the turns
    forces = {}
    for wheel, start in (("fl", 8.0), ("rr", 9.0), ("fr", 18.0), ("rl", 14.0)):
        away = np.abs(time - start) < 0.05
        forces[wheel] = np.where(away, 0.0, motion.force[wheel])
    found = assess(PLANE, with_forces(motion, forces))
    assert {event.kind for event in found.lifts} <= {"bounce"}
    assert len(found.lifts) >= 1
    assert found.exceedance is not None
    assert found.exceedance.probability == 0.0


@pytest.mark.parametrize("level", [0.0, -20.0])
def test_a_sensor_that_drops_out_is_no_lift(level: float) -> None:
    motion = ride(PLANE, turn(0.6, 0.6))
    gone = (motion.time_s > 8) & (motion.time_s < 9)
    found = assess(PLANE, with_forces(motion, {"fl": np.where(gone, level, motion.force["fl"])}))
    assert [event for event in found.lifts if event.kind != "bounce"] == []
    assert any("dropouts" in note for note in found.notes)


def test_a_gap_is_no_lift() -> None:
    motion = ride(PLANE, turn(0.6, 0.6))
    gone = (motion.time_s > 8) & (motion.time_s < 9)
    found = assess(
        PLANE, with_forces(motion, {w: np.where(gone, np.nan, f) for w, f in motion.force.items()})
    )
    assert found.lifts == ()


def test_a_zero_that_is_off_widens_the_forces_interval() -> None:
    # this wheel reads 600 N too little: near nought in a turn that leaves it 500 N
    motion = ride(TALL, turn(0.7, 0.3))
    least = float(motion.force["rl"].min())
    assert least > 250
    found = assess(TALL, with_forces(motion, {"rl": motion.force["rl"] - least - 300}))
    assert any("its zero is off" in note for note in found.notes)
    assert found.exceedance is not None
    assert found.exceedance.probability == 0.0
    assert all(event.wheel == "rl" and event.kind == "wheel" for event in found.lifts)


def test_without_forces_the_source_says_so() -> None:
    found = assess(PLANE, log_of(ride(PLANE, slalom(0.6)), forces=False))
    assert found.lifts == ()
    assert "load transfer" in found.lift_source
    assert found.check is None


def test_forces_alone_still_tell_lift_and_coefficient() -> None:
    motion = ride(TALL, turn(0.95, 0.4))
    rng = np.random.default_rng(2)
    forces = {f"tire_normal_force_{w}": f + 40 * rng.standard_normal(len(f)) for w, f in motion.force.items()}
    found = assess_rollover({}, vehicle(TALL), drive(forces, RATE))
    assert found.turns == ()
    assert found.peak_rollover_coefficient == pytest.approx(1.0, abs=0.02)
    assert {event.kind for event in found.lifts} == {"side"}
    assert found.exceedance is not None
    assert found.exceedance.probability is None
