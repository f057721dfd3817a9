"""A second header among a CSV's rows: the table ends there where its columns are others, and goes on where they are the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.drive import Drive
from parsers.load import load_drive
from parsers.opened_log import LoadOptions
from parsers.table_headers import other_header
from parsers.table_rows import RowRules

RULES = RowRules(ord(","), 4, 4)
HEADER = ("time_s", "accel_x_mps2", "accel_y_mps2", "speed_mps")


def _rows(begin: float, count: int, order: tuple[int, ...] = (0, 1, 2, 3)) -> str:
    lines = []
    for k in range(count):
        t = begin + 0.01 * k
        cells = (
            f"{t:.2f}",
            f"{0.1 + 0.001 * (k % 7):.4f}",
            f"{2 + 0.01 * (k % 11):.3f}",
            f"{10 + 0.01 * k:.2f}",
        )
        lines.append(",".join(cells[i] for i in order))
    return "\n".join(lines) + "\n"


def _load(tmp_path: Path, text: str) -> Drive:
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    return load_drive([path], LoadOptions(fix=False))


@pytest.mark.parametrize(
    "second",
    [
        ("time_s", "accel_y_mps2", "accel_x_mps2", "speed_mps"),
        ("time_s", "accel_x_g", "accel_y_g", "speed_kmh"),
        ("speed_mps", "accel_y_mps2", "accel_x_mps2", "time_s"),
        ("time_s", "roll_rate_radps", "accel_y_mps2", "speed_mps", "yaw_rate_radps"),
    ],
)
@pytest.mark.parametrize("before", [40, 4000])
def test_the_table_ends_at_other_columns(tmp_path: Path, second: tuple[str, ...], before: int) -> None:
    whole = _load(tmp_path, ",".join(HEADER) + "\n" + _rows(0, before))
    joined = (
        ",".join(HEADER)
        + "\n"
        + _rows(0, before)
        + ",".join(second)
        + "\n"
        + _rows(0.01 * before, before, (0, 2, 1, 3))
    )
    found = _load(tmp_path, joined)
    assert found.record.status == "malformed"
    assert any("second header with other columns" in note for note in found.record.notes)
    for name, signal in whole.signals.items():
        np.testing.assert_array_equal(found.signals[name].values, signal.values)
    assert found.record.duration_s == pytest.approx(whole.record.duration_s)


def test_the_same_header_again_is_harmless(tmp_path: Path) -> None:
    text = ",".join(HEADER) + "\n" + _rows(0, 300) + ",".join(HEADER) + "\n" + _rows(3, 300)
    found = _load(tmp_path, text)
    assert found.record.status == "complete"
    assert len(found.signals["speed"].values) == 600


@pytest.mark.parametrize(
    "line",
    [
        "Lap 2",
        "marker,left,turn",
        "nan,nan,nan,nan",
        "error,error,error,error",
        "OFF,ON,ok,12",
        ",".join(HEADER),
        "12.5,x,3,4",
        "",
    ],
)
def test_markers_and_missing_values_are_no_header(line: str) -> None:
    assert other_header(line, RULES, HEADER) is None


@pytest.mark.parametrize(
    "line",
    ["time_s,accel_y_mps2,accel_x_mps2,speed_mps", '"t","ax","ay","v"', "speed_mps, time_s ,accel_x_mps2"],
)
def test_other_names_are(line: str) -> None:
    assert other_header(line, RULES, HEADER) is not None


def test_it_is_found_in_any_part_of_a_large_file(tmp_path: Path) -> None:
    before = 60_000
    joined = (
        ",".join(HEADER)
        + "\n"
        + _rows(0, before)
        + "time_s,accel_y_mps2,accel_x_mps2,speed_mps\n"
        + _rows(600, 20_000)
    )
    found = _load(tmp_path, joined)
    assert found.record.status == "malformed"
    assert len(found.signals["speed"].values) == before
