"""Recordings in parts and by several recorders, in real files: found as one drive, and read as the whole."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from parsers.load import LoadOptions, load_drive
from pipelines.fleet.find import find_drives

T0 = 1_714_557_600


def names(root: Path) -> list[list[str]]:
    return [[Path(place).name for place in drive.logs] for drive in find_drives(str(root)).drives]


def table(start: float, rows: int, step: float = 0.1, columns: str = "speed_mps,accel_y_mps2") -> str:
    rng = np.random.default_rng(round(start))
    width = columns.count(",") + 1
    lines = [
        f"{start + k * step:.2f}," + ",".join(f"{v:.4f}" for v in rng.normal(3, 1, width))
        for k in range(rows)
    ]
    return "\n".join([f"time_s,{columns}", *lines]) + "\n"


def test_a_candump_log_in_parts_is_read_as_the_whole(samples, tmp_path):
    lines = (samples / "can" / "drive.log").read_text().splitlines(keepends=True)
    third = len(lines) // 3
    for k in range(3):
        end = None if k == 2 else (k + 1) * third
        (tmp_path / f"drive_{k}.log").write_text("".join(lines[k * third : end]))
    for name in ("chassis.dbc", "map.toml"):
        shutil.copy(samples / "can" / name, tmp_path)
    (drive,) = find_drives(str(tmp_path)).drives
    assert [Path(place).name for place in drive.logs] == ["drive_0.log", "drive_1.log", "drive_2.log"]
    assert "3 files in a row" in drive.notes[0]
    options = LoadOptions(dbc=tuple(map(Path, drive.dbc)), fix=False)
    whole = load_drive([samples / "can" / "drive.log"], options).signals
    parts = load_drive([Path(place) for place in drive.logs], options).signals
    assert parts.keys() == whole.keys()
    assert sum(len(s.time_ns) for s in parts.values()) == sum(len(s.time_ns) for s in whole.values())


def test_a_table_in_parts_with_a_clock_that_goes_on(tmp_path):
    (tmp_path / "run.part1.csv").write_text(table(0, 600))
    (tmp_path / "run.part2.csv").write_text(table(60, 600))
    (tmp_path / "run.part3.csv").write_text(table(125, 600))
    assert names(tmp_path) == [["run.part1.csv", "run.part2.csv"], ["run.part3.csv"]]


def test_drives_with_numbers_whose_clocks_begin_anew_stay_apart(tmp_path):
    for k in range(5):
        (tmp_path / f"run_{k}.csv").write_text(table(0, 600 + k))
    assert len(names(tmp_path)) == 5


def test_bags_of_rosbag_split_and_of_two_drives(samples, tmp_path):
    # the sample bag twice: the clocks say that the second does not follow the first
    for k in range(2):
        shutil.copy(samples / "fleet" / "truck" / "depot.bag", tmp_path / f"2024-05-01-10-0{k}-00_{k}.bag")
    assert len(names(tmp_path)) == 2


def test_three_recorders_of_one_drive(tmp_path):
    (tmp_path / "can.csv").write_text(table(T0, 600))
    (tmp_path / "gps.csv").write_text(table(T0 + 2, 580, columns="latitude_deg,longitude_deg"))
    (tmp_path / "imu.csv").write_text(table(T0 - 1, 610, columns="roll_rate_radps,yaw_rate_radps"))
    assert names(tmp_path) == [["can.csv", "gps.csv", "imu.csv"]]
    (tmp_path / "gps.csv").write_text(table(2, 580, columns="latitude_deg,longitude_deg"))
    assert names(tmp_path) == [["can.csv", "imu.csv"], ["gps.csv"]]


def test_what_a_user_says_beats_every_guess(tmp_path):
    (tmp_path / "can.csv").write_text(table(T0, 600))
    (tmp_path / "gps.csv").write_text(table(T0 + 2, 580))
    (tmp_path / "old.csv").write_text(table(T0 + 4, 580))
    said = tmp_path / "drive.toml"
    said.write_text("separate = true\n")
    assert names(tmp_path) == [["can.csv"], ["gps.csv"], ["old.csv"]]
    said.write_text('leave_out = "old*"\n[[drive]]\nlogs = ["gps.csv", "can.csv"]\nname = "monday"\n')
    found = find_drives(str(tmp_path))
    assert [(d.name, [Path(p).name for p in d.logs]) for d in found.drives] == [
        ("monday", ["gps.csv", "can.csv"])
    ]
    assert "drive.toml says" in found.drives[0].notes[0]
    assert found.left_out == ((str(tmp_path / "old.csv"), "left out by drive.toml"),)
    said.write_text('logs = ["can.csv", "imu.csv"]\nstart_utc = "2024-05-01T10:00:00Z"\n')
    drives = {drive.name: drive for drive in find_drives(str(tmp_path)).drives}
    assert set(drives) == {"can.csv", "gps.csv", "old.csv"}
    assert drives["can.csv"].start_utc == "2024-05-01T10:00:00.000+00:00"
    assert "names imu.csv, which is no log that is there" in drives["can.csv"].lacks[-1]


def test_a_drive_file_that_is_wrong_is_told_and_nothing_is_guessed(tmp_path):
    (tmp_path / "can.csv").write_text(table(T0, 600))
    (tmp_path / "gps.csv").write_text(table(T0 + 2, 580))
    (tmp_path / "drive.toml").write_text("logs = [")
    found = find_drives(str(tmp_path))
    assert len(found.drives) == 2
    assert all("drive.toml cannot be used" in drive.lacks[-1] for drive in found.drives)


def test_a_drive_file_may_name_what_lies_in_folders_below(samples, tmp_path):
    shutil.copytree(samples / "ros" / "drive_mcap", tmp_path / "bag")
    (tmp_path / "gps").mkdir()
    (tmp_path / "gps" / "a.csv").write_text(table(T0, 600))
    (tmp_path / "drive.toml").write_text('logs = ["bag", "gps/a.csv"]\nname = "both"\n')
    assert names(tmp_path) == [["bag", "a.csv"]]


def test_behind_a_url_heads_are_read_and_no_more(samples, s3_store, counted):
    source = samples / "fleet"
    url = s3_store.put(source, "heads")
    found = find_drives(url)
    assert len(found.drives) == 11
    assert counted.calls["list_objects_v2"] == 1
    # logs, maps and vehicle files; a second look at a table's first rows, or at a list of columns
    assert counted.calls["get_object"] < 10 + 4 + 4 + 6
    assert counted.bytes < 0.1 * sum(drive.size for drive in found.drives)


@pytest.mark.parametrize("way", ["memory", "s3"])
def test_behind_a_url_it_is_the_same(samples, way, request):
    pytest.importorskip("fsspec")
    source = samples / "fleet"
    if way == "s3":
        url = request.getfixturevalue("s3_store").put(source, "found")
    else:
        from fsspec.core import url_to_fs

        url = "memory://find/fleet"
        fs, path = url_to_fs(url)
        for file in source.rglob("*"):
            if file.is_file():
                fs.pipe_file(f"{path}/{file.relative_to(source).as_posix()}", file.read_bytes())
    here, there = find_drives(str(source)), find_drives(url)
    assert [drive.drive_id for drive in there.drives] == [drive.drive_id for drive in here.drives]
    assert [drive.vehicle_id for drive in there.drives] == [drive.vehicle_id for drive in here.drives]
    assert [drive.size for drive in there.drives] == [drive.size for drive in here.drives]
    assert there.drives[0].logs == (f"{url}/{here.drives[0].name}",)
    assert there.drives[0].map == f"{url}/sedan/map.toml"
    assert not any(drive.lacks for drive in there.drives)


def test_behind_a_url_a_store_is_passed_over():
    pytest.importorskip("fsspec")
    from fsspec.core import url_to_fs

    url = "memory://find/stores"
    fs, path = url_to_fs(url)
    for name in ("van/a.csv", "mine/x.csv", "other/store.json", "other/y/z.csv", ".hidden/b.csv"):
        fs.pipe_file(f"{path}/{name}", table(T0, 30).encode())
    found = find_drives(url, f"{url}/mine")
    assert [drive.name for drive in found.drives] == ["van/a.csv"]
    assert found.left_out == ((f"{url}/other", "a results store of cogest"),)
