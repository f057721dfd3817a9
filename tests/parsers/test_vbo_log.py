"""Racelogic VBO: files built by hand, every trap of the format, and two recorded logs."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from parsers.channels import ChannelInfo, FloatArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.vbo_header import join_words, name_columns, read_head
from parsers.vbo_log import VboImporter

TITLES = [
    "satellites",
    "time",
    "latitude",
    "longitude",
    "velocity kmh",
    "heading",
    "height",
    "vertical velocity kmh",
    "Event 1 time",
    "latitude_raw",
    "Yaw_Rate",
    "Lat Accel",
    "Temp",
]
NAMES = "sats time lat long velocity heading height vert-vel event-1 _lat Yaw_Rate LatAccel Temp"
UNITS = ["°/s", "g", ""]


def row(time: str, yaw: str = "-1.000000E+00", sats: str = "009") -> str:
    return f"{sats} {time} +3608.22250787 -01086.93269549 008.931 231.91 +0036.11 -0000.06 0.000000 +3608.2 {yaw} +1.247217E-02 +1.060000E+01 "


def vbo(
    rows: list[str],
    *,
    names: str = NAMES,
    titles: list[str] = TITLES,
    units: list[str] = UNITS,
    created: str = "File created on 11/04/2014 @ 09:42     ",
    end: str = "\r\n",
) -> bytes:
    lines = [
        created,
        "",
        "[header]",
        *titles,
        "",
        "[channel units]",
        *units,
        "",
        "[comments]",
        "Log Rate (Hz) : 100.00",
        "",
        "[laptiming]",
        "Start +5773.4 +1832.2 +5773.4 +1832.2",
        "",
        "[column names]",
        f"{names} ",
        "",
        "[data]",
        *rows,
    ]
    return ("\r\n".join(lines) + end).encode("latin-1")


class Read:
    """A log read whole."""

    def __init__(self, path: Path) -> None:
        self.log = ImportLog()
        assert VboImporter().claims(path, path.read_bytes()[:4096])
        self.reader = VboImporter().open(path, ReadOptions(), self.log)
        self.info: dict[str, ChannelInfo] = {channel.name: channel for channel in self.reader.channels}
        chunks = list(self.reader.read(frozenset(self.info)))
        self.time: IntArray = np.concatenate([chunk.time_ns for chunk in chunks])
        self.columns: dict[str, FloatArray] = {
            name: np.concatenate([chunk.columns[name] for chunk in chunks]) for name in self.info
        }

    @property
    def said(self) -> str:
        return "\n".join(self.log.notes)


def read(tmp_path: Path, data: bytes) -> Read:
    path = tmp_path / "log.vbo"
    path.write_bytes(data)
    return Read(path)


def utc_ns(text: str) -> int:
    moment = datetime.fromisoformat(text).replace(tzinfo=UTC)
    return int(moment.timestamp()) * 10**9 + moment.microsecond * 1000


def test_known_answers(tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("083856.300"), row("083856.310", "+2.5E+01")]))
    assert list(log.info) == [name for name in NAMES.split() if name != "time"]
    assert log.time.tolist() == [utc_ns("2014-04-11T08:38:56.300"), utc_ns("2014-04-11T08:38:56.310")]
    assert log.reader.absolute
    assert log.reader.start_utc_ns is None
    assert log.columns["lat"].tolist() == [3608.22250787] * 2
    assert log.columns["long"].tolist() == [-1086.93269549] * 2
    assert log.columns["Yaw_Rate"].tolist() == [-1.0, 25.0]
    assert log.columns["LatAccel"].tolist() == [0.01247217] * 2
    units = {name: channel.unit for name, channel in log.info.items()}
    assert units == {
        "sats": None,
        "lat": "min",
        "long": "min",
        "velocity": "km/h",
        "heading": "deg",
        "height": "m",
        "vert-vel": "km/h",
        "event-1": "s",
        "_lat": "min",
        "Yaw_Rate": "°/s",
        "LatAccel": "g",
        "Temp": None,
    }
    assert log.info["long"].tags["positive"] == "west"
    assert log.info["Yaw_Rate"].tags["column"] == "Yaw_Rate"
    assert {channel.family for channel in log.info.values()} == {"vbo"}
    assert log.log.status == "complete"
    assert not log.log.rejected
    assert "2014-04-11" in log.said
    assert "local" in log.said


def test_only_wanted_columns(tmp_path: Path) -> None:
    path = tmp_path / "log.vbo"
    path.write_bytes(vbo([row("083856.300")]))
    (chunk,) = (
        VboImporter().open(path, ReadOptions(), ImportLog()).read(frozenset({"velocity", "time", "no such"}))
    )
    assert list(chunk.columns) == ["velocity"]


def test_satellite_flags_are_taken_out(tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("083856.300", sats=s) for s in ("009", "073", "137", "201")]))
    assert log.columns["sats"].tolist() == [9, 9, 9, 9]
    assert "flags" in log.said


def test_midnight(tmp_path: Path) -> None:
    created = "File created on 31/12/2014 @ 23:59"
    log = read(tmp_path, vbo([row("235959.990"), row("000000.000"), row("000000.010")], created=created))
    assert log.time.tolist() == [
        utc_ns("2014-12-31T23:59:59.990"),
        utc_ns("2015-01-01"),
        utc_ns("2015-01-01T00:00:00.010"),
    ]
    assert "midnight" in log.said


@pytest.mark.parametrize(
    ("created", "expected"),
    [
        ("File created on 12/04/2014 at 00:03:10", "2014-04-11T23:50:00"),
        ("File created on 11/04/2014 23:50:10", "2014-04-11T23:50:00"),
        ("File created on 04/23/2014 @ 23:51", "2014-04-23T23:50:00"),
    ],
)
def test_dates(created: str, expected: str, tmp_path: Path) -> None:
    assert read(tmp_path, vbo([row("235000.00")], created=created)).time.tolist() == [utc_ns(expected)]


def test_no_date(tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("000001.50")], created=""))
    assert log.time.tolist() == [1_500_000_000]
    assert not log.reader.absolute
    assert "unknown day" in log.said


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


def test_damaged_rows(tmp_path: Path) -> None:
    rows = [
        row("083856.300"),
        "009 083856.310 +36",
        row("996099.000"),
        row("083856.320") + "7 8",
        row("083856.330"),
        "\0" * 200,
        row("083856.340"),
    ]
    log = read(tmp_path, vbo([*[row(f"08385{k}.000") for k in range(5)], *rows]))
    assert len(log.time) == 8
    assert log.log.rejected == {
        "row with too few columns": 1,
        "row with too many columns": 1,
        "row without a valid time": 1,
        "row with bytes that are no text": 1,
    }
    assert log.log.status == "malformed"


@pytest.mark.parametrize("cut", [3, 40, 132])
def test_a_cut_row_is_no_row(cut: int, tmp_path: Path) -> None:
    whole = vbo([row(f"0838{k:02d}.000") for k in range(10)])
    log = read(tmp_path, whole[:-cut])
    assert len(log.time) == 9
    assert log.log.status == "truncated"
    assert sum(log.log.rejected.values()) == 1
    assert "9 rows" in log.said


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "empty"),
        (vbo([]), "no rows"),
        (vbo([row("083856.300")])[:400], r"no \[data\]"),
        (vbo([row("083856.300")], names=NAMES.replace("time", "zeit")), "no column called time"),
    ],
)
def test_errors(data: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "log.vbo"
    path.write_bytes(data)
    with pytest.raises(LogError, match=message) as caught:
        VboImporter().open(path, ReadOptions(), ImportLog())
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_claims(tmp_path: Path) -> None:
    path = tmp_path / "log.bin"
    assert VboImporter().claims(path, vbo([row("083856.300")])[:4096])
    assert VboImporter().claims(path, b"[header]\nsatellites\ntime\n\n[column names]\nsats time\n")
    assert not VboImporter().claims(path, b"t,a\n0,1\n")
    assert not VboImporter().claims(path, b"[header]\n\0\0\0\0[data]")
    assert not VboImporter().claims(path, b"")


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


@pytest.mark.parametrize(
    ("name", "rows", "gap_s"), [("slalom_35kph", 3317, 2.04), ("standstill", 3280, 2.39)]
)
def test_recorded_logs(name: str, rows: int, gap_s: float, real_logs: Path) -> None:
    path = real_logs / f"volvo_v40_{name}.vbo"
    log = Read(path)
    body = path.read_bytes().split(b"[data]\r\n")[1].decode("latin-1")
    peer = np.array([[float(cell) for cell in line.split()] for line in body.splitlines()])
    assert peer.shape == (rows, 41)
    np.testing.assert_array_equal(np.column_stack(list(log.columns.values())), np.delete(peer, 1, axis=1))
    assert np.diff(log.time).max() == round(gap_s * 1e9)
    assert log.log.status == "complete"
    assert not log.log.rejected
    # the columns are what they are called: gravity is in z, the car stays on its wheels and in Sweden
    assert np.allclose(np.median(log.columns["Z_Accel"]), 1.0, atol=0.01)
    assert np.abs(log.columns["Y_Accel"]).max() < 1
    assert np.abs(log.columns["RollRate"]).max() < 10
    assert np.abs(log.columns["Roll_Angle"]).max() < 10
    assert 60 < log.columns["lat"].mean() / 60 < 61
    assert -19 < log.columns["long"].mean() / 60 < -18
    units = [
        log.info[name].unit
        for name in (
            "YawRate",
            "X_Accel",
            "Z_Accel",
            "RollRate",
            "Lng._Vel.",
            "Temp",
            "SteerAng",
            "RMS_HPOS",
            "velocity",
        )
    ]
    assert units == ["°/s", "g", "g", "°/s", "km/h", "°C", "deg", None, "km/h"]


def test_what_damage_takes_in_time_is_written_down(tmp_path: Path) -> None:
    rows = [row(f"0838{k // 10:02d}.{k % 10}00") for k in range(300)]
    rows[20] = rows[20][:30]
    rows[100:150] = ["\0" * 50] * 50
    log = read(tmp_path, vbo(rows))
    start = utc_ns("2014-04-11T08:38:00")
    assert log.log.lost_spans_ns == [(start + 9_900_000_000, start + 15_000_000_000)]
    assert log.log.rejected == {"row with too few columns": 1, "row with bytes that are no text": 50}


def test_a_damaged_last_row_leaves_the_row_before_it(tmp_path: Path) -> None:
    rows = [row(f"0838{k:02d}.000") for k in range(10)]
    log = read(tmp_path, vbo([*rows, row("083810.000") + "7 8"], end=""))
    assert len(log.time) == 10
    assert log.log.rejected == {"row with too many columns": 1}
    assert log.log.status == "truncated"


def test_a_satellite_count_beyond_all_numbers_is_no_crash(tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("083856.300", sats=s) for s in ("073", "1e400", "009", "ERR")]))
    np.testing.assert_array_equal(log.columns["sats"], [9, np.inf, 9, np.nan])


def test_every_row_runs_on_over_the_seams_of_ranges(tmp_path: Path) -> None:
    moments = [86400 - 30000 + k for k in range(70000)]
    rows = [row(f"{m // 3600 % 24:02}{m // 60 % 60:02}{m % 60:02}.00", yaw=f"{m}.5") for m in moments]
    data = vbo(rows)
    assert len(data) > 8 * 1024 * 1024
    log = read(tmp_path, data)
    assert set(np.diff(log.time).tolist()) == {10**9}
    assert log.columns["Yaw_Rate"].tolist() == [m + 0.5 for m in moments]
    assert not log.log.lost_spans_ns


def test_a_head_of_any_length_is_read(tmp_path: Path) -> None:
    data = vbo([row("083856.300")])
    for size in (65_000, 65_536 - data.index(b"[data]") - 3, 300_000):
        log = read(tmp_path, data.replace(b"[comments]", b"[comments]\r\n" + b"x" * size))
        assert log.columns["velocity"].tolist() == [8.931]


def test_a_log_of_nothing_but_time(tmp_path: Path) -> None:
    path = tmp_path / "log.vbo"
    path.write_bytes(
        b"[header]\r\ntime\r\n\r\n[column names]\r\ntime\r\n\r\n[data]\r\n000001.00\r\n000002.00\r\n"
    )
    reader = VboImporter().open(path, ReadOptions(), ImportLog())
    assert not reader.channels
    (chunk,) = reader.read(frozenset())
    assert chunk.time_ns.tolist() == [10**9, 2 * 10**9]
    assert not chunk.columns
