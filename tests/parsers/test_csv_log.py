"""CSV and its relatives: every dialect gives the numbers that were written."""

from __future__ import annotations

import csv
import io
import itertools
import math
import struct
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.csv_log import CsvImporter, CsvReader
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.jit import kernel
from parsers.table_bytes import address_of
from parsers.table_names import ColumnName, is_unit, split_header, unique_names
from parsers.table_numbers import HARD, OK, TEXT, parse_number
from parsers.table_rows import RowCollector, RowPlan, RowRules, plain_float
from parsers.table_stamps import calendar_stamp, decimal_stamp, unwrap_days
from parsers.table_swar import PADDING
from parsers.table_text import find_encoding, text_blocks
from parsers.table_time import guess_unit

T = [0, 10_000_000, 20_000_000, 30_000_000]
AX = [0.5, -1.25, 3.0, 1e-3]
AY = [9.81, 0.0, -2.5, 7.0]


class Read:
    """A table read whole."""

    def __init__(self, path: Path, options: ReadOptions | None = None) -> None:
        self.log = ImportLog()
        head = path.read_bytes()[:4096]
        assert CsvImporter().claims(path, head)
        self.reader: CsvReader = CsvImporter().open(path, options or ReadOptions(), self.log)
        self.info = {channel.name: channel for channel in self.reader.channels}
        numbers = frozenset(name for name, channel in self.info.items() if channel.kind == "number")
        chunks = list(self.reader.read(numbers))
        self.time: IntArray = np.concatenate([chunk.time_ns for chunk in chunks])
        self.columns: dict[str, FloatArray] = {
            name: np.concatenate([chunk.columns[name] for chunk in chunks]) for name in numbers
        }

    @property
    def said(self) -> str:
        return "\n".join(self.log.notes)


def read(
    tmp_path: Path, text: str | bytes, options: ReadOptions | None = None, name: str = "log.csv"
) -> Read:
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return Read(path, options)


PLAIN = "t [s],AX [g],AY [m/s^2]\n0,0.5,9.81\n0.01,-1.25,0\n0.02,3,-2.5\n0.03,1e-3,7.0\n"
DIALECTS = {
    "plain": PLAIN,
    "crlf": PLAIN.replace("\n", "\r\n"),
    "old mac": PLAIN.replace("\n", "\r"),
    "byte order mark": b"\xef\xbb\xbf" + PLAIN.encode(),
    "utf-16": PLAIN.encode("utf-16"),
    "utf-16 big end": b"\xfe\xff" + PLAIN.encode("utf-16-be"),
    "utf-16 without mark": PLAIN.encode("utf-16-le"),
    "tabs": PLAIN.replace(",", "\t"),
    "semicolons and decimal commas": PLAIN.replace(",", ";").replace(".", ","),
    "tabs and decimal commas": PLAIN.replace(",", "\t").replace(".", ","),
    "bars": PLAIN.replace(",", "|"),
    "spaces": "t[s]  AX[g]  AY[m/s^2]\n 0      0.5   9.81\n 0.01  -1.25  0  \n 0.02   3    -2.5\n 0.03\t1e-3  7.0\n",
    "comma and blank": PLAIN.replace(",", ", "),
    "sep line": "sep=;\n" + PLAIN.replace(",", ";"),
    "quoted sep line": '"sep=,"\r\n' + PLAIN,
    "rows in quotes": "".join(f'"{line}"\n' for line in PLAIN.splitlines()),
    "cells in quotes": '"t [s]","AX [g]","AY [m/s^2]"\n"0","0.5","9.81"\n"0.01","-1.25","0"\n"0.02","3","-2.5"\n"0.03","1e-3","7.0"\n',
    "quoted decimal commas": '"t [s]","AX [g]","AY [m/s^2]"\n"0,00","0,5","9,81"\n"0,01","-1,25","0,0"\n"0,02","3,0","-2,5"\n"0,03","1e-3","7,0"\n',
    "units in a row": "t,AX,AY\ns,g,m/s^2\n0,0.5,9.81\n0.01,-1.25,0\n0.02,3,-2.5\n0.03,1e-3,7.0\n",
    "comments": "# made by a logger\n# version 1,2\n" + PLAIN.replace("0.02,", "# pause, here\n0.02,"),
    "header as a comment": "# " + PLAIN,
    "blank lines": "\n\n" + PLAIN.replace("\n0.02", "\n\n0.02") + "\n\n",
    "separator at each end": PLAIN.replace("\n", ",\n"),
    "separator at each row's end": PLAIN.replace("\n", ",\n").replace("^2],", "^2]"),
    "preamble": "Logger X,v1.0\nVehicle,Volvo\nDate,11/04/2014\n\n" + PLAIN,
    "plus signs and zeros": "t [s],AX [g],AY [m/s^2]\n+00.00,+0.5,+009.81\n+00.01,-1.25,+0\n0.02,+3,-2.5\n0.03,+1E-003,7.\n",
    "no line end": PLAIN.rstrip("\n"),
    "quoted text with separators": 't [s],note,AX [g],AY [m/s^2]\n0,"a,b",0.5,9.81\n0.01,"c,d,e",-1.25,0\n0.02,"",3,-2.5\n0.03,x,1e-3,7.0\n',
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_gives_the_same_numbers(dialect: str, tmp_path: Path) -> None:
    table = read(tmp_path, DIALECTS[dialect])
    assert table.time.tolist() == T
    assert table.columns["AX"].tolist() == AX
    assert table.columns["AY"].tolist() == AY
    assert table.info["AX"].unit == "g"
    assert table.info["AY"].unit == "m/s^2"
    assert table.log.messages == 4
    assert table.log.status == "complete"
    assert not table.log.rejected
    assert not table.reader.absolute
    assert table.reader.start_utc_ns is None


def test_motec_style_preamble_and_unit_row(tmp_path: Path) -> None:
    text = (
        '"Format","MoTeC CSV File",,,"Workbook",""\n"Venue","Track",,,"Worksheet",""\n"Sample Rate","100.000","Hz",,,\n\n'
        '"Time","Ground Speed","G Force Lat","Gear","Beacon","Comment"\n"s","km/h","G","","",""\n\n\n'
        '"0.000","36.0","0.51","2","",""\n"0.010","36.1","0.52","2","",""\n"0.020","36.2","0.53","2","",""\n'
    )
    table = read(tmp_path, text)
    assert table.columns["Ground Speed"].tolist() == [36.0, 36.1, 36.2]
    assert table.info["Ground Speed"].unit == "km/h"
    assert table.info["G Force Lat"].unit == "G"
    assert table.time.tolist() == T[:3]


def test_three_header_rows(tmp_path: Path) -> None:
    text = (
        "This file was made by a phone\nFormat,3\n\ntimestamp,speed,lateral_acc\nunix time,m/s,G\n,100: gps,calc\n"
        "1681400000.100,10.5,0.1\n1681400000.200,10.6,0.2\n1681400000.300,10.7,0.3\n"
    )
    table = read(tmp_path, text)
    assert table.reader.absolute
    assert table.time.tolist() == [1681400000_100000000 + k * 100_000_000 for k in range(3)]
    assert table.info["lateral_acc"].unit == "G"


def test_repeated_and_missing_names(tmp_path: Path) -> None:
    table = read(tmp_path, "t,a,a,,a_2\n0,1,2,3,4\n1,5,6,7,8\n2,9,9,9,9\n")
    assert {name: values[0] for name, values in table.columns.items()} == {
        "a": 1,
        "a_3": 2,
        "column_4": 3,
        "a_2": 4,
    }
    assert "'a' is repeated" in table.said


def test_comma_inside_header_brackets(tmp_path: Path) -> None:
    table = read(tmp_path, "t,pos(x,y),v\n0,1,2\n1,3,4\n2,5,6\n")
    assert table.columns["pos(x,y)"].tolist() == [1, 3, 5]
    assert table.columns["v"].tolist() == [2, 4, 6]
    assert "brackets" in table.said


def test_latin1_units(tmp_path: Path) -> None:
    table = read(tmp_path, "t;Drehrate [°/s];T [°C]\n0;1,5;20\n0,5;2,5;20\n1;3,5;21\n".encode("latin-1"))
    assert table.info["Drehrate"].unit == "°/s"
    assert table.info["T"].unit == "°C"
    assert table.columns["Drehrate"].tolist() == [1.5, 2.5, 3.5]


def test_grouped_digits(tmp_path: Path) -> None:
    table = read(tmp_path, "t;F [N]\n0;1.234,5\n1;12.345.678,25\n2;3,5\n")
    assert table.columns["F"].tolist() == [1234.5, 12345678.25, 3.5]
    assert "grouped" in table.said
    assert read(tmp_path, 't,F\n0,"1,234.5"\n1,"-7,000,000.25"\n2,3.5\n').columns["F"].tolist() == [
        1234.5,
        -7000000.25,
        3.5,
    ]


def test_canonical_columns_keep_their_name_and_tell_their_unit(tmp_path: Path) -> None:
    table = read(
        tmp_path,
        "time_ns,accel_y_mps2,latitude_deg,satellites\n1400000000000000001,1,50,7\n1400000000010000002,2,50,7\n",
    )
    assert table.info["accel_y_mps2"].unit == "m/s²"
    assert table.info["latitude_deg"].unit == "deg"
    assert table.time.tolist() == [1400000000000000001, 1400000000010000002]
    assert table.reader.absolute


def test_missing_and_odd_cells(tmp_path: Path) -> None:
    rows = [
        "0,1",
        "1,",
        "2,NaN",
        "3,n/a",
        "4,--",
        "5,-",
        "6,inf",
        "7,-Infinity",
        "8,ERR",
        "9,0x1F",
        "10,null",
        "11,2.5",
        "12,1e999",
    ]
    table = read(
        tmp_path, "t,a\n" + "\n".join(rows) + "\n" + "\n".join(f"{k},3" for k in range(13, 40)) + "\n"
    )
    a = table.columns["a"]
    assert a[0] == 1
    assert np.isnan(a[1:11]).all()
    assert a[11] == 2.5
    assert table.log.rejected == {
        "cell with an infinite value": 2,
        "cell with text where a number was expected": 2,
    }
    assert "'ERR'" in table.said


def test_ragged_rows_are_counted(tmp_path: Path) -> None:
    table = read(tmp_path, "t,a,b\n0,1,2\n1,1,2\n2,1,2\n3,1\n4,1,2,3\n,1,2\nxx,1,2\n5,1,2\nt,a,b\n6,1,2\n")
    assert table.time.tolist() == [0, 10**9, 2 * 10**9, 5 * 10**9, 6 * 10**9]
    assert table.log.rejected == {
        "row with too few columns": 1,
        "row with too many columns": 1,
        "row without a valid time": 3,
        "cell with text where a number was expected": 2,
    }
    assert table.log.status == "complete"


def test_truncated_last_row(tmp_path: Path) -> None:
    table = read(tmp_path, PLAIN + "0.04,5")
    assert table.time.tolist() == T
    assert table.log.status == "truncated"
    assert table.log.rejected == {"row with too few columns": 1}
    assert "4 rows" in table.said


def test_zeros_in_the_middle(tmp_path: Path) -> None:
    lines = "".join(f"{k / 100},{k}\n" for k in range(1000))
    table = read(tmp_path, ("t,a\n" + lines).encode()[:6000] + bytes(700) + lines.encode()[6700:])
    assert table.log.status == "malformed"
    assert table.log.rejected["row with bytes that are no text"] == 1
    assert len(table.time) > 800


def test_a_tail_of_zeros_is_bounded(tmp_path: Path) -> None:
    table = read(tmp_path, PLAIN.encode() + bytes(13_000_000))
    assert table.time.tolist() == T
    assert table.log.status == "malformed"


TIMES = {
    "ms": ("Time (ms),a\n0,1\n10,1\n20,1\n", ReadOptions(), [0, 10_000_000, 20_000_000]),
    "us name": ("timestamp_us,a\n0,1\n10,1\n20,1\n", ReadOptions(), [0, 10_000, 20_000]),
    "epoch s": (
        "timestamp,a\n1397205536.123456789,1\n1397205537.5,1\n",
        ReadOptions(),
        [1397205536123456789, 1397205537500000000],
    ),
    "epoch ms": (
        "timestamp,a\n1397205536123,1\n1397205537500,1\n",
        ReadOptions(),
        [1397205536123000000, 1397205537500000000],
    ),
    "epoch us": (
        "timestamp,a\n1397205536123456,1\n1397205537500000,1\n",
        ReadOptions(),
        [1397205536123456000, 1397205537500000000],
    ),
    "epoch ns": (
        "timestamp,a\n1397205536123456789,1\n1397205537500000001,1\n",
        ReadOptions(),
        [1397205536123456789, 1397205537500000001],
    ),
    "rostopic": (
        "%time,field.header.seq,field.header.stamp,a\n1500000000000000009,4,1500000000000000001,1\n1500000000500000009,5,1500000000500000002,1\n",
        ReadOptions(),
        [1500000000000000001, 1500000000500000002],
    ),
    "stamp pair": (
        "Time,header.seq,header.stamp.secs,header.stamp.nsecs,a\n9.5,1,1500000000,7,1\n10.5,2,1500000000,999999999,1\n",
        ReadOptions(),
        [1500000000000000007, 1500000000999999999],
    ),
    "named": (
        "x,weird,a\n5,0.5,1\n5,1.5,1\n",
        ReadOptions(time_channel="weird", time_unit="s"),
        [500000000, 1500000000],
    ),
    "named by header": (
        "x,weird [ms],a\n5,0.5,1\n5,1.5,1\n",
        ReadOptions(time_channel="weird [ms]"),
        [500000, 1500000],
    ),
    "named beats unit": (
        "t [s],a\n1,1\n2,1\n",
        ReadOptions(time_channel="t", time_unit="ms"),
        [1000000, 2000000],
    ),
    "iso": (
        "when,a\n2014-04-11T08:38:56.3Z,1\n2014-04-11T08:38:57.25Z,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "iso zone": (
        "when,a\n2014-04-11T10:38:56.3+02:00,1\n2014-04-11T03:08:57.25-0530,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "iso blank": (
        "time,a\n2014-04-11 08:38:56.300,1\n2014-04-11 08:38:57.250,2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "two columns": (
        "Date;Time;a\n11.04.2014;08:38:56,300;1\n11.04.2014;08:38:57,250;2\n",
        ReadOptions(),
        [1397205536300000000, 1397205537250000000],
    ),
    "american": (
        "DateTime,a\n04/11/2014 08:38:56.3 PM,1\n04/13/2014 12:00:00 AM,2\n",
        ReadOptions(),
        [1397248736300000000, 1397347200000000000],
    ),
    "time of day": (
        "Time,a\n23:59:59.5,1\n00:00:00.5,2\n00:00:01.5,2\n",
        ReadOptions(),
        [86399500000000, 86400500000000, 86401500000000],
    ),
}


@pytest.mark.parametrize("case", TIMES)
def test_times(case: str, tmp_path: Path) -> None:
    text, options, expected = TIMES[case]
    table = read(tmp_path, text, options)
    assert table.time.tolist() == expected
    assert table.reader.absolute == (expected[0] > 10**18)
    if "epoch" in case:
        assert "states no unit" in table.said
    if case == "iso blank":
        assert "no time zone" in table.said
    if case in ("rostopic", "stamp pair"):
        assert table.reader.clock.startswith("header stamp")


def test_ambiguous_dates_are_said(tmp_path: Path) -> None:
    table = read(tmp_path, "time,a\n04/11/2014 08:00:00,1\n04/11/2014 08:00:01,2\n")
    assert "two ways" in table.said
    assert table.time[0] == int(datetime(2014, 11, 4, 8, tzinfo=UTC).timestamp()) * 10**9


def test_a_unit_stated_is_never_overruled(tmp_path: Path) -> None:
    table = read(tmp_path, "t [s],a\n0,1\n10,2\n20,3\n")
    assert table.time.tolist() == [0, 10 * 10**9, 20 * 10**9]
    assert "unit" not in table.said


def test_no_header(tmp_path: Path) -> None:
    table = read(
        tmp_path, "0.00,1.5,2\n0.01,1.6,3\n0.02,1.7,4\n", ReadOptions(time_channel="column_1", time_unit="s")
    )
    assert table.columns["column_2"].tolist() == [1.5, 1.6, 1.7]
    assert table.time.tolist() == T[:3]
    assert "no header" in table.said


ERRORS = {
    "one column": ("t\n1\n2\n3\n", ReadOptions(), "no rows of numbers"),
    "no time column": ("a,b\n1,2\n3,4\n5,6\n", ReadOptions(), r"no time column.*\[time\]"),
    "no header": ("1,2\n3,4\n5,6\n", ReadOptions(), r"no time column.*column_1"),
    "no such column": ("tme,b\n1,2\n3,4\n", ReadOptions(time_channel="time"), r'no column "time".*"tme"'),
    "header only": ("t,a,b\n", ReadOptions(), "no rows of numbers"),
    "prose": ("the quick brown\nfox jumps over the\nlazy dog\n", ReadOptions(), "no rows of numbers"),
    "numbers for iso": (
        "t,a\n1,2\n3,4\n",
        ReadOptions(time_channel="t", time_unit="iso8601"),
        "not ISO 8601",
    ),
    "no unit": ("t,a\n1,2\n3,4\n", ReadOptions(time_channel="t", time_unit="parsec"), "parsec"),
    "dates only": ("date,a\n2014-04-11,2\n2014-04-12,4\n", ReadOptions(), "time of day"),
    "empty": ("", ReadOptions(), "empty"),
    "binary": (b"t,a\n0,1\n" + bytes(range(256)), ReadOptions(), "not text"),
}


@pytest.mark.parametrize("case", ERRORS)
def test_errors_are_one_clear_line(case: str, tmp_path: Path) -> None:
    text, options, message = ERRORS[case]
    path = tmp_path / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(LogError, match=message) as caught:
        CsvImporter().open(path, options, ImportLog())
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_claims_only_text_that_looks_like_a_table(tmp_path: Path) -> None:
    def claims(data: bytes, name: str) -> bool:
        path = tmp_path / name
        path.write_bytes(data)
        return CsvImporter().claims(path, data[:4096])

    assert claims(PLAIN.encode(), "drive.bin")
    assert claims(b"t,a,b\n", "drive.csv")
    assert not claims(b"t,a,b\n", "drive.bin")
    assert not claims(np.random.default_rng(1).integers(0, 256, 5000, dtype=np.uint8).tobytes(), "drive.csv")
    assert not claims(b"\x00" * 5000, "drive.csv")
    assert not claims(b'{"a": 1, "b": 2}\n{"a": 3, "b": 4}\n', "drive.txt")
    assert not claims(b"<html><body>1,2\n3,4\n</body></html>", "drive.csv")
    assert not claims(b"the quick brown\nfox jumps over the\nlazy dog\n", "drive.txt")
    assert not claims(b"def f(x):\n    return x + 1\n\n\nprint(f(2))\n", "drive.py")


def test_only_wanted_columns_and_text_is_never_decoded(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,a,b,state\n0,1,2,ON\n1,3,4,OFF\n2,3,4,ON\n")
    log = ImportLog()
    reader = CsvImporter().open(path, ReadOptions(), log)
    assert [(c.name, c.kind) for c in reader.channels] == [
        ("a", "number"),
        ("b", "number"),
        ("state", "text"),
    ]
    (chunk,) = reader.read(frozenset({"b", "state"}))
    assert list(chunk.columns) == ["b"]
    assert not log.rejected


def test_blocks_join_without_a_seam(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    values = rng.normal(size=(2000, 3))
    text = "t,a,b,c\n" + "".join(
        f"{k / 100},{','.join(map(repr, row))}\n" for k, row in enumerate(values.tolist())
    )
    path = tmp_path / "log.csv"
    for encoded in (text.encode(), text.encode("utf-16")):
        path.write_bytes(encoded)
        encoding = find_encoding(encoded[:4096])
        assert encoding is not None
        parts = [block.data for block in text_blocks(path, encoding, text.index("\n") + 1, block_bytes=1000)]
        assert len(parts) > 50
        assert all(part.endswith(b"\n") for part in parts)
        body = text[text.index("\n") + 1 :].encode()
        assert b"".join(parts) == body
    collector = RowCollector(RowPlan(RowRules(44, 4, 4), (1, 2, 3)))
    for part in parts:
        collector.take(bytearray(part + bytes(PADDING)), 0, len(part), len(part), 0)
    got = np.concatenate([block.numbers for block in collector.finish()], axis=1)
    np.testing.assert_array_equal(got, values.T)


def test_equals_the_peer_reader() -> None:
    rng = np.random.default_rng(2)
    frame = pl.DataFrame(
        {f"c{k}": rng.normal(size=500) * 10.0 ** rng.integers(-300, 300, 500) for k in range(6)}
    )
    text = frame.write_csv().encode()
    collector = RowCollector(RowPlan(RowRules(44, 6, 6), tuple(range(6))))
    collector.take(bytearray(text + bytes(PADDING)), text.index(b"\n") + 1, len(text), len(text), 0)
    (block,) = collector.finish()
    np.testing.assert_array_equal(block.numbers.T, pl.read_csv(io.BytesIO(text)).to_numpy())


@kernel
def parse_bytes(data: ByteArray, decimal: int, thousands: int) -> tuple[int, float]:
    start = address_of(data)
    return parse_number(start, start + data.shape[0], decimal, thousands)


@kernel
def decimal_bytes(data: ByteArray, unit_ns: int) -> tuple[bool, int]:
    start = address_of(data)
    return decimal_stamp(start, start + data.shape[0], 46, 0, unit_ns)


@kernel
def calendar_bytes(data: ByteArray) -> tuple[bool, int, int]:
    start = address_of(data)
    return calendar_stamp(start, start + data.shape[0], 0)


def number(text: str, decimal: str = ".", thousands: str = "\0") -> tuple[int, float]:
    return parse_bytes(np.frombuffer(text.encode(), dtype=np.uint8), ord(decimal), ord(thousands))


@settings(max_examples=400, deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_shortest_texts_give_the_same_double(value: float) -> None:
    assert read_number(repr(value)) == value


@settings(max_examples=400, deadline=None)
@given(st.from_regex(r"[+-]?[0-9]{1,25}(\.[0-9]{0,25})?([eE][+-]?[0-9]{1,3})?", fullmatch=True))
def test_any_decimal_text_gives_what_python_gives(text: str) -> None:
    assert struct.pack("d", read_number(text)) == struct.pack("d", float(text))


def read_number(text: str) -> float:
    status, value = number(text)
    assert status in (OK, HARD)
    return value if status == OK else plain_float(text.encode(), RowRules(44, 1, 1))


@pytest.mark.parametrize(
    "text", ["", "+", ".", "e5", "1e", "1e+", "1.2.3", "12:30", "0x10", "1_000", "1 2", "--1", "1,5"]
)
def test_what_is_no_number(text: str) -> None:
    assert number(text)[0] == TEXT


HARD_DECIMALS = [
    "9007199254740993",
    "2.2250738585072011e-308",
    "1.7976931348623157e308",
    "5e-324",
    "0.000000000000000000000000001e27",
    "9007199254740992.9999999999999999999",
    "1e23",
    "8.5e22",
    "6.0221407e+23",
    "123456789012345678901234567890",
]


@pytest.mark.parametrize("text", HARD_DECIMALS)
def test_hard_decimals(text: str) -> None:
    assert read_number(text) == float(text)


@settings(max_examples=300, deadline=None)
@given(st.integers(-(2**62), 2**62))
def test_decimal_seconds_are_exact(nanos: int) -> None:
    sign = "-" if nanos < 0 else ""
    text = f"{sign}{abs(nanos) // 10**9}.{abs(nanos) % 10**9:09d}"
    valid, stamp = decimal_bytes(np.frombuffer(text.encode(), dtype=np.uint8), 10**9)
    assert valid
    assert abs(stamp - nanos) <= (0 if len(text.strip("-").replace(".", "").lstrip("0")) <= 18 else 9)


@settings(max_examples=200, deadline=None)
@given(
    st.datetimes(datetime(1950, 1, 1), datetime(2150, 1, 1)),
    st.integers(-14 * 60, 14 * 60),
    st.sampled_from("T "),
)
def test_iso_times_are_exact(moment: datetime, zone: int, between: str) -> None:
    sign = "-" if zone < 0 else "+"
    text = f"{moment.isoformat(between)}{sign}{abs(zone) // 60:02d}:{abs(zone) % 60:02d}"
    data = np.frombuffer(text.encode(), dtype=np.uint8)
    valid, day, rest = calendar_bytes(data)
    expected = (moment - datetime(1970, 1, 1) - timedelta(minutes=zone)) // timedelta(microseconds=1) * 1000
    assert valid
    assert day + rest == expected


def test_times_of_day_run_on_over_midnight_and_back() -> None:
    hour = 3600 * 10**9
    clock = np.array([22, 23, 0, 1, 23, 0], dtype=np.int64) * hour
    assert (unwrap_days(clock, None) // hour).tolist() == [22, 23, 24, 25, 23, 24]
    assert (unwrap_days(np.array([1 * hour]), 47 * hour) // hour).tolist() == [49]


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("AY [g]", "AY", "g"),
        ("ay (m/s^2)", "ay", "m/s^2"),
        ("speed_kmh", "speed_kmh", "km/h"),
        ("YawRate_deg/s", "YawRate_deg/s", "deg/s"),
        ("Time[s]", "Time", "s"),
        ("accel_y_mps2", "accel_y_mps2", "m/s²"),
        ("Speed, km/h", "Speed", "km/h"),
        ("v / km/h", "v", "km/h"),
        ("pose[3]", "pose[3]", None),
        ("accel (lateral)", "accel (lateral)", None),
        ("gears_s", "gears_s", None),
        ("", "", None),
    ],
)
def test_headers(header: str, name: str, unit: str | None) -> None:
    assert split_header(header) == ColumnName(header, name, unit)


@given(st.lists(st.sampled_from(["", "a", "b", "a_2", "a_2_2", "column_1"]), max_size=12))
def test_unique_names_are_unique_and_keep_what_was_unique(names: list[str]) -> None:
    result, repeated = unique_names([ColumnName(name, name) for name in names])
    assert len({column.name for column in result}) == len(names)
    for name, column in zip(names, result, strict=True):
        if name and names.count(name) == 1 and "" not in names:
            assert column.name == name
    assert set(repeated) == {name for name in names if name and names.count(name) > 1}


def test_units_are_told_from_names() -> None:
    assert all(is_unit(text) for text in ("g", "[m/s²]", "km/h", "°C", "%", "rpm", "deg/s"))
    assert not any(is_unit(text) for text in ("", "lateral", "X", "front left"))


@pytest.mark.parametrize(
    ("values", "unit_ns"),
    [
        ([0, 0.01, 0.02], 10**9),
        ([0, 1, 2], 10**9),
        ([0, 10, 20], 10**6),
        ([0, 10000, 20000], 1000),
        ([0, 1e7, 2e7], 1),
        ([1.4e9] * 2, 10**9),
        ([], 10**9),
    ],
)
def test_guessed_units(values: list[float], unit_ns: int) -> None:
    assert guess_unit(values)[0] == unit_ns


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
cell = st.one_of(finite, st.none())


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    rows=st.lists(st.tuples(finite, cell, cell), min_size=3, max_size=30),
    separator=st.sampled_from(["\t", ";", ",", "|"]),
    comma=st.booleans(),
    quoting=st.sampled_from([csv.QUOTE_MINIMAL, csv.QUOTE_ALL]),
    line_end=st.sampled_from(["\n", "\r\n"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]),
    units=st.booleans(),
)
def test_any_dialect_reads_back_what_was_written(
    rows: list[tuple[float, float | None, float | None]],
    separator: str,
    comma: bool,
    quoting: int,
    line_end: str,
    encoding: str,
    units: bool,
    tmp_path: Path,
) -> None:
    def spell(value: float | None) -> str:
        text = "" if value is None else repr(float(value))
        return text.replace(".", ",") if comma else text

    buffer = io.StringIO()
    writer = csv.writer(buffer, delimiter=separator, quoting=quoting, lineterminator=line_end)  # type: ignore[arg-type]
    writer.writerow(["t", "Drehrate °", "a b", "c"])
    if units:
        writer.writerow(["s", "deg/s", "g", "m"])
    for k, row in enumerate(rows):
        writer.writerow([spell(k * 0.25), *map(spell, row)])
    path = tmp_path / "any.csv"
    path.write_bytes(buffer.getvalue().encode(encoding))
    table = Read(path, ReadOptions(time_channel="t", time_unit="s"))
    assert table.time.tolist() == [k * 250_000_000 for k in range(len(rows))]
    for name, column in zip(("Drehrate °", "a b", "c"), zip(*rows, strict=True), strict=True):
        expected = np.array([math.nan if value is None else value for value in column])
        np.testing.assert_array_equal(table.columns[name], expected)
        assert (table.info[name].unit is not None) == units
    assert not table.log.rejected


def test_damage_never_escapes_as_a_crash(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    whole = ("t [s],a,b\n" + "".join(f"{k / 100},{k},{k * k}\n" for k in range(300))).encode()
    path = tmp_path / "log.csv"
    for cut, noise in itertools.product((0, 5, 9, 50, 1000, 2001), (0, 1, 40)):
        data = bytearray(whole[:cut] if cut else whole)
        for at in rng.integers(0, len(data), noise):
            data[at] = rng.integers(0, 256)
        path.write_bytes(bytes(data))
        log = ImportLog()
        try:
            reader = CsvImporter().open(path, ReadOptions(), log)
            rows = sum(len(chunk.time_ns) for chunk in reader.read(frozenset({"a"})))
        except LogError as error:
            assert str(path) in str(error)  # noqa: PT017
        else:
            assert 0 < rows <= 300


BREAKS = {
    "broken rows": ("garbage\n" * 50, [(990_000_000, 1_500_000_000)]),
    "bytes": ("1.0,\0\0\0\n" * 50, [(990_000_000, 1_500_000_000)]),
    "no times": ("n/a,1,2\n" * 50, [(990_000_000, 1_500_000_000)]),
    "comments": ("# pause\n" * 50, []),
    "nothing": ("", []),
}


@pytest.mark.parametrize("case", BREAKS)
@pytest.mark.parametrize("block_bytes", [200, 8_000_000])
def test_what_damage_takes_in_time_is_written_down(case: str, block_bytes: int, tmp_path: Path) -> None:
    broken, expected = BREAKS[case]
    rows = [f"{k / 100:.2f},{k},7\n" for k in range(300)]
    # a single bad row takes less than a quarter of a second with it
    rows[200] = "2.00,1\n"
    path = tmp_path / "log.csv"
    path.write_text("bad\n" * 3 + "t [s],a,b\n" + "".join(rows[:100]) + broken + "".join(rows[150:]))
    log = ImportLog()
    reader = CsvImporter().open(path, ReadOptions(), log)
    reader._block_bytes = block_bytes
    assert sum(len(chunk.time_ns) for chunk in reader.read(frozenset({"a"}))) == 249
    assert log.lost_spans_ns == expected


def test_the_list_of_lost_spans_is_bounded(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t [s],a\n" + "".join(f"{k},1\n{'x' if k >= 4000 else ''}\n" for k in range(6000)))
    log = ImportLog()
    list(CsvImporter().open(path, ReadOptions(), log).read(frozenset({"a"})))
    assert log.lost_spans_ns == [(k * 10**9, (k + 1) * 10**9) for k in range(4000, 5000)]
    assert any("lost" in note for note in log.notes)


@pytest.mark.parametrize("bad", ["00:0m:00", "Time59", "0\u00c0:00:00", "2014-04-11", "1"])
def test_a_damaged_time_of_day_costs_its_row(bad: str, tmp_path: Path) -> None:
    clock = [f"08:00:{k:02}" for k in range(20)]
    clock[7] = bad
    table = read(tmp_path, "Time,a\n" + "".join(f"{text},1\n" for text in clock))
    assert len(table.time) == 19
    assert not table.reader.absolute
    assert table.log.rejected == {"row without a valid time": 1}
    assert table.log.lost_spans_ns == [(28806 * 10**9, 28808 * 10**9)]


@pytest.mark.parametrize("zone", ["", "Z", "+02:00"])
def test_times_of_day_run_on_over_the_seams_of_blocks(zone: str, tmp_path: Path) -> None:
    moments = [(22 * 3600 + k * 60) % 86400 for k in range(400)]
    text = "Time,a\n" + "".join(
        f"{m // 3600:02}:{m // 60 % 60:02}:00{zone},{k}\n" for k, m in enumerate(moments)
    )
    path = tmp_path / "log.csv"
    path.write_text(text)
    reader = CsvImporter().open(path, ReadOptions(), ImportLog())
    reader._block_bytes = 100
    chunks = list(reader.read(frozenset({"a"})))
    assert len(chunks) > 20
    assert set(np.diff(np.concatenate([chunk.time_ns for chunk in chunks])).tolist()) == {60 * 10**9}
