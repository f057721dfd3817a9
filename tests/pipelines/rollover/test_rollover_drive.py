"""The coefficient and the margin over a drive, on a plane vehicle written apart from the relation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from roll_plane import RATE, Plane, drive, log_of, ride, slalom, turn, vehicle, verdict

from pipelines.results import ParameterEstimate
from pipelines.rollover import assess_rollover
from pipelines.rollover.margin import before_lift, lifted, shown_rows
from pipelines.rollover_results import Rollover

PLANE = Plane()


def known(entry: ParameterEstimate | None) -> tuple[float, float, float]:
    assert entry is not None
    assert entry.value is not None
    assert entry.low is not None
    assert entry.high is not None
    return entry.value, entry.low, entry.high


def series(found: Rollover, name: str, column: str) -> tuple[np.ndarray, np.ndarray]:
    trace = next(t for t in found.traces if t.name == name)
    return trace.time_s, trace.columns[column]


@pytest.fixture(scope="module")
def assessed() -> Rollover:
    motion = ride(PLANE, slalom(0.75))
    return assess_rollover(verdict(PLANE), vehicle(PLANE), log_of(motion, forces=False))


def test_the_coefficient_is_the_plane_vehicles(assessed: Rollover) -> None:
    motion = ride(PLANE, slalom(0.75))
    time_s, told = series(assessed, "rollover coefficient", "coefficient")
    true = np.interp(time_s, motion.time_s, motion.coefficient)
    assert np.abs(true).max() > 0.65
    # the roll acceleration's part alone is some hundredths: without it this fails
    assert np.abs(told - true).max() < 0.02
    value, low, high = known(assessed.peak_coefficient)
    assert low < np.abs(motion.coefficient).max() < high
    assert value == assessed.peak_rollover_coefficient
    # of the whole vehicle's CG, which swings with the body
    lever = PLANE.sprung * PLANE.arm / PLANE.mass
    swinging = motion.lateral - lever * np.gradient(motion.rate) * RATE / 9.80665
    assert assessed.peak_lateral_acceleration_g == pytest.approx(np.abs(swinging).max(), rel=0.02)


def test_bands_hold_the_truth_and_limits_stand_above_the_drive(assessed: Rollover) -> None:
    motion = ride(PLANE, slalom(0.75))
    time_s, low = series(assessed, "rollover coefficient", "low")
    high = series(assessed, "rollover coefficient", "high")[1]
    true = np.interp(time_s, motion.time_s, motion.coefficient)
    assert np.mean((low <= true) & (true <= high)) > 0.9
    lateral = series(assessed, "rollover margin", "lateral_acceleration")[1]
    assert (series(assessed, "rollover margin", "limit_left")[1] > lateral).all()
    assert (series(assessed, "rollover margin", "limit_right")[1] < lateral).all()


def test_each_side_has_its_own_margin() -> None:
    motion = ride(PLANE, turn(0.7, 0.35))
    found = assess_rollover(verdict(PLANE), vehicle(PLANE), log_of(motion, forces=False))
    left, right = found.turns
    assert (left.turn, right.turn) == ("left", "right")
    assert 6 < left.time_s < 12
    assert 17 < right.time_s < 23
    assert left.lateral_acceleration_g == pytest.approx(0.7, abs=0.03)
    assert right.lateral_acceleration_g == pytest.approx(-0.35, abs=0.03)
    steady = motion.roll[round(9 * RATE)]
    lever = PLANE.sprung * PLANE.arm / PLANE.mass
    limit = (PLANE.track / 2 + PLANE.offset - lever * steady) / PLANE.height
    value, low, high = known(left.least_margin_g)
    assert value == pytest.approx(limit - 0.7, abs=0.03)
    assert low < limit - 0.7 < high
    assert known(right.least_margin_g)[0] > value + 0.3
    assert left.probability < 0.01


def test_bank_drops_out() -> None:
    plain = turn(0.5, 0.5)
    bank = np.where(plain > 0, -1.0, 1.0) * np.abs(plain) / 9.81 * 0.3
    flat, banked = ride(PLANE, plain), ride(PLANE, plain, bank)
    assert np.abs(banked.coefficient).max() < np.abs(flat.coefficient).max() - 0.05
    found = assess_rollover(verdict(PLANE), vehicle(PLANE), log_of(banked, forces=False, bank=bank))
    assert known(found.peak_coefficient)[0] == pytest.approx(np.abs(banked.coefficient).max(), abs=0.03)


def test_a_lift_is_told_as_one() -> None:
    motion = ride(replace(PLANE, high=1.0, stiffness=120_000.0), turn(0.95, 0.4))
    plane = replace(PLANE, high=1.0, stiffness=120_000.0)
    assert motion.coefficient.min() < -1.02
    found = assess_rollover(verdict(plane), vehicle(plane), log_of(motion, forces=False))
    assert found.turns[0].probability > 0.6
    assert found.turns[1].probability < 0.01
    assert known(found.turns[0].peak_coefficient)[0] <= 1.0
    assert [event.wheel for event in found.lifts] == ["left"]
    assert found.exceedance is not None
    assert found.exceedance.probability == found.turns[0].probability


def test_wider_parameters_give_wider_margins() -> None:
    # long enough that the accelerometer's zero is no place's slope
    log = log_of(ride(PLANE, slalom(0.6, seconds=32.0)), forces=False)
    narrow, wide = (assess_rollover(verdict(PLANE, share), vehicle(PLANE), log) for share in (0.005, 0.05))
    spans = [np.subtract(*known(found.turns[0].least_margin_g)[:0:-1]) for found in (narrow, wide)]
    assert spans[1] > 2 * spans[0]
    assert known(narrow.turns[0].least_margin_g)[0] == pytest.approx(
        known(wide.turns[0].least_margin_g)[0], abs=0.02
    )


def test_probability_of_a_share_that_cannot_pass_one() -> None:
    rng = np.random.default_rng(3)
    told = [lifted(rng.normal(mean, 0.03, 4000)) for mean in (0.5, 0.9, 0.97, 1.0, 1.05, 1.4)]
    assert told[0] < 1e-6
    assert told == sorted(told)
    assert 0.5 < told[3] < 0.9
    assert told[5] > 0.95


def test_nothing_after_a_lift_says_how_near_it_came() -> None:
    centre = np.array([0.1, 0.85, 0.95, 1.02, 1.3, 0.9, 0.7, 0.9, 0.95])
    assert before_lift(centre).tolist() == [True, True, True, True, False, False, True, True, True]


def test_a_long_drive_is_shown_by_its_extremes() -> None:
    values = np.sin(np.arange(200_000) / 500)
    values[77_777] = 5.0
    rows = shown_rows(values, np.zeros(len(values)))
    assert len(rows) < 1500
    assert 77_777 in rows


def test_what_came_after_a_fall_is_left_out() -> None:
    motion = ride(PLANE, turn(0.7, 0.3))
    roll = motion.roll.copy()
    late = motion.time_s > 20
    roll[late] += np.clip((motion.time_s[late] - 20) * 1.5, 0, 1.5)
    signals = {"accel_y": motion.accel_y, "roll": roll, "roll_rate": np.gradient(roll) * RATE}
    found = assess_rollover(verdict(PLANE), vehicle(PLANE), drive(signals))
    assert any("beyond 29 degrees" in note for note in found.notes)
    assert found.exceedance is not None
    assert found.exceedance.probability == 1.0
    # falling to the right, the left wheels are in the air
    assert [turn.probability > 0.99 for turn in found.turns] == [True, False]
    assert found.peak_time_s is not None
    assert found.peak_time_s < 20


def test_without_any_roll_signal_the_body_swings_as_vehicles_do() -> None:
    motion = ride(PLANE, slalom(0.6, seconds=32.0, hertz=0.9))
    true = np.abs(motion.coefficient).max()
    hertz = np.sqrt(PLANE.stiffness / (PLANE.inertia + PLANE.sprung * PLANE.arm**2)) / (2 * np.pi)
    entry = ParameterEstimate("roll_natural_frequency_hz", hertz, 0.01, None, None, "identified", "")
    ratio = replace(
        entry, name="roll_damping_ratio", value=PLANE.damping / (2 * PLANE.stiffness) * 2 * np.pi * hertz
    )
    more = {"roll_natural_frequency_hz": entry, "roll_damping_ratio": ratio}
    bare = drive({"accel_y": motion.accel_y})
    found = assess_rollover(verdict(PLANE, **more), vehicle(PLANE), bare)
    value, low, high = known(found.peak_coefficient)
    assert value == pytest.approx(true, rel=0.04)
    assert low < true < high
    seen = assess_rollover(verdict(PLANE, **more), vehicle(PLANE), log_of(motion, forces=False))
    _, seen_low, seen_high = known(seen.peak_coefficient)
    assert high - low > 1.3 * (seen_high - seen_low)


def test_tyres_that_give_sideways_move_more_weight_across() -> None:
    """Each tyre's load moves to the inside by its own side force over its rate; the forces are told by the moments of the whole."""
    rate, motion = 1.2e5, ride(PLANE, slalom(0.6))
    give = PLANE.mass * 9.80665 / (4 * rate)
    share = motion.coefficient.copy()
    for _ in range(50):
        share = motion.coefficient - 2 / PLANE.track * give * motion.lateral * (1 + share**2)
    assert np.abs(share).max() - np.abs(motion.coefficient).max() > 0.04
    stated = vehicle(PLANE, tire_lateral_rate_npm=rate)
    found = assess_rollover(verdict(PLANE), stated, log_of(motion, forces=False))
    time_s, told = series(found, "rollover coefficient", "coefficient")
    assert np.abs(told - np.interp(time_s, motion.time_s, share)).max() < 0.02
    # a file that is silent says what was taken
    assert not any("way across" in a.name for a in found.assumptions)
    mute = replace(
        stated, quantities={k: q for k, q in stated.quantities.items() if k != "tire_lateral_rate_npm"}
    )
    silent = assess_rollover(verdict(PLANE), mute, log_of(motion, forces=False))
    assert any("way across" in a.name for a in silent.assumptions)
