"""Parquet tables with counters that wrap, infinite values, decimals too wide and columns without values: read as the same table in CSV is."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import numpy as np
import polars as pl
import pyarrow as arrow
import pytest
from pyarrow import parquet

from parsers.load import load_drive

ROWS = 3000
INFINITE = np.arange(ROWS) % 7 == 0


def table(time: pl.Series, **columns: pl.Series) -> pl.DataFrame:
    at = np.arange(ROWS)
    speed = pl.Series("speed_mps", 15 + 3 * np.sin(at / 200))
    lateral = pl.Series("accel_y_mps2", np.sin(at / 90))
    return pl.DataFrame([time, columns.get("speed_mps", speed), lateral])


@pytest.mark.parametrize("before_end", [20_000, 2004, 700])
@pytest.mark.parametrize("kind", [pl.UInt32, pl.Float64])
def test_a_counter_runs_on_over_its_end(tmp_path: Path, before_end: int, kind: type[pl.DataType]) -> None:
    """uint32 of ms, as CSV has it; over the boundaries of chunks as well."""
    counted = (2**32 - before_end + 10 * np.arange(ROWS)) % 2**32
    frame = table(pl.Series("time_ms", counted).cast(kind))
    frame.write_parquet(tmp_path / "log.parquet")
    frame.write_csv(tmp_path / "log.csv")
    drives = [load_drive((tmp_path / f"log.{suffix}",)) for suffix in ("parquet", "csv")]
    for drive in drives:
        assert len(drive.signals["speed"].values) == ROWS
        assert not drive.record.rejected
        assert any("it runs on" in note for note in drive.record.notes)
    assert np.array_equal(drives[0].signals["speed"].time_ns, drives[1].signals["speed"].time_ns)


@pytest.mark.parametrize("as_text", [False, True])
def test_infinite_values_are_counted(tmp_path: Path, as_text: bool) -> None:
    speed = pl.Series("speed_mps", np.where(INFINITE, np.inf, 15.0))
    frame = table(pl.Series("time_s", np.arange(ROWS) / 100), speed_mps=speed)
    if as_text:
        frame = frame.with_columns(pl.col("speed_mps").cast(pl.String))
    frame.write_parquet(tmp_path / "log.parquet")
    drive = load_drive((tmp_path / "log.parquet",))
    assert dict(drive.record.rejected) == {"cell with an infinite value": int(INFINITE.sum())}
    assert len(drive.signals["speed"].values) == ROWS - int(INFINITE.sum())


def test_a_column_without_values_is_said_to_hold_none(tmp_path: Path) -> None:
    nothing = pl.Series("speed_mps", [None] * ROWS, dtype=pl.Null)
    table(pl.Series("time_s", np.arange(ROWS) / 100), speed_mps=nothing).write_parquet(
        tmp_path / "log.parquet"
    )
    notes = " ".join(load_drive((tmp_path / "log.parquet",)).record.notes)
    assert "left out, since the column holds no values: speed_mps (speed)" in notes
    assert "holds text" not in notes


def test_decimals_beyond_polars_cost_their_column_alone(tmp_path: Path) -> None:
    frame = table(pl.Series("time_s", np.arange(ROWS) / 100))
    columns = {name: frame[name].to_numpy() for name in frame.columns}
    columns["speed_mps"] = arrow.array([Decimal("15.25")] * ROWS, arrow.decimal256(50, 3))
    parquet.write_table(arrow.table(columns), tmp_path / "log.parquet")
    drive = load_drive((tmp_path / "log.parquet",))
    assert [*drive.signals] == ["accel_y"]
    assert len(drive.signals["accel_y"].values) == ROWS
    assert any('more than 38 digits are not read: "speed_mps"' in note for note in drive.record.notes)


@pytest.mark.parametrize("kind", ["categorical", "enum", "large dictionary"])
def test_numbers_held_as_categories_of_text_are_read(tmp_path: Path, kind: str) -> None:
    """pandas writes a column of few different texts as category; words among them are counted as in a column of text."""
    words = [f"{15 + k % 9}.5" if k % 10 else " n/a " if k % 20 else "open" for k in range(ROWS)]
    speed = pl.Series("speed_mps", words)
    frame = table(pl.Series("time_s", np.arange(ROWS) / 100), speed_mps=speed)
    plain, path = tmp_path / "plain.parquet", tmp_path / "log.parquet"
    frame.write_parquet(plain)
    if kind == "large dictionary":
        whole = frame.to_arrow()
        coded = whole["speed_mps"].cast(arrow.large_string()).dictionary_encode()
        parquet.write_table(whole.set_column(1, "speed_mps", coded), path)
    else:
        of = pl.Categorical() if kind == "categorical" else pl.Enum(sorted(set(words)))
        frame.with_columns(pl.col("speed_mps").cast(of)).write_parquet(path)
    expected, found = load_drive((plain,)), load_drive((path,))
    assert np.array_equal(found.signals["speed"].values, expected.signals["speed"].values)
    assert len(found.signals["speed"].values) == ROWS - ROWS // 10
    assert found.record.rejected == expected.record.rejected
    assert any("numbers as text" in note for note in found.record.notes)


@pytest.mark.parametrize(
    ("zone", "between", "hours"), [("Z", "T", 0), ("", " ", 0), ("+02:00", "T", -2), (" UTC", " ", 0), ("-0530", " ", 5.5), (" +01", "t", -1)]
)  # fmt: skip
@pytest.mark.parametrize("category", [False, True])
def test_times_as_texts_of_iso_8601(
    tmp_path: Path, zone: str, between: str, hours: float, category: bool
) -> None:
    """Fractions as long as they have to be, as Python writes them; a text that is no time costs its row."""
    at = np.arange(ROWS)
    texts = [
        f"2025-03-04{between}10:{20 + k // 6000}:{k // 100 % 60:02d}{f'.{k % 100:02d}' if k % 100 else ''}{zone}"
        for k in at
    ]
    texts[7], texts[1700], texts[1701] = "none", "9999-01-01 00:00:00", "2025-02-30T00:00:00"
    time = pl.Series("time", texts)
    table(time.cast(pl.Categorical()) if category else time).write_parquet(tmp_path / "log.parquet")
    drive = load_drive((tmp_path / "log.parquet",))
    speed = drive.signals["speed"]
    begin = 1_741_083_600 + round(3600 * hours)
    assert np.array_equal(speed.time_ns, (begin * 100 + np.delete(at, [7, 1700, 1701])) * 10**7)
    assert drive.record.rejected["row without a valid time"] == 3
    assert any("zone" in note for note in drive.record.notes) == (not zone)
