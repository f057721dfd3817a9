"""Tables with a time column for each raster: every column has its own raster's stamps, and second clocks are no rasters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from csv_tables import Read

from parsers.csv_log import CsvImporter
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.load import load_drive
from parsers.parquet_log import ParquetImporter

FAST = np.arange(400) / 20
SLOW = np.arange(200) / 10


def side_by_side(
    headers: list[str], columns: list[np.ndarray], separator: str = ",", decimal: str = "."
) -> str:
    """Columns beside each other; those that are shorter have empty cells at the end."""
    rows = [separator.join(headers)]
    for k in range(max(map(len, columns))):
        cells = (f"{c[k]:.4f}".replace(".", decimal) if k < len(c) else "" for c in columns)
        rows.append(separator.join(cells))
    return "\n".join(rows) + "\n"


def chunks_of(path: Path, options: ReadOptions | None = None) -> tuple[dict[str, tuple], ImportLog]:
    """Channel -> stamps in s and values, those that are there."""
    log = ImportLog()
    reader = CsvImporter().open(path, options or ReadOptions(), log)
    found: dict[str, list] = {}
    for chunk in reader.read(frozenset(info.name for info in reader.channels)):
        for name, values in chunk.columns.items():
            found.setdefault(name, []).append((chunk.time_ns / 1e9, values))
    joined = {name: tuple(np.concatenate(each) for each in zip(*parts)) for name, parts in found.items()}  # noqa: B905
    return joined, log


def is_two_rasters(found: dict[str, tuple], fast: str = "AccY", slow: str = "Speed") -> bool:
    return all(
        np.allclose(found[name][0], t, atol=1e-9) and np.allclose(found[name][1], np.sin(t), atol=1e-4)
        for name, t in ((fast, FAST), (slow, SLOW))
    )


@pytest.mark.parametrize(
    ("headers", "how"),
    [
        (["Time_A [s]", "AccY [m/s^2]", "Time_B [s]", "Speed [m/s]"], "before it"),
        (["Zeit [s]", "AccY [m/s^2]", "Zeit [s]", "Speed [m/s]"], "before it"),
        (["time_50ms [s]", "AccY [m/s^2]", "time_100ms [s]", "Speed [m/s]"], "before it"),
        (["Time_fast [s]", "AccY [m/s^2]", "Time_slow [s]", "Speed [m/s]"], "before it"),
        (["AccY [m/s^2]", "Time_A [s]", "Speed [m/s]", "Time_B [s]"], "behind it"),
    ],
)
def test_each_raster_has_its_own_stamps(headers, how, tmp_path):
    path = tmp_path / "log.csv"
    columns = [FAST, np.sin(FAST), SLOW, np.sin(SLOW)]
    if how == "behind it":
        columns = [columns[k] for k in (1, 0, 3, 2)]
    path.write_text(side_by_side(headers, columns), encoding="utf-8")
    found, log = chunks_of(path)
    assert is_two_rasters(found)
    assert any(f"stamps of the time column {how}" in note for note in log.notes)
    assert (log.messages, dict(log.rejected), log.lost_spans_ns) == (600, {}, [])
    drive = load_drive([path])
    assert {name: len(s.values) for name, s in drive.signals.items()} == {"accel_y": 400, "speed": 200}
    assert drive.record.status == "complete"


@pytest.mark.parametrize("separator", [";", "\t"])
def test_the_shorter_raster_may_come_first_and_decimals_be_commas(separator, tmp_path):
    path = tmp_path / "log.csv"
    headers = ["Zeit [s]", "Speed [m/s]", "Zeit [s]", "AccY [m/s^2]"]
    columns = [SLOW, np.sin(SLOW), FAST, np.sin(FAST)]
    path.write_text(side_by_side(headers, columns, separator, ","), encoding="utf-8")
    found, log = chunks_of(path)
    assert is_two_rasters(found)
    assert not log.rejected


def test_columns_belong_to_the_time_that_ends_as_they_do(tmp_path):
    path = tmp_path / "log.csv"
    headers = ["Time_A [s]", "Time_B [s]", "Speed_B [m/s]", "AccY_A [m/s^2]"]
    path.write_text(side_by_side(headers, [FAST, SLOW, np.sin(SLOW), np.sin(FAST)]), encoding="utf-8")
    found, log = chunks_of(path)
    assert is_two_rasters(found, "AccY_A", "Speed_B")
    assert any("that ends as its name does" in note for note in log.notes)


def test_dates_for_each_raster(tmp_path):
    path = tmp_path / "log.csv"
    day = np.datetime64("2026-11-23T08:00:00.000")
    rows = ["Time,AccY [m/s^2],Time,Speed [m/s]"]
    for k in range(400):
        fast = f"{day + np.timedelta64(50 * k, 'ms')}Z,{np.sin(FAST[k]):.4f}"
        slow = f"{day + np.timedelta64(100 * k, 'ms')}Z,{np.sin(SLOW[k]):.4f}" if k < 200 else ","
        rows.append(f"{fast},{slow}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    found, _ = chunks_of(path)
    zero = float(found["AccY"][0][0])
    assert np.allclose(found["Speed"][0] - zero, SLOW, atol=1e-5)
    assert np.allclose(found["Speed"][1], np.sin(SLOW), atol=1e-4)


def test_where_nothing_tells_which_columns_belong_to_which_it_is_an_error(tmp_path):
    path = tmp_path / "log.csv"
    headers = ["Time_A [s]", "Time_B [s]", "Speed [m/s]", "AccY [m/s^2]"]
    path.write_text(side_by_side(headers, [FAST, SLOW, np.sin(SLOW), np.sin(FAST)]), encoding="utf-8")
    with pytest.raises(LogError, match=r'different pace \("Time_A", "Time_B"\), and nothing tells'):
        chunks_of(path)
    found, _ = chunks_of(path, ReadOptions(time_channel="Time_A"))
    assert np.allclose(found["AccY"][0], FAST)


SPARSE = np.where(np.arange(400) % 10 == 0, FAST + 1000, np.nan)


@pytest.mark.parametrize(
    ("header", "clock"),
    [
        ("Time_GPS [s]", FAST + 300_000.02),
        ("GPS Time [s]", np.floor(FAST)),
        ("Lap Time [s]", FAST % 7),
        ("Lap Time [s]", FAST + 3),
        ("Time_received [s]", FAST + 0.01 * np.random.default_rng(1).random(400)),
        ("Time_raw", FAST * 1000),
        ("Time_us", FAST * 1e6),
        ("Time left [s]", 100 - FAST),
        ("Time_bus [s]", SPARSE),
        ("Time [s]", FAST),
    ],
)
def test_a_second_clock_of_the_same_rows_is_no_raster(header, clock, tmp_path):
    path = tmp_path / "log.csv"
    headers = ["Time [s]", "AccY [m/s^2]", header, "Speed [m/s]"]
    text = side_by_side(headers, [FAST, np.sin(FAST), clock, np.sin(FAST)]).replace("nan", "")
    path.write_text(text, encoding="utf-8")
    found, log = chunks_of(path)
    assert np.allclose(found["Speed"][0], FAST)
    assert np.allclose(found["Speed"][1], np.sin(FAST), atol=1e-4)
    assert not any("several time columns" in note for note in log.notes)


@pytest.mark.parametrize(
    "times",
    [
        # alike but for a number; alike in pace, and within a row; beside rasters of another pace
        ("Time_IMU_Dyn1 [s]", "Time_IMU_Dyn2 [s]"),
        ("Time_IMU [s]", "Time_Wheels [s]"),
        ("Time_IMU [s]", "Time_Level [s]", "Time_Chassis [s]"),
    ],
)
def test_rasters_of_one_pace_lose_frames_each_on_its_own(times, tmp_path):
    rng = np.random.default_rng(3)
    own = [FAST + 0.004, *(np.delete(FAST + 0.011, 250) for _ in times[1:])]
    own = [t + 0.002 * rng.random(len(t)) for t in own]
    if len(times) == 3:
        own[2], own[1] = SLOW + 0.3, own[1] + 0.2
    names = ["AccY", "Speed", "YawRate"][: len(times)]
    headers = [h for pair in zip(times, names, strict=True) for h in pair]
    path = tmp_path / "log.csv"
    path.write_text(side_by_side(headers, [c for t in own for c in (t, np.sin(t))]), encoding="utf-8")
    found, log = chunks_of(path)
    for name, t in zip(names, own, strict=True):
        assert np.allclose(found[name][0], t, atol=1e-4)
    assert any("each column has the stamps of the time column before it" in note for note in log.notes)


def test_damage_is_counted_once(tmp_path):
    path = tmp_path / "log.csv"
    headers = ["Time_A [s]", "AccY [m/s^2]", "Time_B [s]", "Speed [m/s]"]
    lines = side_by_side(headers, [FAST, np.sin(FAST), FAST * 2, np.sin(FAST)]).split("\n")
    lines[30] = lines[30][:12]
    lines[50] = lines[50].rpartition(",")[0] + ",broken"
    path.write_text("\n".join(lines)[:-4], encoding="utf-8")
    found, log = chunks_of(path)
    assert dict(log.rejected) == {
        "row with too few columns": 1,
        "cell with text where a number was expected": 1,
        "row cut off at the end of the file": 1,
    }
    assert log.status == "truncated"
    assert sum("breaks off" in note for note in log.notes) == 1
    # the row was cut in the second raster's last cell: the first one's sample is whole
    assert (len(found["AccY"][0]), len(found["Speed"][0])) == (399, 398)


def test_a_row_that_breaks_off_is_said_once(tmp_path):
    path = tmp_path / "log.csv"
    headers = ["Time_A [s]", "AccY [m/s^2]", "Time_B [s]", "Speed [m/s]"]
    text = side_by_side(headers, [FAST, np.sin(FAST), FAST * 2, np.sin(FAST)])
    path.write_text(text[:-12], encoding="utf-8")
    _, log = chunks_of(path)
    assert sum("breaks off" in note for note in log.notes) == 1
    assert dict(log.rejected) == {"row with too few columns": 1}


def test_only_the_wanted_rasters_are_read(tmp_path):
    path = tmp_path / "log.csv"
    headers = ["Time_A [s]", "AccY [m/s^2]", "Time_B [s]", "Speed [m/s]"]
    path.write_text(side_by_side(headers, [FAST, np.sin(FAST), SLOW, np.sin(SLOW)]), encoding="utf-8")
    log, seen = ImportLog(), []
    reader = CsvImporter().open(path, ReadOptions(progress=lambda *at: seen.append(at)), log)
    chunks = list(reader.read(frozenset({"Speed"})))
    assert {chunk.group for chunk in chunks} == {reader.channels[1].group}
    assert log.messages == 200
    assert seen[-1][0] == seen[-1][1]


def test_a_parquet_table_leaves_out_what_has_other_stamps(tmp_path):
    path = tmp_path / "log.parquet"
    empty = [None] * 200
    columns = {
        "Time_A [s]": FAST,
        "AccY [m/s^2]": np.sin(FAST),
        "Time_B [s]": [*SLOW, *empty],
        "Speed [m/s]": [*SLOW, *empty],
    }
    pl.DataFrame(columns).write_parquet(path)
    log = ImportLog()
    reader = ParquetImporter().open(path, ReadOptions(), log)
    assert [info.name for info in reader.channels] == ["AccY"]
    assert any('only the first is read: "Time_B", "Speed" left out' in note for note in log.notes)


def test_tables_without_a_second_time_are_read_as_before(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(side_by_side(["t [s]", "a"], [FAST, np.sin(FAST)]), encoding="utf-8")
    table = Read(path)
    assert {info.group for info in table.info.values()} == {"table"}
