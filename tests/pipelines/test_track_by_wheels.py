"""Tracks by the wheels' speeds in bends, against those of the vehicle file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.drive_doubts import made_ready
from pipelines.prepare.track_by_wheels import track_by_wheels, track_doubt
from pipelines.vehicles.vehicle_file import parse_vehicle

TRACK = {"front": 1.56, "rear": 1.54}
FILE = "[vehicle]\nmass_kg = 1500\ntrack_front_m = {front}\ntrack_rear_m = {rear}\nroll_stiffness_nmprad = 60000\n"


def drive(minutes: float = 4.0, bends: float = 1.0, roll: bool = False) -> Drive:
    """Bends at several speeds; radii that differ by half a per cent, tyres that squash, noise, a yaw rate 0.7 % too large."""
    rng = np.random.default_rng(11)
    t = np.arange(0, 60 * minutes, 0.02)
    v = 9 + 5 * np.sin(2 * np.pi * t / 47)
    r = bends * 0.25 * np.sin(2 * np.pi * t / 13) * (1 + 0.6 * np.sin(2 * np.pi * t / 29))
    columns = {"yaw_rate": 1.007 * r + 0.003 + 0.004 * rng.standard_normal(t.size)}
    for axle, track in TRACK.items():
        for side, sign in (("l", -1), ("r", 1)):
            own = v + sign * (0.5 * track * r + 0.0025 * v + 0.0004 * v * v * r)
            columns[f"wheel_speed_{axle[0]}{side}"] = own + 0.03 * rng.standard_normal(t.size)
    columns["suspension_deflection_fl"] = 0.01 * r
    if roll:
        columns["roll"] = 0.05 * r
    stamps = (t * 1e9).astype(np.int64)
    signals = {n: Signal(n, stamps, x, "test") for n, x in columns.items()}
    record = ImportRecord("csv", (), "", "complete", t.size, {}, (), "", None, float(t[-1]), ())
    return Drive(signals, record, 0)


def vehicle(tmp_path, factor: float = 1.0):
    text = FILE.format(**{axle: factor * track for axle, track in TRACK.items()})
    return parse_vehicle(text, tmp_path / "vehicle.toml")


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_the_track_is_recovered(axle):
    told = track_by_wheels(drive(), axle)
    assert told is not None
    # the yaw rate's scale is in it
    assert told[0] == pytest.approx(TRACK[axle] / 1.007, abs=4 * told[1] + 0.005)
    assert told[1] < 0.02


@pytest.mark.parametrize(
    ("factor", "found"), [(1.0, False), (1.03, False), (0.97, False), (1.12, True), (0.88, True)]
)
def test_a_file_with_other_tracks_is_found(factor, found, tmp_path):
    doubt = track_doubt(drive(), vehicle(tmp_path, factor))
    assert (doubt is not None) is found
    if doubt is not None:
        assert doubt.off == pytest.approx(abs(1 / factor - 1), abs=0.03)
        assert "front and rear" not in doubt.found
        assert "rear and front track is" in doubt.found


def test_wheels_that_show_no_bends_say_nothing(tmp_path):
    assert track_doubt(drive(bends=0.02), vehicle(tmp_path, 1.12)) is None
    alike = drive()
    one = alike.signals["wheel_speed_rl"]
    same = {n: replace(one, name=n) if n.startswith("wheel_speed") else s for n, s in alike.signals.items()}
    assert track_doubt(replace(alike, signals=same), vehicle(tmp_path, 1.12)) is None


@pytest.mark.parametrize("roll", [True, False])
def test_it_is_said_and_what_goes_by_it_is_marked(roll, tmp_path):
    ready, doubts = made_ready(drive(roll=roll), vehicle(tmp_path, 1.12), fix=True)
    assert any("by the wheels' speeds in bends" in d.found for d in ready.record.decisions)
    # an angle against the horizon does not go by the track
    assert doubts.by_track == (() if roll else ("roll_gradient_degpg",))
