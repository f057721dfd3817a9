"""A second head among a VBO file's rows: the log ends there where its columns or its day are others, and goes on where they are not."""

from __future__ import annotations

from pathlib import Path

import pytest
from vbo_files import NAMES, TITLES, UNITS, read, row, vbo

SWAPPED = NAMES.replace("lat long velocity", "long velocity lat")
SWAPPED_TITLES = [*TITLES[:2], "longitude", "velocity kmh", "latitude", *TITLES[5:]]
SHORT = NAMES.removesuffix(" Temp")


def _rows(minute: int, count: int) -> list[str]:
    return [row(f"0838{minute + k // 100:02d}.{k % 100:02d}0") for k in range(count)]


def _many(first: int, count: int) -> list[str]:
    """A row every 10 ms from the minute `first` on."""
    times = [(first * 6000 + k) for k in range(count)]
    return [row(f"08{t // 6000:02d}{t // 100 % 60:02d}.{t % 100:02d}0") for t in times]


@pytest.mark.parametrize("before", [40, 90_000])
@pytest.mark.parametrize(
    ("names", "titles", "cells"), [(SWAPPED, SWAPPED_TITLES, 13), (SHORT, TITLES[:-1], 12)]
)
def test_the_log_ends_at_a_head_with_other_columns(
    tmp_path: Path, names: str, titles: list[str], cells: int, before: int
) -> None:
    first = vbo(_many(20, before))
    rows = [" ".join(line.split()[:cells]) for line in _many(40, 30)]
    second = vbo(rows, names=names, titles=titles, units=UNITS[: len(titles) - 10])
    log = read(tmp_path, first + second)
    assert len(log.time) == before
    assert set(log.columns["velocity"].tolist()) == {8.931}
    assert not log.log.rejected
    assert not log.log.lost_spans_ns
    assert log.log.status == "malformed"
    line = first.count(b"\n") + 1
    assert f"a second drive with other columns or units ({' '.join(names.split()[:5])!r}"[:-1] in log.said
    assert f"begins at line {line} of the file" in log.said
    assert "the 30 lines of rows behind its head" in log.said


def test_other_units_end_the_log_too(tmp_path: Path) -> None:
    miles = [title.replace("kmh", "mph") for title in TITLES]
    log = read(tmp_path, vbo(_rows(0, 30)) + vbo(_rows(20, 30), titles=miles))
    assert len(log.time) == 30
    assert log.log.status == "malformed"


@pytest.mark.parametrize("heads", [1, 3])
def test_the_same_columns_go_on(tmp_path: Path, heads: int) -> None:
    data = b"".join(vbo(_rows(10 * k, 30)) for k in range(heads + 1))
    log = read(tmp_path, data)
    assert len(log.time) == 30 * (heads + 1)
    assert log.time[30] - log.time[0] == 10 * 10**9
    assert log.log.status == "complete"
    assert not log.log.rejected
    assert not log.log.lost_spans_ns
    assert f"{heads} further head{'s' if heads > 1 else ''} with the same columns" in log.said


def test_rows_go_on_behind_a_bare_section(tmp_path: Path) -> None:
    log = read(tmp_path, vbo(_rows(0, 30)) + b"[data]\r\n" + "\r\n".join(_rows(10, 30)).encode() + b"\r\n")
    assert len(log.time) == 60
    assert log.log.status == "complete"


def test_a_drive_of_another_day_ends_the_log(tmp_path: Path) -> None:
    other = vbo(_rows(20, 30), created="File created on 14/04/2014 @ 08:38")
    log = read(tmp_path, vbo(_rows(0, 30)) + other)
    assert len(log.time) == 30
    assert log.log.status == "malformed"
    assert "a second drive, of 2014-04-14 08:38, begins" in log.said


def test_a_section_of_another_name_is_no_head(tmp_path: Path) -> None:
    data = vbo(_rows(0, 30)) + b"[AVI]\r\n" + "\r\n".join(_rows(10, 30)).encode() + b"\r\n"
    log = read(tmp_path, data)
    assert len(log.time) == 60
    assert log.log.rejected == {"row with too few columns": 1}
