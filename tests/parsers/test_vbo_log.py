"""Racelogic VBO: files built by hand, every trap of the format, and two recorded logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from vbo_files import NAMES, Read, read, row, utc_ns, vbo

from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.vbo_log import VboImporter


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


@pytest.mark.parametrize("first", ["083856.300", "225320.000"])
def test_rows_before_the_satellites_time_is_known(tmp_path: Path, first: str) -> None:
    before = [row("000000.000", sats="000")] * 700
    created = "File created on 11/04/2014 @ " + f"{first[:2]}:{first[2:4]}"
    log = read(tmp_path, vbo([*before, row(first), row(first[:-3] + "400")], created=created))
    moment = f"2014-04-11T{first[:2]}:{first[2:4]}:{first[4:]}"
    assert log.time[0] == utc_ns(moment)
    assert len(log.time) == 2
    assert log.log.rejected == {"row before the satellites' time was known": 700}


def test_one_row_at_midnight_stays(tmp_path: Path) -> None:
    log = read(tmp_path, vbo([row("235959.990"), row("000000.000"), row("000000.010")]))
    assert np.diff(log.time).tolist() == [10_000_000, 10_000_000]
    assert not log.log.rejected


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


def test_the_time_of_a_short_stretch_of_zeros_is_said(tmp_path: Path) -> None:
    whole = vbo([row(f"0838{k // 100:02d}.{k % 100:02d}0") for k in range(300)])
    begin = whole.index(b"083801.000") + 20
    log = read(tmp_path, whole[:begin] + bytes(2000) + whole[begin + 2000 :])
    assert log.log.status == "malformed"
    assert log.log.rejected == {"row with bytes that are no text": 1}
    at = int(np.argmax(np.diff(log.time)))
    assert log.log.lost_spans_ns == [(int(log.time[at]), int(log.time[at + 1]))]
    assert 100_000_000 < log.time[at + 1] - log.time[at] < 250_000_000


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


@pytest.mark.parametrize("codec", ["utf-16", "utf-16-le", "utf-16-be"])
def test_a_log_saved_with_two_bytes_a_letter_is_read(codec: str, tmp_path: Path) -> None:
    plain = vbo([row("083856.300"), row("083856.400", "+2.5E+01"), row("083856.500")])
    data = plain.decode("cp1252").encode(codec)
    assert VboImporter().claims(tmp_path, data[:4096])
    expected, log = read(tmp_path, plain), read(tmp_path, data)
    assert log.time.tolist() == expected.time.tolist()
    assert {name: column.tolist() for name, column in log.columns.items()} == {
        name: column.tolist() for name, column in expected.columns.items()
    }
    assert {name: channel.unit for name, channel in log.info.items()} == {
        name: channel.unit for name, channel in expected.info.items()
    }
    assert "UTF-16" in log.said
    cut = read(tmp_path, data[:-31])
    assert (len(cut.time), cut.log.status) == (2, "truncated")
    assert not VboImporter().claims(tmp_path, "time,speed\n0,1\n1,2\n".encode(codec))


def _drive(lat_unit: float, *, kmh: float = 72.0) -> bytes:
    """Northwards from 48 N, 11.5 W at a steady speed, 10 rows a second; positions in minutes times `lat_unit`."""
    rows = []
    for k in range(600):
        north = 48 * 60 + kmh / 3.6 * 0.1 * k / 1852
        rows.append(
            f"009 0838{k // 10:02d}.{k % 10}00 {north * lat_unit:+015.9f} {11.5 * 60 * lat_unit:+015.9f} {kmh:07.3f} "
            "000.00 +0036.11 -0000.06 0.000000 +3608.2 -1.0E+00 +1.2E-02 +1.0E+01 "
        )
    return vbo(rows)


@pytest.mark.parametrize("kmh", [72.0, 0.0])
def test_positions_in_degrees_are_read_as_such(kmh: float, tmp_path: Path) -> None:
    table = read(tmp_path, _drive(1 / 60, kmh=kmh))
    assert table.info["lat"].unit == "deg"
    assert table.info["long"].unit == "deg"
    assert table.columns["lat"][0] == pytest.approx(48.0)
    assert "positions are" in table.said
    assert "degrees" in table.said
    plain = read(tmp_path, _drive(1.0, kmh=kmh))
    assert plain.info["lat"].unit != "deg"
    assert "degrees" not in plain.said


def test_minutes_near_the_zero_of_a_simulator_stay_minutes(tmp_path: Path) -> None:
    # a drive at 0 degrees 30', whose way fits its speed as minutes
    rows = [
        f"009 0838{k // 10:02d}.{k % 10}00 {30 + 2 * k / 1852:+015.9f} +00020.000000000 072.000 000.00 +0036.11 -0000.06 0.0 +3608.2 "
        "-1.0E+00 +1.2E-02 +1.0E+01 "
        for k in range(600)
    ]
    table = read(tmp_path, vbo(rows))
    assert table.info["lat"].unit != "deg"
    assert "degrees" not in table.said
