"""CSV and its relatives: every dialect gives the numbers that were written."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from csv_tables import PLAIN, Read, T, read
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from parsers.csv_log import CsvImporter
from parsers.importer import ImportLog, ReadOptions
from parsers.table_rows import RowCollector, RowPlan, RowRules
from parsers.table_swar import PADDING
from parsers.table_text import find_encoding, text_blocks

AX = [0.5, -1.25, 3.0, 1e-3]
AY = [9.81, 0.0, -2.5, 7.0]
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
    "minus signs of spreadsheets": PLAIN.replace("-", "\N{MINUS SIGN}"),
    "minus signs and decimal commas": PLAIN.replace(",", ";")
    .replace(".", ",")
    .replace("-", "\N{MINUS SIGN}"),
    "minus signs in quotes and utf-16": PLAIN.replace("-1.25", '"\N{MINUS SIGN}1.25"').encode("utf-16"),
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


def test_grouped_digits(tmp_path: Path) -> None:
    table = read(tmp_path, "t;F [N]\n0;1.234,5\n1;12.345.678,25\n2;3,5\n")
    assert table.columns["F"].tolist() == [1234.5, 12345678.25, 3.5]
    assert "grouped" in table.said
    assert read(tmp_path, 't,F\n0,"1,234.5"\n1,"-7,000,000.25"\n2,3.5\n').columns["F"].tolist() == [
        1234.5,
        -7000000.25,
        3.5,
    ]


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
