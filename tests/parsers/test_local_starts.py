"""Logs whose clock names no time zone: their start is kept as local time, and nothing calls it UTC."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import polars as pl
import pytest

from parsers.importer import TAKEN_AS_UTC
from parsers.load import LoadOptions, load_drive
from parsers.mapping import read_map

LOCAL = datetime(2024, 5, 1, 10, 0, 0, 250_000)
ROWS = [(LOCAL + timedelta(milliseconds=20 * k), 10.0 + 0.01 * k) for k in range(200)]


def table(path: Path, zone: str = "") -> Path:
    rows = "".join(f"{moment.isoformat(timespec='milliseconds')}{zone},{speed}\n" for moment, speed in ROWS)
    path.write_text(f"timestamp,speed_mps\n{rows}")
    return path


def candump(samples: Path, path: Path) -> Path:
    """The sample's console log as `candump -t A` prints it."""
    first = 1_760_000_000.0

    def dated(match: re.Match[str]) -> str:
        moment = LOCAL + timedelta(seconds=float(match[1]) - first)
        return f"({moment:%Y-%m-%d %H:%M:%S.%f})"

    path.write_text(re.sub(r"\((\d+\.\d+)\)", dated, (samples / "can" / "console.txt").read_text()))
    return path


def parquet(path: Path, zone: str | None = None) -> Path:
    moments = pl.Series("timestamp", [moment for moment, _ in ROWS], pl.Datetime("ns")).dt.replace_time_zone(
        zone
    )
    pl.DataFrame({"timestamp": moments, "speed_mps": [speed for _, speed in ROWS]}).write_parquet(path)
    return path


def record_of(path: Path, samples: Path, *, can: bool = False):
    dbc = (samples / "can" / "chassis.dbc",) if can else ()
    mapping = read_map(samples / "can" / "map.toml", strict=False) if can else None
    return load_drive([path], LoadOptions(dbc=dbc, map=mapping)).record


@pytest.mark.parametrize("kind", ["asc", "trc", "candump", "blf", "csv", "parquet"])
def test_a_start_of_unknown_zone_is_local_time(kind: str, samples: Path, tmp_path: Path) -> None:
    if kind in ("asc", "trc", "blf"):
        record = record_of(samples / "can" / f"drive.{kind}", samples, can=True)
    elif kind == "candump":
        record = record_of(candump(samples, tmp_path / "console.txt"), samples, can=True)
    else:
        record = record_of(
            table(tmp_path / "a.csv") if kind == "csv" else parquet(tmp_path / "a.parquet"), samples
        )
    assert record.start_utc is not None
    start = datetime.fromisoformat(record.start_utc)
    assert start.tzinfo is None
    if kind in ("candump", "csv", "parquet"):
        assert abs(start - LOCAL) < timedelta(seconds=1)
    assert sum(TAKEN_AS_UTC in note for note in record.notes) == 1
    assert "UTC" not in record.clock or "taken as UTC" in record.clock


def test_a_start_with_its_zone_is_utc(samples: Path, tmp_path: Path) -> None:
    for record in (
        record_of(table(tmp_path / "a.csv", "+02:00"), samples),
        record_of(parquet(tmp_path / "a.parquet", "Europe/Berlin"), samples),
    ):
        assert record.start_utc == "2024-05-01T08:00:00.250+00:00"
        assert not any(TAKEN_AS_UTC in note for note in record.notes)
    whole = record_of(samples / "can" / "drive.log", samples, can=True)
    assert datetime.fromisoformat(whole.start_utc or "").tzinfo == UTC
