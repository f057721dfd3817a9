"""Accelerations without gravity's part: found by speed and yaw rate, given it back, and real readings left alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.limits import what_limits
from pipelines.prepare.gravity import share_of, shares, turned_share, with_gravity
from pipelines.prepare.lateral_scale import left_without_gravity
from pipelines.vehicles.vehicle import Quantity, Vehicle

HZ = 50.0
TRACK = 1.6
CAR = Vehicle(quantities={"track_front_m": Quantity(TRACK, 0.01, "vehicle file")})


def _drive(*, sideways: float, along: float, springs: bool = False, scale: float = 1.0) -> Drive:
    """Two minutes of bends, weaving and changing speed; sideways, along: share of gravity in the accelerations."""
    rng = np.random.default_rng(3)
    t = np.arange(int(120 * HZ)) / HZ
    speed = 15 + 4 * np.sin(0.9 * t)
    yaw = 0.15 * np.sin(0.3 * t) + 0.12 * np.sin(1.3 * t) * np.sin(0.11 * t)
    lateral, forward = speed * yaw, np.gradient(speed) * HZ
    roll, pitch = np.radians(5) * lateral / 9.80665, -np.radians(4) * forward / 9.80665
    columns = {
        "speed": speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": yaw + 0.002 * rng.standard_normal(len(t)),
        "accel_y": scale * (lateral + sideways * 9.80665 * np.sin(roll)) + 0.05 * rng.standard_normal(len(t)),
        "accel_x": forward - along * 9.80665 * np.sin(pitch) + 0.02 * rng.standard_normal(len(t)),
    }
    if springs:
        for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
            columns[f"suspension_deflection_{wheel}"] = 0.01 + side * 0.5 * TRACK * roll
    else:
        columns |= {"roll": roll, "pitch": pitch}
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 120.0, ())
    return Drive({n: Signal(n, stamps, v, n) for n, v in columns.items()}, record)


@pytest.mark.parametrize("springs", [False, True])
@pytest.mark.parametrize("share", [0.0, 1.0])
def test_the_share_of_gravity_is_recovered(share: float, springs: bool) -> None:
    found, _ = shares(_drive(sideways=share, along=1.0, springs=springs), CAR)["accel_y"]
    assert found.value == pytest.approx(share, abs=0.1)
    assert found.missing is (share == 0.0)


def test_gravity_is_given_back_and_said() -> None:
    level, whole = _drive(sideways=0.0, along=0.0), _drive(sideways=1.0, along=1.0)
    found = with_gravity(level, CAR)
    for name in ("accel_y", "accel_x"):
        assert np.abs(found.signals[name].values - whole.signals[name].values).max() < 1e-9
    assert [d.signal for d in found.record.decisions] == ["accel_y", "accel_x"]
    assert all(d.applied for d in found.record.decisions)
    assert found.signals["speed"] is level.signals["speed"]


def test_without_fix_it_is_only_said() -> None:
    level = _drive(sideways=0.0, along=1.0)
    found = with_gravity(level, CAR, fix=False)
    assert found.signals["accel_y"] is level.signals["accel_y"]
    assert [d.applied for d in found.record.decisions] == [False]


@pytest.mark.parametrize("scale", [0.97, 1.0, 1.03])
def test_a_reading_with_gravity_is_left_alone_whatever_its_scale(scale: float) -> None:
    drive = _drive(sideways=1.0, along=1.0, scale=scale)
    assert with_gravity(drive, CAR) is drive


def test_sideslip_that_lags_in_weaving_is_not_taken_for_missing_gravity() -> None:
    """At one rhythm v_y' is in step with the lean: its lag makes up for gravity's share, and nothing tells them apart."""
    whole = _drive(sideways=1.0, along=1.0)
    t = whole.signals["speed"].time_ns * 1e-9
    yaw, tilt = 0.2 * np.sin(2.5 * t), np.radians(5) / 9.80665
    lateral = 15.0 * yaw + 0.18 * np.gradient(np.gradient(yaw, t), t)
    columns = {"speed": np.full(len(t), 15.0), "yaw_rate": yaw, "roll": tilt * lateral}
    columns["accel_y"] = lateral + 9.80665 * np.sin(columns["roll"])
    noise = np.random.default_rng(4).normal(0, 0.02, len(t))
    signals = {
        n: replace(s, values=columns[n] + noise * (n == "accel_y"))
        for n, s in whole.signals.items()
        if n in columns
    }
    found = shares(replace(whole, signals=signals), CAR)
    assert "accel_y" not in found or not found["accel_y"][0].missing


def test_too_little_lean_or_too_short_a_drive_says_nothing() -> None:
    rng = np.random.default_rng(0)
    lean = rng.standard_normal(1000)
    others = rng.standard_normal((1000, 1))
    assert share_of(0.01 * lean, 0.01 * lean, lean, others) is None
    assert share_of(lean[:100], lean[:100], lean[:100], others[:100]) is None
    assert share_of(lean, lean, 0 * lean, others) is not None


def _town_and_country(*, gravity: float, bank: float) -> Drive:
    """Four minutes: slow bends on flat streets, then fast ones on a road that leans into them by `bank` times the body's roll."""
    rng = np.random.default_rng(5)
    t = np.arange(int(240 * HZ)) / HZ
    fast = t > 120
    speed = np.where(fast, 20.0, 8.0) + 0.5 * np.sin(0.9 * t)
    yaw = np.where(fast, 0.22, 0.32) * (np.sin(0.3 * t) + 0.7 * np.sin(1.3 * t) * np.sin(0.11 * t))
    lateral = speed * yaw
    roll = np.radians(5) * lateral / 9.80665
    against_horizon = roll * np.where(fast, 1 - bank, 1.0)
    columns = {
        "speed": speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": yaw + 0.002 * rng.standard_normal(len(t)),
        "accel_y": lateral + gravity * 9.80665 * np.sin(against_horizon) + 0.05 * rng.standard_normal(len(t)),
    }
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        columns[f"suspension_deflection_{wheel}"] = 0.01 + side * 0.5 * TRACK * roll
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 240.0, ())
    return Drive({n: Signal(n, stamps, v, n) for n, v in columns.items()}, record)


def test_a_road_that_banks_is_not_taken_for_gravity_that_is_missing() -> None:
    banked = _town_and_country(gravity=1.0, bank=1.2)
    assert shares(banked, CAR)["accel_y"][0].missing
    found = with_gravity(banked, CAR)
    assert found.signals["accel_y"] is banked.signals["accel_y"]
    (decision,) = found.record.decisions
    assert not decision.applied
    assert "the road banks" in decision.found
    # an accelerometer without gravity lacks it in slow bends too
    level = _town_and_country(gravity=0.0, bank=0.0)
    (decision,) = with_gravity(level, CAR).record.decisions
    assert decision.applied


def _superelevated(
    *, gravity: float, hills: bool = False, horizon_share: float = 0.05, weaving: float = 0.02
) -> Drive:
    """Four minutes of fast bends alone that lean into themselves as the body leans out; a gyro turns with both, drifts and is off."""
    rng = np.random.default_rng(6)
    t = np.arange(int(240 * HZ)) / HZ
    speed = 20.0 + 0.5 * np.sin(0.9 * t)
    yaw = 0.22 * (np.sin(0.3 * t) + 0.7 * np.sin(1.3 * t) * np.sin(0.11 * t))
    lateral = speed * yaw
    roll = np.radians(5) * lateral / 9.80665
    up = 0.05 * np.sin(0.05 * t) if hills else np.zeros(len(t))
    horizon = horizon_share * roll
    # a body that yaws on a hill rolls against the horizon without turning about its own axis
    rate = np.gradient(horizon) * HZ + yaw * up
    columns = {
        "speed": speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": yaw + 0.002 * rng.standard_normal(len(t)),
        "roll_rate": rate + 0.004 + 0.004 * rng.standard_normal(len(t)),
        "accel_x": np.gradient(speed) * HZ + 9.80665 * np.sin(up) + 0.05 + 0.05 * rng.standard_normal(len(t)),
        "accel_y": lateral + gravity * 9.80665 * np.sin(horizon) + 0.05 * rng.standard_normal(len(t)),
    }
    # quick steering leans the body on its springs against the horizon too
    quick = weaving * np.sin(2.2 * t) * (np.sin(0.2 * t) > 0)
    columns["roll_rate"] = columns["roll_rate"] + np.gradient(quick) * HZ
    columns["accel_y"] = columns["accel_y"] + gravity * 9.80665 * np.sin(quick)
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        columns[f"suspension_deflection_{wheel}"] = 0.01 + side * 0.5 * TRACK * (roll + quick)
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 240.0, ())
    return Drive({n: Signal(n, stamps, v, n) for n, v in columns.items()}, record)


@pytest.mark.parametrize("hills", [False, True])
def test_a_gyro_tells_gravity_on_roads_without_slow_bends(hills: bool) -> None:
    there, gone = (turned_share(_superelevated(gravity=g, hills=hills)) for g in (1.0, 0.0))
    assert there is not None
    assert gone is not None
    assert abs(there.value - 1) < 4 * there.std + 0.05
    assert abs(gone.value) < 4 * gone.std + 0.05
    assert gone.missing
    assert not there.missing


def test_a_banked_road_without_slow_bends_is_left_alone_where_a_gyro_turns() -> None:
    banked = _superelevated(gravity=1.0)
    assert shares(banked, CAR)["accel_y"][0].missing
    found = with_gravity(banked, CAR)
    assert found.signals["accel_y"] is banked.signals["accel_y"]
    (decision,) = (d for d in found.record.decisions if d.signal == "accel_y")
    assert not decision.applied
    assert "gyro" in decision.evidence


@pytest.mark.parametrize("horizon_share", [0.0, 0.1])
def test_a_road_that_banks_by_all_of_the_lean_is_left_alone_as_the_gyro_hardly_turns(
    horizon_share: float,
) -> None:
    """Of gravity there is none in the reading, as there is none to be read: a blind simulator's 4x4 was given it, for -17 % in roll gradient."""
    banked = _superelevated(gravity=1.0, horizon_share=horizon_share, weaving=0.0)
    assert shares(banked, CAR)["accel_y"][0].missing
    assert turned_share(banked) is None
    found = with_gravity(banked, CAR)
    assert found.signals["accel_y"] is banked.signals["accel_y"]
    (decision,) = (d for d in found.record.decisions if d.signal == "accel_y")
    assert "by the gyro the body turns by" in decision.action
    # on a level road the gyro turns with the springs, and what lacks gravity is given it
    level = _superelevated(gravity=0.0, horizon_share=1.0, weaving=0.0)
    assert any(d.applied for d in with_gravity(level, CAR).record.decisions if d.signal == "accel_y")


def test_without_a_gyro_a_banked_road_is_not_taken_for_gravity_that_is_missing_either() -> None:
    """A unit that levels its output reads nothing of gravity; banks take away more or less than all of it."""

    def blind(gravity: float) -> Drive:
        whole = _superelevated(gravity=gravity)
        return replace(whole, signals={n: s for n, s in whole.signals.items() if n != "roll_rate"})

    over, level = blind(1.0), blind(0.0)
    assert shares(over, CAR)["accel_y"][0].missing
    found = with_gravity(over, CAR)
    assert found.signals["accel_y"] is over.signals["accel_y"]
    (decision,) = (d for d in found.record.decisions if d.signal == "accel_y")
    assert not decision.applied
    assert "neither a gyro nor slow bends tell which" in decision.action
    assert any(d.applied for d in with_gravity(level, CAR).record.decisions)


def test_that_gravity_was_added_stands_on_the_first_screen() -> None:
    found = with_gravity(_superelevated(gravity=0.0), CAR)
    (decision,) = (d for d in found.record.decisions if d.signal == "accel_y")
    assert decision.applied
    (first, *_) = what_limits(found.record, [], {}, CAR)[:1]
    assert first.startswith("Accel_y has no part of gravity")
    assert "--no-fix" in first


def test_without_a_lean_it_is_only_said() -> None:
    made, whole = _superelevated(gravity=0.0), _superelevated(gravity=1.0)
    for drive, said in ((made, True), (whole, False)):
        kept = {n: s for n, s in drive.signals.items() if not n.startswith("suspension")}
        found = with_gravity(replace(drive, signals=kept), CAR)
        assert found.signals["accel_y"] is drive.signals["accel_y"]
        assert [d.applied for d in found.record.decisions if "gravity" in d.found] == [False] * said


def _one_rhythm(*, springs: bool, gyro: bool) -> Drive:
    """Two minutes of weaving at one rhythm and one speed, with hard braking; no acceleration has gravity's part. Springs: four stamps."""
    rng = np.random.default_rng(7)
    t = np.arange(int(120 * HZ)) / HZ
    slowed = 1.5 * np.sin(0.25 * t) if gyro else 2.5 * np.sin(0.5 * t)
    speed = 15 + np.cumsum(slowed) / HZ
    yaw = 0.25 * np.sin(2.5 * t)
    lateral = speed * yaw
    roll, pitch = np.radians(5) * lateral / 9.80665, -np.radians(6) * slowed / 9.80665
    stamps = (t * 1e9).astype(np.int64)
    columns = {
        "speed": speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": yaw + 0.002 * rng.standard_normal(len(t)),
        "accel_y": lateral + 0.05 * rng.standard_normal(len(t)),
        "accel_x": slowed + 0.02 * rng.standard_normal(len(t)),
        "pitch": pitch,
    }
    if gyro:
        columns["roll_rate"] = np.gradient(roll) * HZ + 0.002 * rng.standard_normal(len(t))
    if not springs:
        columns["roll"] = roll
    signals = {n: Signal(n, stamps, v, n) for n, v in columns.items()}
    if springs:
        for late, (wheel, side) in enumerate((("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1))):
            name = f"suspension_deflection_{wheel}"
            # less than the whole lean, as tyres give too
            signals[name] = Signal(
                name, stamps + late * 1_000_000, 0.01 + side * 0.5 * TRACK * 0.3 * roll, name
            )
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 120.0, ())
    return Drive(signals, record)


@pytest.mark.parametrize(("springs", "gyro"), [(True, True), (False, True), (False, False)])
def test_weaving_at_one_rhythm_is_given_gravity_by_what_else_tells(springs: bool, gyro: bool) -> None:
    """A gyro, or the other axis of the unit; the lean of the springs, whose four messages come at their own moments, is what is added."""
    drive = _one_rhythm(springs=springs, gyro=gyro)
    assert "accel_y" not in shares(drive, CAR)
    found = with_gravity(drive, CAR)
    (decision,) = (d for d in found.record.decisions if d.signal == "accel_y")
    assert decision.applied
    assert ("gyro" in decision.evidence) is gyro
    assert ("springs" in decision.action) is springs
    added = found.signals["accel_y"].values - drive.signals["accel_y"].values
    lean = np.radians(5) * drive.signals["yaw_rate"].values * drive.signals["speed"].values / 9.80665
    by = 0.3 if springs else 1.0
    assert np.abs(added - 9.80665 * np.sin(by * lean)).max() < 0.06


def test_an_acceleration_left_without_gravity_makes_what_hangs_on_it_less_sure() -> None:
    made = _superelevated(gravity=0.0)
    kept = {n: s for n, s in made.signals.items() if not n.startswith("suspension")}
    for drive, fix, doubted in ((replace(made, signals=kept), True, True), (made, False, True), (made, True, False)):  # fmt: skip
        assert (left_without_gravity(with_gravity(drive, CAR, fix=fix)) is not None) is doubted
