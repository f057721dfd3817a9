"""A time that is hardly the log's is said: another unit, or another channel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.errors import LogError
from parsers.load import load_drive
from parsers.mapping.map_file import read_map
from parsers.opened_log import LoadOptions


def _log(tmp_path: Path, time: np.ndarray) -> Path:
    rng = np.random.default_rng(1)
    rows = np.column_stack([time, 10 + 5 * np.sin(np.arange(len(time)) / 50), rng.standard_normal(len(time))])
    path = tmp_path / "log.csv"
    np.savetxt(path, rows, delimiter=",", header="time_s,speed_mps,accel_y_mps2", comments="", fmt="%.4f")
    return path


def _notes(path: Path, text: str) -> str:
    place = path.with_name("map.toml")
    place.write_text(text)
    return " ".join(load_drive([path], LoadOptions(map=read_map(place))).record.notes)


def test_seconds_taken_for_milliseconds_are_said(tmp_path: Path) -> None:
    path = _log(tmp_path, np.arange(2000) / 100)
    assert "is the unit of the time right?" in _notes(path, '[time]\nchannel = "time_s"\nunit = "ms"\n')
    assert "time right?" not in _notes(path, '[time]\nchannel = "time_s"\nunit = "s"\n')


def test_a_channel_that_goes_back_and_forth_is_hardly_the_time(tmp_path: Path) -> None:
    path = _log(tmp_path, np.arange(2000) / 100)
    assert "is that channel the time?" in _notes(path, '[time]\nchannel = "speed_mps"\nunit = "s"\n')
    assert "is that channel" not in _notes(path, '[time]\nchannel = "time_s"\n')


def test_rows_that_come_quicker_than_any_recorder_are_said(tmp_path: Path) -> None:
    # minutes that are taken for seconds
    path = _log(tmp_path, np.arange(6000) / 2500)
    assert "are 2500 Hz: is the unit of the time right?" in _notes(
        path, '[time]\nchannel = "time_s"\nunit = "s"\n'
    )
    assert "time right?" not in _notes(path, '[time]\nchannel = "time_s"\nunit = "min"\n')


def test_rows_that_come_too_seldom_for_any_motion_are_said(tmp_path: Path) -> None:
    """A blind checker's: a column `time_s` that holds milliseconds, 20 a row, made a day and a half of two minutes."""
    path = _log(tmp_path, np.arange(6000) * 20.0)
    assert "a row every 20 s: too seldom for a vehicle's motion; is the unit of the time right?" in _notes(
        path, '[time]\nchannel = "time_s"\nunit = "s"\n'
    )
    assert "time right?" not in _notes(path, '[time]\nchannel = "time_s"\nunit = "ms"\n')


def test_two_drives_that_begin_at_zero_are_no_doubt_about_the_unit(tmp_path: Path) -> None:
    """A blind checker's: the jump was known, and twice the rows within one drive's time were a rate no recorder has."""
    drive = np.arange(12_000) / 1200
    said = _notes(_log(tmp_path, np.concatenate([drive, drive])), "")
    assert "the clock is set or starts again within the log" in said
    assert "time right?" not in said
    # each of the two at a rate that no recorder has
    quick = _notes(_log(tmp_path, np.concatenate([drive, drive]) / 2), "")
    assert "12000 rows within 5 s are 2400 Hz: is the unit of the time right?" in quick


def test_one_long_pause_is_no_doubt_about_the_unit(tmp_path: Path) -> None:
    """A lunch of five hours within half a minute of driving at 40 Hz: 9 s a row in the mean."""
    half = np.arange(900) / 40
    said = _notes(
        _log(tmp_path, np.concatenate([half, half + 18_000])), '[time]\nchannel = "time_s"\nunit = "s"\n'
    )
    assert "time right?" not in said


def test_a_time_that_stands_still_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r'column "time_s" stands still at .5\.0000.: no time'):
        load_drive([_log(tmp_path, np.full(2000, 5.0))], LoadOptions())
