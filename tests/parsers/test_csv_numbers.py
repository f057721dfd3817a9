"""Decimal texts give the double that Python gives."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from csv_tables import read
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.channels import ByteArray
from parsers.jit import kernel
from parsers.table_bytes import address_of
from parsers.table_cells import MINUS
from parsers.table_numbers import HARD, OK, TEXT, parse_number
from parsers.table_rows import RowRules, plain_float


@kernel
def parse_bytes(data: ByteArray, decimal: int, thousands: int) -> tuple[int, float]:
    start = address_of(data)
    return parse_number(start, start + data.shape[0], decimal, thousands)


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
    assert struct.pack("d", read_number(text.replace("-", MINUS))) == struct.pack("d", float(text))


def read_number(text: str) -> float:
    status, value = number(text)
    assert status in (OK, HARD)
    return value if status == OK else plain_float(text.encode(), RowRules(44, 1, 1))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "+",
        ".",
        "e5",
        "1e",
        "1e+",
        "1.2.3",
        "12:30",
        "0x10",
        "1_000",
        "1 2",
        "--1",
        "1,5",
        "\N{MINUS SIGN}",
        "\N{MINUS SIGN}-1",
    ],
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


GROUPS = [
    "\N{NO-BREAK SPACE}",
    "\N{NARROW NO-BREAK SPACE}",
    "\N{THIN SPACE}",
    "\N{RIGHT SINGLE QUOTATION MARK}",
]


@pytest.mark.parametrize("codec", ["utf-8", "cp1252"])
@pytest.mark.parametrize("sign", GROUPS)
def test_groups_of_three_digits_behind_a_no_break_blank(sign: str, codec: str) -> None:
    if codec == "cp1252" and sign in GROUPS[1:3]:
        pytest.skip("not in that code page")

    def grouped(text: str) -> tuple[int, float]:
        data = text.replace("_", sign).encode(codec)
        return parse_bytes(np.frombuffer(data, dtype=np.uint8), ord(","), -1)

    assert grouped("1_234,5") == (OK, 1234.5)
    assert grouped("-12_345_678") == (OK, -12345678.0)
    assert grouped("1_234e2") == (OK, 123400.0)
    for text in ("1_23", "1_2345", "_123", "1,5_000", "1_", "1__234", "1_23a", "1_234_5"):
        assert grouped(text)[0] == TEXT
    hard = "1_234_567_890_123_456_789_012,5".replace("_", sign).encode(codec)
    assert plain_float(hard, RowRules(59, 1, 1, decimal=44)) == 1234567890123456789012.5


@settings(max_examples=200, deadline=None)
@given(st.integers(-(10**15), 10**15), st.sampled_from(GROUPS))
def test_any_whole_number_in_groups(value: int, sign: str) -> None:
    assert number(f"{value:,}".replace(",", sign)) == (OK, float(value))


def _mixed(first: float, *, grouped: str = "") -> str:
    """Time stamps with points beside quoted values with commas; grouped: a column with groups of digits."""
    speeds = [f"{1.5 + 0.001 * k:.6f}".replace(".", ",") for k in range(600)]
    more = f',"{grouped}"' if grouped else ""
    rows = [f'{first + 0.02 * k:.3f},"{speed}","0,5"{more}' for k, speed in enumerate(speeds)]
    return f"Time [s],Speed [km/h],Accel X [g]{',Load [N]' if grouped else ''}\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize("first", [0.0, 52.34, 1234.56])
@pytest.mark.parametrize("grouped", ["", "12.345,5"])
def test_a_time_with_points_beside_commas(tmp_path: Path, first: float, grouped: str) -> None:
    table = read(tmp_path, _mixed(first, grouped=grouped))
    assert table.time.tolist() == [round((first + 0.02 * k) * 1000) * 10**6 for k in range(600)]
    assert table.columns["Speed"][:2].tolist() == [1.5, 1.501]
    assert "the decimal sign in column \"Time\" is '.', in the others ','" in table.said
    if grouped:
        assert set(table.columns["Load"].tolist()) == {12345.5}


def test_a_column_of_fractions_is_not_read_as_groups(tmp_path: Path) -> None:
    rows = [f"{k};12.345,5;{0.9 + 0.01 * k:.3f}" for k in range(40)]
    table = read(tmp_path, "Time [s];Load [N];Share\n" + "\n".join(rows) + "\n")
    assert set(table.columns["Load"].tolist()) == {12345.5}
    assert table.info["Share"].kind == "text"


def test_grouped_milliseconds_stay_so(tmp_path: Path) -> None:
    rows = [f"{12000 + 20 * k:,};1,5".replace(",", ".", 1) for k in range(100)]
    table = read(tmp_path, "Time [ms];Speed [km/h]\n" + "\n".join(rows) + "\n")
    assert table.time[:2].tolist() == [12_000_000_000, 12_020_000_000]
