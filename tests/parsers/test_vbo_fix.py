"""VBO rows without a position fix: the unit writes zeros, or what it knew last."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from vbo_files import Read, read, row, vbo

from parsers.importer import ImportLog, ReadOptions
from parsers.vbo_log import VboImporter

LOST = "speed and place of a row without a position fix"
PLACE = "+3608.22250787 -01086.93269549 008.931"


def at(tenth: int, sats: str = "009", place: str = PLACE) -> str:
    return row(f"083856.{tenth}00", sats=sats).replace(PLACE, place)


def emptied(log: Read) -> list[int]:
    """Rows whose speed, place, heading and height are gone, and nothing else is."""
    gone = np.isnan(log.columns["velocity"])
    for name in ("lat", "long", "heading", "height", "vert-vel"):
        assert np.array_equal(np.isnan(log.columns[name]), gone), name
    assert np.isfinite(log.columns["Yaw_Rate"]).all()
    return np.flatnonzero(gone).tolist()


def test_zeros_are_no_place_and_no_speed(tmp_path: Path) -> None:
    none = "+0000.00000000 +00000.00000000 000.000"
    log = read(tmp_path, vbo([at(1), at(2, "000", none), at(3, "003", none), at(4)]))
    assert emptied(log) == [1, 2]
    assert log.log.rejected == {LOST: 2}
    assert log.columns["sats"].tolist() == [9, 0, 3, 9]


@pytest.mark.parametrize("sats", ["000", "064", "128"])
def test_a_speed_that_goes_on_at_one_place_without_satellites_is_none(tmp_path: Path, sats: str) -> None:
    log = read(tmp_path, vbo([at(1), at(2), at(3, sats), at(4, sats), at(5)]))
    assert emptied(log) == [2, 3]


def test_an_inertial_unit_carries_speed_and_place_through_a_tunnel(tmp_path: Path) -> None:
    places = [f"+3608.2225{k}787 -01086.93269549 008.93{k}" for k in range(5)]
    log = read(tmp_path, vbo([at(k + 1, "000", place) for k, place in enumerate(places)]))
    assert emptied(log) == []
    assert not log.log.rejected


def test_the_equator_is_a_place_and_one_at_rest_without_satellites_stays(tmp_path: Path) -> None:
    there = "+0000.00000000 -01086.93269549 008.931"
    rest = PLACE.replace("008.931", "000.000")
    log = read(tmp_path, vbo([at(1, place=there), at(2, "000", rest), at(3, "000", rest)]))
    assert emptied(log) == []


def test_a_speed_alone_is_told_by_columns_that_nobody_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "log.vbo"
    path.write_bytes(vbo([at(1), at(2, "000", "+0000.00000000 +00000.00000000 008.931")]))
    (chunk,) = VboImporter().open(path, ReadOptions(), ImportLog()).read(frozenset({"velocity", "Temp"}))
    assert list(chunk.columns) == ["velocity", "Temp"]
    assert np.isnan(chunk.columns["velocity"]).tolist() == [False, True]
    assert np.isfinite(chunk.columns["Temp"]).all()
