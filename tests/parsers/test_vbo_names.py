"""Column names and units of VBO files, also where header and names disagree."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest
from vbo_files import NAMES, TITLES, read, row, utc_ns, vbo

from parsers.vbo_header import join_words, name_columns, read_head


def test_a_name_with_a_blank_is_joined_as_in_the_header(tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("083856.300")], names=NAMES.replace("LatAccel", "Lat Accel")))
    assert log.columns["Lat_Accel"].tolist() == [0.01247217]
    assert log.info["Lat_Accel"].unit == "g"
    assert log.columns["Temp"].tolist() == [10.6]
    assert "joined" in log.said


@pytest.mark.parametrize(
    "names",
    [
        NAMES.replace("Yaw_Rate LatAccel", "Yaw_RateLatAccel"),
        NAMES.replace("LatAccel", "Acceleration 2 lateral"),
        "",
    ],
)
def test_names_are_taken_from_the_header_where_words_do_not_agree(names: str, tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("083856.300")], names=names))
    assert log.columns["Yaw_Rate"].tolist() == [-1.0]
    assert log.columns["Lat Accel"].tolist() == [0.01247217]
    assert log.columns["velocity"].tolist() == [8.931]
    assert "[header]" in log.said


def test_nothing_is_mislabelled_where_header_and_names_both_disagree(tmp_path: Path) -> None:
    data = vbo([row("083856.300") + "1.0 2.0"], names=NAMES, titles=TITLES)
    log = read(tmp_path, data)
    assert log.columns["velocity"].tolist() == [8.931]
    assert log.info["lat"].unit == "min"
    assert "Yaw_Rate" not in log.info
    assert "column_15" in log.info
    assert "for certain" in log.said


@pytest.mark.parametrize("units", [["°/s"], ["°/s", "g", "", "°C"], ["°/s", "g", "V", "A", "m"]])
def test_units_that_cannot_be_aligned_are_left_out(units: list[str], tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("083856.300")], units=units))
    assert log.info["Yaw_Rate"].unit is None
    assert log.info["velocity"].unit == "km/h"
    assert "[channel units]" in log.said


def test_knots(tmp_path: Path) -> None:
    titles = [title.replace("velocity kmh", "velocity knots") for title in TITLES]
    assert read(tmp_path, vbo([row("083856.300")], titles=titles)).info["velocity"].unit == "knots"


def test_old_file_without_units(tmp_path: Path) -> None:
    data = (
        b"File created on 15/04/2004 @ 08:21\r\n\r\n[header]\r\nsatellites\r\ntime\r\nlatitude\r\nlongitude\r\nvelocity knots\r\nheading\r\n"
        b"height\r\nVertical velocity m/s\r\n\r\n[channel units]\r\n\r\n[comments]\r\nVBoxII\r\n\r\n[column names]\r\n"
        b"sats time lat long velocity heading height vert-vel\r\n\r\n[data]\r\n"
        b"004 072148.26 +3119.408424 +00062.635139 015.13 356.06 +00155.27 -00000.22\r\n"
        b"004 072148.27 +3119.408592 +00062.635104 015.17 356.02 +00147.93 -00000.37\r\n"
    )
    log = read(tmp_path, data)
    assert log.columns["velocity"].tolist() == [15.13, 15.17]
    assert log.info["velocity"].unit == "knots"
    assert log.info["vert-vel"].unit == "m/s"
    assert log.time.tolist() == [utc_ns("2004-04-15T07:21:48.260"), utc_ns("2004-04-15T07:21:48.270")]


def test_repeated_names(tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("083856.300")], names=NAMES.replace("LatAccel", "Yaw_Rate")))
    assert log.columns["Yaw_Rate"].tolist() == [-1.0]
    assert log.columns["Yaw_Rate_2"].tolist() == [0.01247217]
    assert "repeated" in log.said


def test_words_join_only_where_all_agree() -> None:
    assert join_words(["sats", "time", "Slip", "Angle"], ["satellites", "time", "Slip Angle"]) == [
        "sats",
        "time",
        "Slip_Angle",
    ]
    assert join_words(["sats", "time", "Slip", "Angle", "more"], ["satellites", "time", "Slip Angle"]) is None
    assert join_words(["sats", "time", "Angle"], ["satellites", "time", "Slip Angle"]) is None


def test_head_sections() -> None:
    head = read_head(vbo([row("083856.300")]).decode("latin-1").split("[data]")[0])
    assert head.titles == tuple(TITLES)
    assert head.created == datetime(2014, 4, 11, 9, 42, tzinfo=UTC)
    columns, notes = name_columns(head, len(TITLES))
    assert [column.name for column in columns] == NAMES.split()
    assert not notes
