"""A clock that does not go with speed and acceleration, and counters of a stated step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.checks.clock import clock_over_speed
from parsers.errors import MappingError
from parsers.load import LoadOptions, load_drive
from parsers.mapping.map_file import read_map
from parsers.units import find_unit


def rows(seconds_a_row: float, count: int = 6000) -> tuple[np.ndarray, np.ndarray]:
    """Speed and acceleration of a drive with stops, with noise and an offset."""
    rng = np.random.default_rng(3)
    t = np.arange(count) * seconds_a_row
    speed = 10 + 8 * np.sin(2 * np.pi * t / 37) * np.sin(2 * np.pi * t / 11)
    accel = np.gradient(speed, seconds_a_row) + 0.2 + 0.1 * rng.standard_normal(count)
    return speed, accel


def write(path: Path, seconds_a_row: float) -> Path:
    speed, accel = rows(seconds_a_row)
    lines = (f"{k},{v:.4f},{a:.4f}\n" for k, (v, a) in enumerate(zip(speed, accel, strict=True)))
    path.write_text("Time,Speed [m/s],AccX [m/s2]\n" + "".join(lines))
    return path


@pytest.mark.parametrize("seconds", [0.01, 0.02, 0.05])
def test_a_row_number_read_as_seconds_is_found_by_the_speed(seconds: float, tmp_path: Path) -> None:
    drive = load_drive([write(tmp_path / "drive.csv", seconds)])
    assert clock_over_speed(drive.signals) == pytest.approx(seconds, rel=0.05)
    assert any("as if a second of the log were" in note for note in drive.record.notes)


def test_a_counter_with_a_stated_step_is_a_clock(tmp_path: Path) -> None:
    log, table = write(tmp_path / "drive.csv", 0.02), tmp_path / "map.toml"
    table.write_text('[time]\nchannel = "Time"\nunit = "20 ms"\n')
    drive = load_drive([log], LoadOptions(map=read_map(table)))
    assert drive.record.duration_s == pytest.approx(5999 * 0.02)
    assert clock_over_speed(drive.signals) == pytest.approx(1.0, rel=0.05)
    assert not any("as if a second" in note for note in drive.record.notes)
    table.write_text('[time]\nchannel = "Time"\nunit = "20 apples"\n')
    with pytest.raises(MappingError, match="20 apples"):
        read_map(table)


@pytest.mark.parametrize(
    ("text", "scale"), [("10 ms", 0.01), ("0.5 s", 0.5), ("[100 us]", 1e-4), ("2min", 120.0)]
)
def test_steps_of_counters_are_units_of_time(text: str, scale: float) -> None:
    unit = find_unit(text, "time")
    assert unit is not None
    assert unit.scale == pytest.approx(scale)


@pytest.mark.parametrize("text", ["0 s", "10", "1e3 s", "10 m/s", "-1 s", "10 10 s"])
def test_what_is_no_step_is_no_unit(text: str) -> None:
    assert find_unit(text, "time") is None


def test_a_drive_that_hardly_changes_its_speed_says_nothing(tmp_path: Path) -> None:
    log = tmp_path / "drive.csv"
    log.write_text(
        "time_s,speed_mps,accel_x_mps2\n" + "".join(f"{k / 10},20.0,{0.01 * (k % 5)}\n" for k in range(900))
    )
    assert clock_over_speed(load_drive([log]).signals) is None
