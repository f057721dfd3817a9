"""Drives in folders: what is one, what is not, and what belongs to it."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from pipelines.fleet.find import find_drives
from pipelines.fleet.records import BatchError, FoundDrive, FoundFleet

TABLE = "time_s,speed_mps,accel_y_mps2\n0.0,1.5,0.1\n0.1,1.6,0.2\n0.2,1.7,0.1\n"
VEHICLE = '[vehicle]\nname = "van 7"\nmass_kg = 1800\nwheelbase_m = 3.1\n'


def put(root: Path, files: dict[str, str | bytes]) -> Path:
    for number, (name, content) in enumerate(files.items()):
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            # no two logs alike
            path.write_text(content.replace("0.2,1.7", f"0.2,1.{number + 100}"), encoding="utf-8")
    return root


def by_name(found: FoundFleet) -> dict[str, FoundDrive]:
    return {drive.name: drive for drive in found.drives}


def reasons(found: FoundFleet) -> dict[str, str]:
    return {os.path.relpath(place, found.folder).replace(os.sep, "/"): why for place, why in found.left_out}


def test_the_sample_fleet(samples):
    found = find_drives(str(samples / "fleet"))
    assert len(found.drives) == 11
    assert {drive.vehicle_id for drive in found.drives} == {"sedan", "suv", "truck", "van"}
    assert found.left_out == ()
    assert not any(drive.lacks for drive in found.drives)
    blf = by_name(found)["van/tour_1.blf"]
    assert [Path(place).name for place in (*blf.logs, blf.vehicle, blf.map, *blf.dbc)] == [
        "tour_1.blf",
        "vehicle.toml",
        "map.toml",
        "chassis.dbc",
    ]
    assert blf.vehicle_name == "van (simulated)"
    assert blf.formats == ("Vector BLF",)
    assert blf.size == (samples / "fleet" / "van" / "tour_1.blf").stat().st_size
    assert found == find_drives(str(samples / "fleet"))


def test_one_recording_in_five_formats_is_one_drive(samples):
    found = find_drives(str(samples / "can"))
    assert [drive.name for drive in found.drives] == ["console.txt", "drive.mf4"]
    assert {Path(place).name for place, why in found.left_out if "same recording" in why} == {
        "drive.asc",
        "drive.blf",
        "drive.log",
        "drive.trc",
    }
    assert len(by_name(found)["drive.mf4"].notes) == 4


def test_bag_folders_are_drives_and_what_lies_beside_them_too(samples, tmp_path):
    shutil.copytree(samples / "ros", tmp_path / "ros")
    shutil.copy(samples / "csv" / "drive.csv", tmp_path / "ros" / "drive_sqlite3" / "notes_of_another.csv")
    drives = by_name(find_drives(str(tmp_path)))
    assert drives["ros/drive_sqlite3"].logs == (str(tmp_path / "ros" / "drive_sqlite3"),)
    assert drives["ros/drive_mcap"].formats == ("ROS 2 bag",)
    assert set(drives) == {
        "ros/drive.bag",
        "ros/drive_mcap",
        "ros/drive_ros1.mcap",
        "ros/drive_ros2.mcap",
        "ros/drive_sqlite3",
        "ros/drive_sqlite3/notes_of_another.csv",
    }
    whole = find_drives(str(tmp_path / "ros" / "drive_mcap"))
    assert [(drive.name, drive.logs) for drive in whole.drives] == [
        ("drive_mcap", (str(tmp_path / "ros" / "drive_mcap"),))
    ]


def test_a_folder_of_mcap_files_is_no_bag(samples, tmp_path):
    for day in ("monday", "wednesday"):
        shutil.copy(samples / "fleet" / "suv" / f"{day}.mcap", tmp_path)
    assert len(find_drives(str(tmp_path)).drives) == 2


def test_a_converted_drive_is_one(samples, tmp_path):
    from parsers.load import load_drive
    from parsers.store import write_drive

    drive = load_drive([samples / "csv" / "drive.csv"])
    write_drive(drive, tmp_path / "suv" / "converted")
    put(tmp_path, {"suv/other.csv": TABLE})
    found = by_name(find_drives(str(tmp_path)))
    assert found["suv/converted"].logs == (str(tmp_path / "suv" / "converted"),)
    (tmp_path / "suv" / "converted" / "picture.png").write_bytes(b"\x89PNG")
    again = by_name(find_drives(str(tmp_path)))
    assert set(again) == {"suv/other.csv", *(name for name in again if name.startswith("suv/converted/"))}
    assert len(again) == 2


def test_what_cannot_be_read_stays_a_drive_and_says_so(samples, tmp_path):
    blf = (samples / "fleet" / "van" / "tour_1.blf").read_bytes()
    put(
        tmp_path,
        {
            "empty.csv": b"",
            "header.csv": b"time,ay\n",
            "junk.mf4": b"junk",
            "zeros.blf": b"\0" * 500,
            "binary.csv": b"\0\1\2" * 300,
            "cut.blf": blf[:300],
            "broken.parquet": b"PAR1 and no more",
        },
    )
    found = by_name(find_drives(str(tmp_path)))
    assert set(found) == {path.name for path in tmp_path.iterdir()}
    for name in ("empty.csv", "header.csv", "junk.mf4", "zeros.blf", "binary.csv"):
        assert any("will fail" in lack for lack in found[name].lacks), name
    assert "0 bytes" in found["empty.csv"].lacks[0]


def test_what_is_no_log_is_named_with_its_reason(tmp_path):
    import polars as pl

    put(
        tmp_path,
        {
            "suv/drive.csv": TABLE,
            "README.txt": "what this folder is\n",
            "notes.csv": "what,how many\napples,3\nplums,4\npears,5\n",
            "fuel.csv": "date,litres\n2024-01-03,33\n2024-01-04,31\n2024-01-08,30\n",
            "words.csv": "just some words, and no numbers\n",
            "empty.txt": b"",
            "service.log": "".join(
                f"2026-05-01 10:00:{k:02d} INFO drive a/{k} done in 3.5 s\n" for k in range(60)
            ),
            "photo.jpg": b"\xff\xd8\xff",
            "data.json": "{}",
            "archive": b"\x1f\x8b\x08 something",
            "suv/second.csv.gz": b"\x1f\x8b\x08 something",
            "all.zip": b"PK\x03\x04",
            ".hidden.csv": TABLE,
            ".git/x.csv": TABLE,
        },
    )
    pl.DataFrame({"a": [1, 2], "b": [1.5, 2.5]}).write_parquet(tmp_path / "prices.parquet")
    pl.DataFrame({"Date": ["2024-01-03", "2024-01-04"], "b": [1.5, 2.5]}).write_parquet(
        tmp_path / "fuel.parquet"
    )
    times = [f"2024-01-03T10:20:{k:02d}Z" for k in range(9)]
    pl.DataFrame({"time": times, "speed_mps": [float(k) for k in range(9)]}).write_parquet(
        tmp_path / "suv/texts.parquet"
    )
    found = find_drives(str(tmp_path))
    assert [drive.name for drive in found.drives] == ["suv/drive.csv", "suv/texts.parquet"]
    why = reasons(found)
    assert set(why) == {
        "README.txt", "service.log", "notes.csv", "fuel.csv", "words.csv", "empty.txt", "photo.jpg", "data.json", "archive",
        "prices.parquet", "fuel.parquet", "suv/second.csv.gz", "all.zip",
    }  # fmt: skip
    assert why["suv/second.csv.gz"] == "a packed log, by its name: unpack it (gunzip)"
    assert why["all.zip"] == "packed: unpack it (unzip), if a log is in it"
    assert "no time column" in why["notes.csv"]
    assert "dates without a time of day" in why["fuel.csv"]
    assert "without a time column" in why["prices.parquet"]


def test_a_map_may_name_the_time_column_of_a_table(tmp_path):
    files = {"suv/drive.csv": "k,speed_mps\n0.0,3\n0.1,4\n0.2,5\n"}
    with pytest.raises(BatchError, match="no log"):
        find_drives(str(put(tmp_path, files)))
    put(tmp_path, {"map.toml": '[time]\nchannel = "k"\nunit = "s"\n'})
    assert len(find_drives(str(tmp_path)).drives) == 1


def test_a_tables_own_map_may_name_its_time_column_too(tmp_path):
    clock = '[time]\nchannel = "k"\nunit = "s"\n'
    files = {"suv/drive.csv": "k,speed_mps\n0.0,3\n0.1,4\n0.2,5\n", "suv/drive.map.toml": clock}
    files["suv/map.toml"] = clock.replace('"k"', '"other"')
    (found,) = find_drives(str(put(tmp_path, files))).drives
    assert (found.map or "").endswith("drive.map.toml")
    assert not any("will fail" in lack for lack in found.lacks)


def test_nothing_of_cogests_own_is_a_log(tmp_path):
    put(
        tmp_path,
        {
            "suv/drive.csv": TABLE,
            "suv/report/report.html": "<html>",
            "suv/report/results.json": "{}",
            "suv/report/tire_normal_forces.parquet": b"PAR1",
            "suv/drive.truth.json": "{}",
            "suv/vehicle.toml": VEHICLE,
            "suv/suspension.toml": "x = 1",
            "old/store.json": "{}",
            "old/drives/aa/x.csv": TABLE,
            "mine/drives.csv": TABLE,
        },
    )
    found = find_drives(str(tmp_path), str(tmp_path / "mine"))
    assert [drive.name for drive in found.drives] == ["suv/drive.csv"]
    assert reasons(found) == {"old": "a results store of cogest"}


def test_links_are_followed_once_and_never_in_a_ring(tmp_path):
    fleet, elsewhere = tmp_path / "fleet", tmp_path / "elsewhere"
    put(fleet, {"suv/drive.csv": TABLE})
    put(elsewhere, {"sedan/tour.csv": TABLE, "single.csv": TABLE})
    (fleet / "ring").symlink_to(fleet)
    (fleet / "up").symlink_to(tmp_path)
    (fleet / "suv" / "again.csv").symlink_to(fleet / "suv" / "drive.csv")
    (fleet / "out").symlink_to(elsewhere / "sedan")
    (fleet / "out2").symlink_to(elsewhere / "sedan")
    (fleet / "single.csv").symlink_to(elsewhere / "single.csv")
    (fleet / "nowhere.csv").symlink_to(tmp_path / "gone.csv")
    os.mkfifo(fleet / "pipe.csv")
    found = find_drives(str(fleet))
    assert [drive.name for drive in found.drives] == ["out/tour.csv", "single.csv", "suv/drive.csv"]
    assert set(reasons(found)) == {"ring", "up", "suv/again.csv", "out2", "nowhere.csv", "pipe.csv"}


def test_copies_of_a_file_manager_are_left_out_and_other_twins_named(tmp_path):
    text = TABLE.encode()
    put(
        tmp_path,
        {"v/a.csv": text, "v/a (1).csv": text, "v/a - Copy.csv": text + b"0.3,1,1\n", "w/b.csv": text},
    )
    found = find_drives(str(tmp_path))
    assert [drive.name for drive in found.drives] == ["v/a - Copy.csv", "v/a.csv", "w/b.csv"]
    assert reasons(found) == {"v/a (1).csv": "a copy of a.csv: the same bytes"}
    (lack,) = (lack for lack in by_name(found)["w/b.csv"].lacks if "the same bytes" in lack)
    assert lack == "the same bytes as v/a.csv, which is of vehicle v: it counts for both vehicles; remove one"
    put(tmp_path, {"v/later/c.csv": text})
    again = by_name(find_drives(str(tmp_path)))["v/later/c.csv"]
    # what joining does with them: nothing is to be done
    assert "the same bytes as v/a.csv: for their vehicle they count once" in again.notes
    assert not any("the same bytes" in lack for lack in again.lacks)


def test_a_copy_with_other_bytes_in_between_is_not_called_the_same(tmp_path):
    rows = "".join(f"{k * 0.1:.1f},{k % 37},{k % 11}\n" for k in range(60_000)).encode()
    text = TABLE.encode() + rows
    # between the places that are looked at first
    at = len(text) // 2 + len(text) // 64
    damaged = text[:at] + bytes([text[at] ^ 1]) + text[at + 1 :]
    other = text[: len(text) // 4] + text[: len(text) - len(text) // 4]
    put(
        tmp_path,
        {"v/a.csv": text, "v/a (1).csv": damaged, "v/b.csv": other, "v/z.csv": damaged, "w/c.csv": damaged},
    )
    assert len({len(text), len(damaged), len(other)}) == 1
    found = find_drives(str(tmp_path))
    assert reasons(found) == {}
    drives = by_name(found)
    mostly = "the same size as, and for the most part the same bytes as, v/a (1).csv: one of the two is damaged or was changed, and they count once only where both begin at one moment of a known date; remove one"
    assert mostly in drives["v/a.csv"].lacks
    assert "the same bytes as v/a (1).csv: for their vehicle they count once" in drives["v/z.csv"].notes
    assert any(
        lack.startswith("the same bytes as v/a (1).csv, which is of vehicle v")
        for lack in drives["w/c.csv"].lacks
    )
    assert not any("same" in text for text in (*drives["v/b.csv"].lacks, *drives["v/b.csv"].notes))


def test_a_folder_that_cannot_be_used(tmp_path):
    with pytest.raises(BatchError, match="no such folder"):
        find_drives(str(tmp_path / "none"))
    put(tmp_path, {"a.csv": TABLE, "empty/x.txt": "words"})
    with pytest.raises(BatchError, match="analyze"):
        find_drives(str(tmp_path / "a.csv"))
    with pytest.raises(BatchError, match=r"no log in this folder.*x\.txt"):
        find_drives(str(tmp_path / "empty"))


def test_ids_stay_when_other_files_come(tmp_path):
    put(tmp_path, {"suv/a.csv": TABLE})
    before = find_drives(str(tmp_path)).drives[0].drive_id
    put(tmp_path, {"suv/b.csv": TABLE, "suv/a.txt": "x", "sedan/a.csv": TABLE, "vehicle.toml": VEHICLE})
    found = find_drives(str(tmp_path))
    assert by_name(found)["suv/a.csv"].drive_id == before
    assert len({drive.drive_id for drive in found.drives}) == 3
    moved = shutil.copytree(tmp_path, tmp_path.parent / f"{tmp_path.name}_moved")
    assert {d.drive_id for d in find_drives(str(moved)).drives} == {d.drive_id for d in found.drives}


def test_what_a_dead_link_hides_is_not_known_to_be_gone(tmp_path):
    put(tmp_path, {"suv/drive.csv": TABLE})
    (tmp_path / "van").symlink_to(tmp_path.parent / "away", target_is_directory=True)
    found = find_drives(str(tmp_path))
    assert found.unread == ("van",)
    assert found.hides("van/drive.csv")
    assert not found.hides("vans/drive.csv")
    assert not found.hides("suv/gone.csv")
