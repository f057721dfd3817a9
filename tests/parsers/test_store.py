"""The store: what is written reads back, in groups of one rate; a folder holds one drive, whatever was in it before."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from parsers.errors import LogError
from parsers.load import LoadOptions, load_drive
from parsers.store import group_table, rate_groups, write_drive
from parsers.store_folder import RECORD_FILE
from parsers.timebase import NS

FAST = np.arange(1000, dtype=np.int64) * (NS // 100)
SLOW = np.arange(100, dtype=np.int64) * (NS // 10) + 7


def signal(name, time_ns, group):
    return Signal(name, time_ns, np.sin(time_ns / NS + len(name)), name, group=group)


def drive_of(*signals, paths=()):
    record = ImportRecord("CSV table", tuple(paths), "0", "complete", 1, {}, (), "clock", None, 10.0, ())
    return Drive({s.name: s for s in signals}, record)


def test_signals_of_one_group_share_a_table_and_others_do_not():
    one, two, three = (
        signal("roll", FAST, "/imu"),
        signal("speed", SLOW, "/odom"),
        signal("pitch", FAST, "/imu"),
    )
    assert rate_groups([one, two, three]) == [[one, three], [two]]
    table = group_table([one, three])
    assert list(table) == ["time_ns", "roll_rad", "pitch_rad"]
    assert table["roll_rad"] == pytest.approx(one.values, abs=0)


def test_stamps_that_differ_within_a_group_leave_empty_cells_and_nothing_else():
    holey = signal("roll", np.delete(FAST, np.arange(200, 300)), "g")
    shifted = signal("pitch", FAST + 3, "g")
    table = group_table([holey, shifted])
    assert len(table["time_ns"]) == 1900
    assert (np.diff(table["time_ns"]) > 0).all()
    for each, column in ((holey, "roll_rad"), (shifted, "pitch_rad")):
        there = ~np.isnan(table[column])
        assert table["time_ns"][there].tolist() == each.time_ns.tolist()
        assert table[column][there].tolist() == each.values.tolist()


def test_what_is_written_reads_back(tmp_path):
    drive = drive_of(
        signal("accel_y", FAST, "/imu"), signal("roll", FAST, "/imu"), signal("speed", SLOW, "/odom")
    )
    written = write_drive(drive, tmp_path / "deep" / "tables")
    assert [path.name for path in written] == ["imu_100hz.parquet", "odom_10hz.parquet", RECORD_FILE]
    # the made-up motion breaks physics: the checks only look
    back = load_drive([tmp_path / "deep" / "tables"], LoadOptions(fix=False))
    for name, each in drive.signals.items():
        assert np.array_equal(back.signals[name].time_ns, each.time_ns)
        assert np.array_equal(back.signals[name].values, each.values)


def test_groups_whose_names_clash_get_files_of_their_own(tmp_path):
    drive = drive_of(
        signal("roll", FAST, "/A b"), signal("pitch", FAST, "/a/B"), signal("speed", FAST, "../..")
    )
    names = [path.name for path in write_drive(drive, tmp_path)]
    assert names == ["a_b_100hz.parquet", "a_b_100hz_2.parquet", "100hz.parquet", RECORD_FILE]
    assert all(path.parent == tmp_path for path in tmp_path.iterdir())


@pytest.mark.parametrize(
    ("group", "name"),
    [("table_100hz", "table"), ("table_100hz_100hz_2", "table"), ("/imu/200Hz", "imu"), ("100hz", ""), ("march_hz", "march_hz")],
)  # fmt: skip
def test_what_was_converted_before_keeps_its_name(tmp_path, group, name):
    written = write_drive(drive_of(signal("roll", FAST, group)), tmp_path)
    assert written[0].name == f"{name}_100hz.parquet".removeprefix("_")


def test_a_second_drive_takes_the_place_of_the_first(tmp_path):
    write_drive(drive_of(signal("roll", FAST, "/imu"), signal("speed", SLOW, "/odom")), tmp_path)
    (tmp_path / "notes.md").write_text("mine", encoding="utf-8")
    write_drive(drive_of(signal("roll", SLOW, "/imu")), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"imu_10hz.parquet", RECORD_FILE, "notes.md"}
    assert list(load_drive([tmp_path]).signals) == ["roll"]
    write_drive(drive_of(signal("roll", SLOW, "/imu")), tmp_path)
    assert len(list(tmp_path.iterdir())) == 3


def test_tables_of_others_are_neither_mixed_in_nor_touched(tmp_path):
    stranger = tmp_path / "stranger.parquet"
    pl.DataFrame({"time_ns": [0, 1], "speed_mps": [1.0, 2.0]}).write_parquet(stranger)
    before = stranger.read_bytes()
    with pytest.raises(LogError, match=r"did not write \(stranger\.parquet\).*empty folder with --out"):
        write_drive(drive_of(signal("roll", FAST, "/imu")), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["stranger.parquet"]
    assert stranger.read_bytes() == before


@pytest.mark.parametrize(
    "record",
    [
        '{"files": ["../keep.parquet", "notes.md", 3, null, "/etc/passwd"]}',
        '{"files": 3}',
        "[]",
        "{",
        "[" * 9000,
    ],
)
def test_a_record_that_somebody_made_up_removes_nothing(tmp_path, record):
    keep = tmp_path / "keep.parquet"
    keep.write_bytes(b"x")
    folder = tmp_path / "tables"
    folder.mkdir()
    (folder / "notes.md").write_text("mine", encoding="utf-8")
    (folder / RECORD_FILE).write_text(record, encoding="utf-8")
    write_drive(drive_of(signal("roll", FAST, "/imu")), folder)
    assert keep.exists()
    assert (folder / "notes.md").exists()


def test_a_write_that_fails_leaves_the_first_drive(tmp_path, monkeypatch):
    write_drive(drive_of(signal("roll", FAST, "/imu")), tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("parsers.parquet_write.TableFile.add", fail)
    with pytest.raises(LogError, match=r"cannot be written \(No space left on device\).*--out"):
        write_drive(drive_of(signal("speed", SLOW, "/odom")), tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_record_holds_any_path(tmp_path):
    write_drive(drive_of(signal("roll", FAST, ""), paths=[tmp_path / "a\udcff\n.csv"]), tmp_path / "out")
    record = json.loads((tmp_path / "out" / RECORD_FILE).read_text(encoding="utf-8"))
    assert record["paths"] == [str(tmp_path / "a?\n.csv")]
    assert record["files"] == ["100hz.parquet"]
