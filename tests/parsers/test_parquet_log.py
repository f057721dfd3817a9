"""Parquet: what cogest writes comes back; tables of others are read by their time column; damage is one clear line."""

from __future__ import annotations

from datetime import UTC, datetime, time
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import parsers.parquet_log
from parsers.channels import Chunk
from parsers.errors import LogError
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.parquet_log import ParquetImporter


def read(path: Path, options: ReadOptions | None = None) -> tuple[LogReader, list[Chunk], ImportLog]:
    log = ImportLog()
    reader = ParquetImporter().open(path, options or ReadOptions(), log)
    numbers = frozenset(channel.name for channel in reader.channels if channel.kind == "number")
    return reader, list(reader.read(numbers)), log


def test_canonical_table(tmp_path: Path) -> None:
    path = tmp_path / "imu_100hz.parquet"
    time = [1_400_000_000_000_000_001, 1_400_000_000_010_000_003]
    pl.DataFrame(
        {"time_ns": time, "accel_y_mps2": [1.5, None], "roll_rate_radps": [0.25, -0.5]}
    ).write_parquet(path)
    reader, (chunk,), log = read(path)
    assert reader.absolute
    assert chunk.time_ns.tolist() == time
    assert chunk.time_ns.dtype == np.int64
    np.testing.assert_array_equal(chunk.columns["accel_y_mps2"], [1.5, np.nan])
    assert chunk.columns["roll_rate_radps"].tolist() == [0.25, -0.5]
    assert [(c.name, c.unit, c.group, c.count) for c in reader.channels] == [
        ("accel_y_mps2", "m/s²", "imu_100hz", 2),
        ("roll_rate_radps", "rad/s", "imu_100hz", 2),
    ]
    assert log.messages == 2
    assert not log.notes


def test_folder_with_a_file_a_rate_group(tmp_path: Path) -> None:
    pl.DataFrame({"time_ns": [0, 10, 20], "accel_y_mps2": [1.0, 2.0, 3.0]}).write_parquet(
        tmp_path / "fast.parquet"
    )
    pl.DataFrame({"time_ns": [5], "speed_mps": [9.0], "accel_y_mps2": [4.0]}).write_parquet(
        tmp_path / "slow.parquet"
    )
    (tmp_path / "import_record.json").write_text("{}")
    assert ParquetImporter().claims(tmp_path, b"")
    reader, chunks, log = read(tmp_path)
    assert {c.name: c.group for c in reader.channels} == {
        "accel_y_mps2": "fast",
        "speed_mps": "slow",
        "accel_y_mps2_2": "slow",
    }
    assert {chunk.group: chunk.time_ns.tolist() for chunk in chunks} == {"fast": [0, 10, 20], "slow": [5]}
    assert chunks[1].columns["accel_y_mps2_2"].tolist() == [4.0]
    assert any("repeated" in note for note in log.notes)
    assert not reader.absolute
    only = list(ParquetImporter().open(tmp_path, ReadOptions(), ImportLog()).read(frozenset({"speed_mps"})))
    assert [list(chunk.columns) for chunk in only] == [["speed_mps"]]


def test_claims(tmp_path: Path) -> None:
    importer = ParquetImporter()
    assert importer.claims(tmp_path / "log.csv", b"PAR1\x15\x04")
    assert not importer.claims(tmp_path / "log.parquet", b"t,a\n0,1\n")
    assert not importer.claims(tmp_path, b"")
    (tmp_path / "a.parquet").touch()
    assert importer.claims(tmp_path, b"")
    (tmp_path / "other.csv").touch()
    assert not importer.claims(tmp_path, b"")


@pytest.mark.parametrize("zone", [None, "UTC", "Europe/Stockholm"])
@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
def test_time_stamps(zone: str | None, unit: str, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    moment = datetime(2014, 4, 11, 8, 38, 56, 300_000, tzinfo=UTC if zone else None)
    series = pl.Series("when", [moment, None]).cast(pl.Datetime(unit, zone))  # type: ignore[arg-type]
    pl.DataFrame([series, pl.Series("a [g]", [1.0, 2.0]), pl.Series("state", ["ON", "OFF"])]).write_parquet(
        path
    )
    reader, (chunk,), log = read(path)
    assert chunk.time_ns.tolist() == [1_397_205_536_300_000_000]
    assert chunk.columns["a"].tolist() == [1.0]
    assert reader.absolute
    assert [(c.name, c.kind, c.unit) for c in reader.channels] == [
        ("a", "number", "g"),
        ("state", "text", None),
    ]
    assert log.rejected == {"row without a valid time": 1}
    assert any("no time zone" in note for note in log.notes) == (zone is None)


@pytest.mark.parametrize(
    ("column", "values", "options", "expected"),
    [
        ("t", [0.0, 0.01], ReadOptions(), [0, 10_000_000]),
        ("time_ms", [1, 2], ReadOptions(), [1_000_000, 2_000_000]),
        ("x", [1, 2], ReadOptions(time_channel="x", time_unit="us"), [1000, 2000]),
        (
            "timestamp",
            [1_397_205_536_123_456_789, 1_397_205_536_123_456_790],
            ReadOptions(),
            [1_397_205_536_123_456_789, 1_397_205_536_123_456_790],
        ),
        ("time_s", [0.5, float("nan")], ReadOptions(), [500_000_000]),
        ("time_s", [2**62, 3], ReadOptions(), [3_000_000_000]),
    ],
)
def test_times_as_numbers(
    column: str, values: list[float], options: ReadOptions, expected: list[int], tmp_path: Path
) -> None:
    path = tmp_path / "log.parquet"
    pl.DataFrame({column: values, "a": [True, False]}).write_parquet(path)
    _, (chunk,), _ = read(path, options)
    assert chunk.time_ns.tolist() == expected
    assert set(chunk.columns["a"].tolist()) <= {0.0, 1.0}


@pytest.mark.parametrize("unit", ["ns", "us", "ms"])
def test_a_stretch_of_time_as_parquet_has_it(unit: str, tmp_path: Path) -> None:
    stretch = pl.Series([0, 20, None, 86_400_040], dtype=pl.Int64) * (10 ** {"ns": 6, "us": 3, "ms": 0}[unit])
    frame = pl.DataFrame({"time": stretch.cast(pl.Duration(unit)), "ay": [1.0, 2.0, 3.0, 4.0]})  # type: ignore[arg-type]
    frame.write_parquet(tmp_path / "log.parquet")
    reader, (chunk,), log = read(tmp_path / "log.parquet")
    assert not reader.absolute
    assert chunk.time_ns.tolist() == [0, 20_000_000, 86_400_040_000_000]
    assert log.rejected == {"row without a valid time": 1}
    assert not log.notes


def test_a_number_that_is_the_time_by_its_name_stays_it(tmp_path: Path) -> None:
    since = pl.Series([5, 25, 45]).cast(pl.Duration("ms"))
    frame = pl.DataFrame({"since_start": since, "time_s": [0.0, 0.5, 1.0], "ay": [1.0, 2.0, 3.0]})
    frame.write_parquet(tmp_path / "log.parquet")
    assert read(tmp_path / "log.parquet")[1][0].time_ns.tolist() == [0, 500_000_000, 1_000_000_000]


def test_slices_join_without_a_seam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parsers.parquet_log, "_CHUNK_BYTES", 1)
    path = tmp_path / "log.parquet"
    values = np.random.default_rng(1).normal(size=10_000)
    pl.DataFrame({"time_ns": np.arange(10_000), "a": values}).write_parquet(path, row_group_size=3000)
    _, chunks, log = read(path)
    assert len(chunks) == 10
    np.testing.assert_array_equal(np.concatenate([chunk.columns["a"] for chunk in chunks]), values)
    np.testing.assert_array_equal(np.concatenate([chunk.time_ns for chunk in chunks]), np.arange(10_000))
    assert log.messages == 10_000


def _bytes(tmp_path: Path) -> bytes:
    path = tmp_path / "whole.parquet"
    pl.DataFrame({"time_ns": np.arange(5000), "a": np.random.default_rng(1).normal(size=5000)}).write_parquet(
        path
    )
    return path.read_bytes()


@pytest.mark.parametrize("cut", [0, 4, 11, 1000, 20_000])
def test_truncated(cut: int, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    path.write_bytes(_bytes(tmp_path)[:cut])
    with pytest.raises(LogError, match="empty" if cut == 0 else "truncated") as caught:
        ParquetImporter().open(path, ReadOptions(), ImportLog())
    assert str(path) in str(caught.value)


def test_damaged_footer_or_middle_is_a_clear_error(tmp_path: Path) -> None:
    whole = _bytes(tmp_path)
    path = tmp_path / "log.parquet"
    for start in (len(whole) // 2, len(whole) - 300, len(whole) - 60):
        data = bytearray(whole)
        data[start : start + 50] = bytes(range(200, 250))
        path.write_bytes(bytes(data))
        try:
            _, chunks, log = read(path)
        except LogError as error:
            assert "damaged" in str(error)  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017
        else:
            assert sum(len(chunk.time_ns) for chunk in chunks) + log.rejected.total() == 5000


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (pl.DataFrame({"a": [1.0], "b": [2.0]}), "no time column"),
        (pl.DataFrame({"time_ns": pl.Series([], dtype=pl.Int64)}), "no rows"),
        (pl.DataFrame({"time": ["11.04.2014 08:00:00"], "a": [1.0]}), "is text"),
    ],
)
def test_tables_without_a_usable_time(frame: pl.DataFrame, message: str, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    frame.write_parquet(path)
    with pytest.raises(LogError, match=message):
        ParquetImporter().open(path, ReadOptions(), ImportLog())


def test_clocks_that_cannot_be_joined(tmp_path: Path) -> None:
    pl.DataFrame({"time_ns": [0, 10], "a": [1.0, 2.0]}).write_parquet(tmp_path / "a.parquet")
    pl.DataFrame({"time_ns": [1_400_000_000_000_000_000], "b": [1.0]}).write_parquet(tmp_path / "b.parquet")
    with pytest.raises(LogError, match="common clock"):
        ParquetImporter().open(tmp_path, ReadOptions(), ImportLog())


@pytest.mark.parametrize("chunk_bytes", [None, 4096])
def test_whole_seconds_of_a_fast_table_are_spread(
    chunk_bytes: int | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if chunk_bytes:
        monkeypatch.setattr(parsers.parquet_log, "_CHUNK_BYTES", chunk_bytes)
    rows = np.arange(3000)
    path = tmp_path / "log.parquet"
    pl.DataFrame(
        {"time_ns": 1_700_000_000_000_000_000 + rows // 50 * 1_000_000_000, "accel_y_mps2": rows / 7}
    ).write_parquet(path)
    _, chunks, log = read(path)
    time_ns = np.concatenate([c.time_ns for c in chunks])
    np.testing.assert_array_equal(time_ns, 1_700_000_000_000_000_000 + rows * 20_000_000)
    np.testing.assert_array_equal(np.concatenate([c.columns["accel_y_mps2"] for c in chunks]), rows / 7)
    assert len(chunks) > 1 if chunk_bytes else len(chunks) == 2
    assert log.messages == 3000
    assert any("coarser than the rows" in note for note in log.notes)


def test_rows_of_one_signal_each_become_one_row(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    pl.DataFrame(
        {
            "time_ns": np.repeat(np.arange(300) * 10_000_000, 2),
            "accel_x_mps2": [1.0, None] * 300,
            "accel_y_mps2": [None, 2.0] * 300,
        }
    ).write_parquet(path)
    _, chunks, _ = read(path)
    assert sum(len(c.time_ns) for c in chunks) == 300
    for name, value in (("accel_x_mps2", 1.0), ("accel_y_mps2", 2.0)):
        assert all((c.columns[name] == value).all() for c in chunks)


def test_a_time_of_day_runs_on_over_midnight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parsers.parquet_log, "_CHUNK_BYTES", 1)
    clock = [time(23, 59, 59, 500_000 + 10 * k) for k in range(1500)] + [time(0, 0, 0, k) for k in range(3)]
    frame = pl.DataFrame({"time": [None, *clock], "speed": [float(k) for k in range(1504)]})
    frame.write_parquet(tmp_path / "a.parquet")
    reader, chunks, log = read(tmp_path / "a.parquet")
    assert not reader.absolute
    assert len(chunks) > 1
    day = 86_400_000_000_000
    found = np.concatenate([chunk.time_ns for chunk in chunks])
    first = day - 500_000_000
    assert found.tolist() == [*range(first, first + 15_000_000, 10_000), day, day + 1000, day + 2000]
    assert log.rejected == {"row without a valid time": 1}
    assert any("the time of day without a date" in note for note in log.notes)


def test_columns_of_structures_and_lists_are_named(tmp_path: Path) -> None:
    frame = pl.DataFrame(
        {"time_ns": [0, 1], "imu": [{"ax": 1.0}, {"ax": 2.0}], "all": [[1.0], [2.0]], "v": [1.0, 2.0]}
    )
    frame.write_parquet(tmp_path / "a.parquet")
    _, chunks, log = read(tmp_path / "a.parquet")
    assert list(chunks[0].columns) == ["v"]
    assert [note for note in log.notes if "structures or lists" in note] == [
        'columns of structures or lists are not read: "imu", "all"; write their fields as columns of their own'
    ]


def part(path: Path, time_s: list[float], **columns: list[object]) -> None:
    pl.DataFrame({"time_s": time_s, **columns}).write_parquet(path)


def test_files_with_the_same_columns_are_parts_of_one_table(tmp_path: Path) -> None:
    part(tmp_path / "part-0.parquet", [20.0, 21.0], ay=[5.0, 6.0], vx=[1, 2])
    part(tmp_path / "part-1.parquet", [0.0, 1.0], ay=[1.0, 2.0], vx=[3, 4])
    part(tmp_path / "part-10.parquet", [10.0, 11.0], vx=[5, 6], ay=[None, None])
    part(tmp_path / "empty.parquet", [], ay=[], vx=[])
    part(tmp_path / "slow.parquet", [0.0, 5.0], temperature=[20.0, 21.0])
    reader, chunks, log = read(tmp_path)
    assert [(c.name, c.count) for c in reader.channels] == [("ay", 6), ("vx", 6), ("temperature", 2)]
    table = [c for c in chunks if "ay" in c.columns]
    assert len({c.group for c in table}) == 1
    assert [t / 1e9 for c in table for t in c.time_ns] == [0.0, 1.0, 10.0, 11.0, 20.0, 21.0]
    np.testing.assert_array_equal(
        np.concatenate([c.columns["ay"] for c in table]), [1.0, 2.0, np.nan, np.nan, 5.0, 6.0]
    )
    assert np.concatenate([c.columns["vx"] for c in table]).tolist() == [3.0, 4.0, 5.0, 6.0, 1.0, 2.0]
    assert log.messages == 8
    assert (
        "3 files with the same columns are parts of one table, read in the order of their time" in log.notes
    )
    assert any("1 of 5 files have no rows" in note for note in log.notes)


def test_parts_that_hold_the_same_time_are_an_error(tmp_path: Path) -> None:
    part(tmp_path / "part-0.parquet", [0.0, 10.0], ay=[1.0, 2.0])
    part(tmp_path / "part-1.parquet", [5.0, 15.0], ay=[1.0, 2.0])
    with pytest.raises(
        LogError, match=r"part-0\.parquet and part-1\.parquet have the same columns.*overlap by 5 s"
    ):
        read(tmp_path)


def test_times_of_day_of_parts_run_on_over_midnight(tmp_path: Path) -> None:
    for name, moments in (
        ("part-2", [time(23, 59, 58), time(23, 59, 59)]),
        ("part-10", [time(0, 0, 1), time(0, 0, 2)]),
    ):
        pl.DataFrame({"time": moments, "ay": [1.0, 2.0]}).write_parquet(tmp_path / f"{name}.parquet")
    _, chunks, _ = read(tmp_path)
    stamps = np.concatenate([c.time_ns for c in chunks])
    assert ((stamps - stamps[0]) / 1e9).tolist() == [0.0, 1.0, 3.0, 4.0]


def test_a_part_in_which_a_column_is_text_has_no_values_there(tmp_path: Path) -> None:
    part(tmp_path / "part-0.parquet", [0.0, 1.0], ay=[1.0, 2.0])
    part(tmp_path / "part-1.parquet", [2.0, 3.0], ay=["off", "off"])
    _, chunks, log = read(tmp_path)
    np.testing.assert_array_equal(
        np.concatenate([c.columns["ay"] for c in chunks]), [1.0, 2.0, np.nan, np.nan]
    )
    assert any('"ay" holds no numbers in part-1.parquet' in note for note in log.notes)


def test_numbers_that_are_stored_as_text_are_read(tmp_path: Path) -> None:
    part(
        tmp_path / "log.parquet",
        [0.0, 0.1, 0.2, 0.3, 0.4],
        ay=["1.5", " -2.5e1", None, "oops", "n/a"],
        place=["48.1N"] * 5,
    )
    reader, (chunk,), log = read(tmp_path / "log.parquet")
    assert [(c.name, c.kind) for c in reader.channels] == [("ay", "number"), ("place", "text")]
    np.testing.assert_array_equal(chunk.columns["ay"], [1.5, -25.0, np.nan, np.nan, np.nan])
    assert log.rejected == {"cell with text where a number was expected": 1}
    assert any('hold numbers as text are read as numbers: "ay"' in note for note in log.notes)
