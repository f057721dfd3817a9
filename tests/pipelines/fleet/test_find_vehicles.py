"""Which vehicle a drive is of, and which files belong to it."""

from __future__ import annotations

from pathlib import Path

import pytest

from parsers.errors import SettingsError, VehicleError
from pipelines.estimators.registry import estimators
from pipelines.fleet.find import find_drives
from pipelines.settings import read_settings
from pipelines.vehicles.vehicle_file import parse_vehicle

TABLE = "time_s,speed_mps\n0.0,1.5\n0.1,1.6\n0.2,1.7\n"
VAN = '[vehicle]\nname = "van 7"\nmass_kg = 1800\n'


def put(root: Path, files: dict[str, str]) -> Path:
    for number, (name, content) in enumerate(files.items()):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(
            content + (f"0.3,{number}.5\n" if name.endswith(".csv") else ""), encoding="utf-8"
        )
    return root


def ids(root: Path) -> dict[str, str]:
    return {drive.name: drive.vehicle_id for drive in find_drives(str(root)).drives}


def test_a_load_of_one_day_makes_no_other_vehicle(tmp_path):
    put(
        tmp_path,
        {
            "van/vehicle.toml": VAN,
            "van/monday/a.csv": TABLE,
            "van/tuesday/vehicle.toml": f"{VAN}\n[load]\nmass_kg = 200\n",
            "van/tuesday/b.csv": TABLE,
            "van/rebuilt/vehicle.toml": VAN.replace("1800", "1950"),
            "van/rebuilt/c.csv": TABLE,
        },
    )
    assert ids(tmp_path) == {
        "van/monday/a.csv": "van",
        "van/tuesday/b.csv": "van",
        "van/rebuilt/c.csv": "van/rebuilt",
    }


def test_two_vehicles_of_one_type_stay_two(tmp_path):
    put(tmp_path, {f"{v}/{n}": t for v in ("a", "b") for n, t in (("vehicle.toml", VAN), ("x.csv", TABLE))})
    assert ids(tmp_path) == {"a/x.csv": "a", "b/x.csv": "b"}


def test_an_id_in_the_vehicle_file_beats_the_folders(tmp_path):
    said = VAN + 'id = " WV2 77 "\n'
    put(tmp_path, {f"{v}/{n}": t for v in ("a", "b") for n, t in (("vehicle.toml", said), ("x.csv", TABLE))})
    put(tmp_path, {"WV2 77/y.csv": TABLE})
    assert ids(tmp_path) == {"a/x.csv": "WV2 77", "b/x.csv": "WV2 77", "WV2 77/y.csv": "WV2 77/"}


def test_without_a_vehicle_file_the_top_folder_counts(tmp_path):
    put(tmp_path, {"van/monday/a.csv": TABLE, "van/b.csv": TABLE, "c.csv": TABLE, "d.csv": TABLE})
    assert ids(tmp_path) == {
        "van/monday/a.csv": "van",
        "van/b.csv": "van",
        "c.csv": "c.csv",
        "d.csv": "d.csv",
    }
    lacks = {drive.name: " ".join(drive.lacks) for drive in find_drives(str(tmp_path)).drives}
    assert "no vehicle.toml" in lacks["van/b.csv"]
    assert "under van/ count as one vehicle" in lacks["van/b.csv"]
    assert "a vehicle of its own" in lacks["c.csv"]


def test_a_vehicle_file_of_the_whole_folder_and_one_above_it(tmp_path):
    put(tmp_path, {"vehicle.toml": VAN, "fleet/x.csv": TABLE, "fleet/y/z.csv": TABLE})
    above = find_drives(str(tmp_path / "fleet"))
    assert {drive.vehicle_id for drive in above.drives} == {"."}
    assert {drive.vehicle for drive in above.drives} == {str(tmp_path / "vehicle.toml")}
    assert set(ids(tmp_path).values()) == {"."}


def test_a_broken_vehicle_file_is_named_and_the_drive_stays(tmp_path):
    put(tmp_path, {"van/vehicle.toml": "[vehicle]\nmass = 3\n", "van/a.csv": TABLE})
    (drive,) = find_drives(str(tmp_path)).drives
    assert drive.vehicle_id == "van"
    assert drive.vehicle is not None
    assert "unknown key 'mass'" in drive.lacks[0]
    put(tmp_path, {"van/vehicle.toml": VAN + 'suspension_map = "none.toml"\n'})
    assert "vehicle file cannot be used" in find_drives(str(tmp_path)).drives[0].lacks[0]


def test_the_nearest_map_settings_and_databases(tmp_path):
    put(
        tmp_path,
        {
            "map.toml": "",
            "above.dbc": "",
            "fleet/settings.toml": "",
            "fleet/top.dbc": "",
            "fleet/van/map.toml": "",
            "fleet/van/a.csv": TABLE,
            "fleet/van/monday/own.DBC": "",
            "fleet/van/monday/b.csv": TABLE,
            "fleet/suv/c.csv": TABLE,
        },
    )
    found = {drive.name: drive for drive in find_drives(str(tmp_path / "fleet")).drives}
    assert found["van/a.csv"].map == str(tmp_path / "fleet" / "van" / "map.toml")
    assert found["suv/c.csv"].map == str(tmp_path / "map.toml")
    assert {drive.settings for drive in found.values()} == {str(tmp_path / "fleet" / "settings.toml")}
    assert [Path(place).name for place in found["van/monday/b.csv"].dbc] == ["own.DBC"]
    assert [Path(place).name for place in found["van/a.csv"].dbc] == ["top.dbc"]


def test_frames_without_a_database_are_told_of(samples, tmp_path):
    (tmp_path / "a.blf").write_bytes((samples / "fleet" / "van" / "tour_1.blf").read_bytes())
    (drive,) = find_drives(str(tmp_path)).drives
    assert any("no *.dbc" in lack for lack in drive.lacks)


def test_the_id_of_a_vehicle_file(tmp_path):
    path = tmp_path / "vehicle.toml"
    assert parse_vehicle('[vehicle]\nid = "WV2"\n', path).id == "WV2"
    assert parse_vehicle("[vehicle]\n", path).id is None
    for wrong in ("3", '" "'):
        with pytest.raises(VehicleError, match="id"):
            parse_vehicle(f"[vehicle]\nid = {wrong}\n", path)


def test_settings_that_cannot_be_used_are_told_before_the_work(tmp_path):
    put(
        tmp_path,
        {
            "van/vehicle.toml": VAN,
            "van/settings.toml": "[roll_map]\ndrawz = 1000\n",
            "van/a.csv": TABLE,
            "suv/vehicle.toml": VAN,
            "suv/settings.toml": "[roll_map]\ndraws = 1000\n",
            "suv/b.csv": TABLE,
        },
    )
    found = {drive.name: drive for drive in find_drives(str(tmp_path)).drives}
    (lack,) = found["van/a.csv"].lacks
    assert lack.startswith("the settings file cannot be used, and the drive will fail: ")
    with pytest.raises(SettingsError) as told:
        read_settings(tmp_path / "van" / "settings.toml", estimators())
    assert lack.endswith(str(told.value))
    assert found["suv/b.csv"].lacks == ()


def test_a_logs_own_files_go_before_the_folders(tmp_path):
    """As `cogest analyze` takes them, and `cogest simulate` writes them side by side."""
    other = VAN.replace("1800", "1950")
    put(
        tmp_path,
        {
            "v/vehicle.toml": VAN,
            "v/trip.csv": TABLE,
            "v/trip.vehicle.toml": other,
            "v/trip.settings.toml": "[settings]\n",
            "v/again.csv": TABLE,
            "v/again.vehicle.toml": other,
            "v/laden.csv": TABLE,
            "v/laden.vehicle.toml": f"{VAN}\n[load]\nmass_kg = 200\n",
            "v/usual.csv": TABLE,
        },
    )
    found = {drive.name: drive for drive in find_drives(str(tmp_path)).drives}
    assert Path(str(found["v/trip.csv"].vehicle)).name == "trip.vehicle.toml"
    assert Path(str(found["v/trip.csv"].settings)).name == "trip.settings.toml"
    assert Path(str(found["v/usual.csv"].vehicle)).name == "vehicle.toml"
    assert found["v/usual.csv"].settings is None
    # alike in [vehicle] are one vehicle, whichever file says so
    assert ids(tmp_path) == {
        "v/again.csv": "v/again",
        "v/trip.csv": "v/again",
        "v/laden.csv": "v",
        "v/usual.csv": "v",
    }
