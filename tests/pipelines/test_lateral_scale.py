"""Lateral acceleration against yaw rate and speed: wrong scales, late and foreign channels are said, honest ones are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from parsers.drive import Decision, Drive, ImportRecord, Signal
from pipelines.joint.kept import KeptRelations
from pipelines.prepare.gravity import with_gravity
from pipelines.prepare.lateral_scale import (
    HANG_ON_IT,
    lateral_doubt,
    wrong_weight,
)
from pipelines.prepare.scale_doubt import as_sure_as_the_scale, kept_as_sure, with_doubt
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

HZ, G = 50.0, 9.80665


def _drive(
    change: Callable[[FloatArray], FloatArray] = lambda felt: felt,
    *,
    roll: bool = True,
    bank: float = 0.0,
    ahead_m: float = 0.0,
    mps: float = 18.0,
    bends: float = 1.0,
) -> Drive:
    """Three minutes of bends and weaving. bank: of the road, rad a rad/s of turning; ahead_m: the unit's place."""
    rng = np.random.default_rng(3)
    t = np.arange(int(180 * HZ)) / HZ
    speed = mps * (1 + 0.15 * np.sin(0.9 * t))
    yaw = bends * (0.15 * np.sin(0.3 * t) + 0.12 * np.sin(1.3 * t) * np.sin(0.11 * t))
    lateral = speed * yaw + ahead_m * np.gradient(yaw) * HZ
    lean = np.radians(5) * speed * yaw / G - bank * yaw
    columns = {
        "speed": speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": yaw + 0.002 * rng.standard_normal(len(t)),
        "accel_y": change(lateral + G * np.sin(lean)) + 0.05 * rng.standard_normal(len(t)),
    }
    if roll:
        columns["roll"] = lean
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 180.0, ())
    return Drive({n: Signal(n, stamps, v, n) for n, v in columns.items()}, record)


@pytest.mark.parametrize("roll", [True, False])
@pytest.mark.parametrize("scale", [0.97, 1.0, 1.03])
@pytest.mark.parametrize("bank", [0.0, 0.3])
def test_honest_sensors_are_left_alone(scale: float, bank: float, roll: bool) -> None:
    assert lateral_doubt(_drive(lambda felt: scale * felt, bank=bank, roll=roll), Vehicle()) is None


@pytest.mark.parametrize(
    ("scale", "roll"), [(1.2, True), (0.8, True), (1.1, True), (0.87, True), (1.4, False)]
)
def test_a_wrong_scale_is_said_with_its_size(scale: float, roll: bool) -> None:
    doubt = lateral_doubt(_drive(lambda felt: scale * felt, roll=roll), Vehicle())
    assert doubt is not None
    assert "the scale of one of them is wrong" in doubt.found
    assert doubt.off == pytest.approx(abs(scale - 1), abs=0.03 if roll else 0.15)


def test_a_sign_that_is_left_wrong_is_no_scale() -> None:
    """With `--no-fix` gravity's part counts the wrong way, and a right accelerometer would seem a third too large."""
    drive = _drive(lambda felt: 1.3 * felt)
    assert lateral_doubt(drive, Vehicle()) is not None
    wrong = Decision("roll", "sign", "sign of roll: does not go with the rest", "left in", "", applied=False)
    record = replace(drive.record, decisions=(wrong,))
    assert lateral_doubt(replace(drive, record=record), Vehicle()) is None


def test_a_late_channel_is_said_and_no_gravity_is_added() -> None:
    drive = _drive(lambda felt: np.roll(felt, int(0.4 * HZ)))
    doubt = lateral_doubt(drive, Vehicle())
    assert doubt is not None
    assert "0.4 s after yaw_rate" in doubt.found
    kept = with_gravity(drive, Vehicle(), known={"accel_y"})
    assert kept.signals["accel_y"] is drive.signals["accel_y"]
    (said,) = with_doubt(kept, doubt).record.decisions
    assert (said.signal, said.applied) == ("accel_y", False)


def test_a_unit_far_ahead_is_not_late_in_town() -> None:
    assert lateral_doubt(_drive(ahead_m=1.8, mps=7.0, bends=2.0), Vehicle()) is None


def test_another_channel_is_said() -> None:
    rng = np.random.default_rng(1)
    other = np.convolve(rng.standard_normal(9000), np.ones(100) / 10, mode="same")
    doubt = lateral_doubt(_drive(lambda felt: other), Vehicle())
    assert doubt is not None
    assert "does not follow" in doubt.found


def _between(drive: Drive, start_s: float, end_s: float) -> Drive:
    """Part of a drive, as where recording is switched on while driving."""
    cut = slice(int(start_s * HZ), int(end_s * HZ))
    signals = {n: replace(s, time_ns=s.time_ns[cut], values=s.values[cut]) for n, s in drive.signals.items()}
    return replace(drive, signals=signals)


@pytest.mark.parametrize("seconds", [1.0, 2.0, 5.0, 10.0, 15.0, 16.0, 17.0, 18.0, 19.0, 25.0])
@pytest.mark.parametrize("start", [5.0, 20.0, 75.0])
def test_a_short_part_of_an_honest_drive_is_not_accused(start: float, seconds: float) -> None:
    assert lateral_doubt(_between(_drive(), start, start + seconds), Vehicle()) is None


def test_a_drive_that_mostly_stands_is_not_accused() -> None:
    drive = _between(_drive(), 20.0, 45.0)
    speed = drive.signals["speed"]
    standing = np.where(np.arange(len(speed.values)) < 15 * HZ, speed.values, 0.0)
    signals = {**drive.signals, "speed": replace(speed, values=standing)}
    assert lateral_doubt(replace(drive, signals=signals), Vehicle()) is None


def test_another_channel_is_said_of_half_a_minute() -> None:
    """Long enough that every delay can be judged: there it is still said."""
    other = 2 * np.sin(2.9 * np.arange(int(180 * HZ)) / HZ)
    doubt = lateral_doubt(_between(_drive(lambda felt: other), 20.0, 50.0), Vehicle())
    assert doubt is not None
    assert "does not follow" in doubt.found


def test_too_little_tells_nothing() -> None:
    quiet = _drive(lambda felt: 2 * felt, bends=0.02)
    assert lateral_doubt(quiet, Vehicle()) is None
    alone = replace(quiet, signals={n: s for n, s in quiet.signals.items() if n != "yaw_rate"})
    assert lateral_doubt(alone, Vehicle()) is None
    assert with_doubt(quiet, None) is quiet


def test_what_hangs_on_it_is_no_surer() -> None:
    told = ParameterEstimate("roll_gradient_degpg", 5.0, 0.1, 4.8, 5.2, "identified", "seen")
    mass = ParameterEstimate("mass_kg", 1500.0, 10.0, 1480.0, 1520.0, "identified", "seen")
    verdict = {"roll_gradient_degpg": told, "mass_kg": mass}
    assert as_sure_as_the_scale(verdict, None, HANG_ON_IT) == verdict
    doubt = lateral_doubt(_drive(lambda felt: 1.2 * felt), Vehicle())
    assert doubt is not None
    found = as_sure_as_the_scale(verdict, doubt, HANG_ON_IT)
    assert found["mass_kg"] is mass
    entry = found["roll_gradient_degpg"]
    assert entry.status == "weak"
    assert entry.std == pytest.approx(np.hypot(0.1, 5 * doubt.off))
    assert "scale of one of them" in entry.reason


def test_what_is_handed_on_for_joining_is_no_surer_either() -> None:
    """A height that the verdict does not tell has its doubt in no entry of the verdict."""
    none = np.zeros(0)
    told = {"cg_height_m": (0.7, 0.05), "mass_kg": (1500.0, 10.0)}
    kept = KeptRelations(
        (), none, none, none, np.zeros((0, 0)), none, (), (), (), {}, {}, 1.0, True, told
    )  # fmt: skip
    doubt = lateral_doubt(_drive(lambda felt: 1.2 * felt), Vehicle())
    assert doubt is not None
    found = kept_as_sure(kept, doubt, HANG_ON_IT)
    assert found is not None
    assert found.told["mass_kg"] == told["mass_kg"]
    assert found.told["cg_height_m"] == (0.7, pytest.approx(np.hypot(0.05, 0.7 * doubt.off)))
    assert kept_as_sure(kept, None, HANG_ON_IT) is kept
    assert kept_as_sure(None, doubt, HANG_ON_IT) is None


@pytest.mark.parametrize(("scale", "tilt_deg", "said"), [(1.1, 0.0, True), (0.9, 15.0, True), (1.0, 15.0, False), (1.02, 0.0, False)])  # fmt: skip
def test_a_unit_that_shows_another_gravity_is_said_however_it_is_mounted(
    scale: float, tilt_deg: float, said: bool
) -> None:
    """All three axes 10 % too large, in a log without a roll angle: nothing else tells, and a roll gradient was as much too small."""
    drive = _drive(lambda felt: scale * felt, roll=False)
    assert wrong_weight(drive) is None
    lateral, tilt = drive.signals["accel_y"], np.radians(tilt_deg)
    rng = np.random.default_rng(2)
    more = {
        name: replace(
            lateral,
            name=name,
            values=scale * part * G + rng.normal(0.0, 0.4, len(lateral.values)),
        )
        for name, part in (("accel_x", np.sin(tilt)), ("accel_z", np.cos(tilt)))
    }
    found = wrong_weight(replace(drive, signals={**drive.signals, **more}))
    assert (found is not None) is said
    if found is not None:
        assert found.off == pytest.approx(abs(scale - 1), abs=0.02)
        assert "gravity" in found.found
