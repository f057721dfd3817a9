"""Times of VBO logs that are no HHMMSS: other programs write seconds of the day or of the drive."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from vbo_files import read, row, utc_ns, vbo

from parsers.vbo_clock import counts_seconds, of_day

CREATED = "File created on 16/03/2024 at 14:05:22"


def _seconds(first: float, count: int = 1800) -> list[str]:
    return [row(f"{first + 0.05 * k:.2f}") for k in range(count)]


def test_seconds_of_the_day(tmp_path: Path) -> None:
    log = read(tmp_path, vbo(_seconds(50722.0), created=CREATED))
    assert len(log.time) == 1800
    assert log.time[0] == utc_ns("2024-03-16T14:05:22")
    assert log.time[-1] - log.time[0] == round(1799 * 0.05e9)
    assert not log.log.rejected
    assert "no HHMMSS (it runs over 50761.00): read as seconds of the day" in log.said


def test_seconds_of_the_drive_have_no_date(tmp_path: Path) -> None:
    log = read(tmp_path, vbo(_seconds(0.05), created=CREATED))
    assert log.time[-1] - log.time[0] == round(1799 * 0.05e9)
    assert not log.reader.absolute
    assert "read as seconds from a zero of the log's own" in log.said


@pytest.mark.parametrize("first", [140522.0, 95930.0, 5930.0, 235930.0])
def test_times_of_day_stay_so(first: float) -> None:
    seconds = of_day(np.array([first]))[0] + 0.05 * np.arange(3600)
    times = seconds // 3600 * 10000 + seconds // 60 % 60 * 100 + seconds % 60
    assert not counts_seconds(times)
    assert counts_seconds(seconds)


def test_a_few_damaged_times_change_nothing() -> None:
    times = 140500.0 + np.arange(60.0)
    times[30:33] = [140577.0, 140588.0, 140599.0]
    assert not counts_seconds(times)


def test_a_log_most_of_whose_rows_are_lost_is_malformed(tmp_path: Path) -> None:
    rows = [row(f"0838{k // 100:02d}.{k % 100:02d}0") + ("" if k % 3 else " 1.0") for k in range(300)]
    log = read(tmp_path, vbo(rows))
    assert log.log.rejected == {"row with too many columns": 100}
    assert log.log.status == "malformed"
    assert "100 of 300 rows could not be read and were left out (100 x row with too many columns)" in log.said
