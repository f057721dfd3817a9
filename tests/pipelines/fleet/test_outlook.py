"""What a drive's channels promise, before a sample is decoded."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from parsers.load import LoadOptions, load_drive
from parsers.mapping import read_map
from pipelines.estimators.registry import estimators
from pipelines.fleet.find import find_drives
from pipelines.fleet.outlook import Outlook, outlook
from pipelines.fleet.records import FoundDrive


def drives(root: Path) -> dict[str, FoundDrive]:
    return {drive.name: drive for drive in find_drives(str(root)).drives}


@pytest.mark.parametrize("name", ["suv/monday.mcap", "sedan/track.vbo", "van/tour_1.blf", "van/yard.csv"])
def test_the_signals_are_those_of_the_drive(samples, name):
    found = drives(samples / "fleet")[name]
    told = outlook(found)
    assert told.problem == ""
    options = LoadOptions(
        map=read_map(Path(found.map), strict=False) if found.map else None,
        dbc=tuple(map(Path, found.dbc)),
        fix=False,
    )
    # what the log holds; the checks against physics may leave one out that the outlook still names
    assert set(told.signals) >= load_drive([Path(place) for place in found.logs], options).signals.keys()
    assert "roll_map" in told.ready
    assert {*told.ready, *(name for name, _ in told.missing)} == {
        estimator.name for estimator in estimators()
    }


def test_what_cannot_be_told_and_what_it_would_take(tmp_path):
    (tmp_path / "gps.csv").write_text("time_s,gps_speed_2d_mps,latitude_deg\n0,1,48\n0.1,2,48\n0.2,3,48\n")
    told = outlook(drives(tmp_path)["gps.csv"])
    assert told.signals == ("gps_speed_2d", "latitude")
    assert told.ready == ()
    cannot = dict(told.cannot)
    assert "accel_y" in cannot["cg_height_m"]
    assert "mass_kg" in cannot


def test_what_hangs_on_a_mass_that_nobody_states_is_not_promised(samples, tmp_path):
    shutil.copy(samples / "csv" / "drive.csv", tmp_path / "drive.csv")
    cannot = dict(outlook(drives(tmp_path)["drive.csv"]).cannot)
    assert "mass_kg" in cannot["cg_height_m"] == cannot["mass_kg"] == cannot["roll_stiffness_nmprad"]
    (tmp_path / "vehicle.toml").write_text("[vehicle]\nmass_kg = 1890\n")
    assert "cg_height_m" not in dict(outlook(drives(tmp_path)["drive.csv"]).cannot)


def test_a_mass_is_not_promised_where_no_signal_shows_a_force(tmp_path):
    head = "time_s,speed_mps,accel_x_mps2,accel_y_mps2,accel_z_mps2,roll_rate_radps,yaw_rate_radps"
    (tmp_path / "drive.csv").write_text(head + "\n" + "".join(f"{k / 10},1,0,0,9.8,0,0\n" for k in range(90)))
    (tmp_path / "vehicle.toml").write_text("[vehicle]\nmass_kg = 1890\n")
    cannot = dict(outlook(drives(tmp_path)["drive.csv"]).cannot)
    assert "no signal shows a force" in cannot["mass_kg"]
    (tmp_path / "drive.csv").write_text(
        f"{head},brake_pressure_pa\n" + "".join(f"{k / 10},1,0,0,9.8,0,0,0\n" for k in range(90))
    )
    assert "mass_kg" not in dict(outlook(drives(tmp_path)["drive.csv"]).cannot)


def test_a_can_log_without_a_database_is_told_what_it_lacks(tmp_path):
    lines = "".join(f"({1.0 + i / 100:.6f}) can0 123#0011223344556677\n" for i in range(50))
    (tmp_path / "can.log").write_text(lines)
    told = outlook(drives(tmp_path)["can.log"])
    assert told.problem.startswith("no numbers could be read")
    assert "--dbc" in told.problem


def test_problems_are_told_not_raised(samples, tmp_path):
    (tmp_path / "a.csv").write_text("time_s,colour\n0,1\n0.1,2\n0.2,3\n")
    (tmp_path / "empty.csv").write_text("")
    blf = samples / "fleet" / "van" / "tour_1.blf"
    (tmp_path / "x.blf").write_bytes(blf.read_bytes())
    found = drives(tmp_path)
    assert "no channel maps" in outlook(found["a.csv"]).problem
    assert "0 bytes" in outlook(found["empty.csv"]).problem
    assert "not looked at" in outlook(found["x.blf"], most_bytes=1000).problem
    (tmp_path / "vehicle.toml").write_text("[vehicle]\nweight = 3\n")
    assert "unknown key" in outlook(drives(tmp_path)["a.csv"]).problem
    (tmp_path / "a.csv").unlink()
    assert outlook(found["a.csv"]).problem == "no such file"
    assert outlook(found["a.csv"]) == Outlook(problem="no such file")


def test_whether_a_log_says_when_it_was_recorded(samples, tmp_path):
    rows = "".join(f"{0.02 * k:.2f},{10 + k}\n" for k in range(20))
    (tmp_path / "a.csv").write_text(f"time_s,speed_mps\n{rows}")
    (tmp_path / "map.toml").write_bytes((samples / "can" / "map.toml").read_bytes())
    for name in ("drive.asc", "chassis.dbc"):
        (tmp_path / name).write_bytes((samples / "can" / name).read_bytes())
    found = drives(tmp_path)
    assert not outlook(found["a.csv"]).dated
    assert outlook(found["drive.asc"]).dated
