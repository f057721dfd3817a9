"""Numbers and text as a report prints them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.text import (
    clean,
    decimals_for,
    gist,
    number,
    percent,
    seconds,
    sentence,
    significant,
    span,
    with_unit,
)


@pytest.mark.parametrize(
    ("half_width", "decimals"),
    [(0.054, 3), (0.0094, 4), (0.71, 2), (3.2, 1), (31.0, 0), (118.0, -1), (15210.0, -3)],
)
def test_the_interval_decides_the_digits(half_width: float, decimals: int) -> None:
    assert decimals_for(half_width, 2) == decimals


def test_without_an_interval_the_table_decides() -> None:
    assert [decimals_for(bad, 4) for bad in (None, 0.0, math.nan, math.inf)] == [4] * 4


@pytest.mark.parametrize(
    ("value", "decimals", "shown"),
    [
        (0.5581, 3, "0.558"),
        (-0.0042, 3, "−0.004"),
        (-0.0001, 3, "0.000"),
        (1632.4, 0, "1632"),
        (61432.0, -3, "61\u202f000"),
        (1234567.0, 0, "1\u202f234\u202f567"),
        (None, 2, "—"),
        (math.nan, 2, "—"),
        (math.inf, 2, "—"),
    ],
)  # fmt: skip
def test_number(value: float | None, decimals: int, shown: str) -> None:
    assert number(value, decimals) == shown


def test_units_stand_behind_a_narrow_space_and_never_behind_a_dash() -> None:
    assert with_unit("0.558", "m") == "0.558\u202fm"
    assert with_unit("0.27", "–") == "0.27"
    assert with_unit("—", "m") == "—"


def test_intervals_use_words_where_a_minus_would_meet_the_dash() -> None:
    assert span(0.502, 0.614, 3) == "0.502–0.614"
    assert span(-0.035, 0.027, 3) == "−0.035 to 0.027"
    assert span(None, 1.0, 3) == "—"


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.25, "0.25\u202fs"), (41.3, "41.3\u202fs"), (725.0, "12\u202fmin 05\u202fs"), (3725.0, "1\u202fh 02\u202fmin"), (119.97, "2\u202fmin 00\u202fs")],
)  # fmt: skip
def test_durations(value: float, shown: str) -> None:
    assert seconds(value) == shown


def test_significant_figures() -> None:
    assert [significant(v) for v in (99.98, 100.0, 0.0021, 41.0, -3.14159)] == [
        "100",
        "100",
        "0.00210",
        "41",
        "−3.14",
    ]
    assert significant(-9.5949e15) == "−9.59\u202f×\u202f10¹⁵"
    assert significant(2.5978e-7, 2) == "2.6\u202f×\u202f10⁻⁷"
    assert number(3.25e13, 0) == "3.250\u202f×\u202f10¹³"
    assert percent(0.643) == "64\u202f%"


@given(st.text(max_size=300))
def test_clean_text_is_one_printable_line(text: str) -> None:
    line = clean(text)
    assert len(line) <= 400
    assert not any(ord(c) < 32 or 0x7F <= ord(c) < 0xA0 or 0xD800 <= ord(c) < 0xE000 for c in line)
    assert not set(line) & set("\u202e\u202d\u2066\u2028")
    line.encode("utf-8")
    assert clean(line) == line


def test_long_text_is_cut_and_says_so() -> None:
    assert clean("x" * 5000, 40) == "x" * 39 + "…"


def test_sentences_begin_and_end_well_but_names_keep_their_case() -> None:
    assert sentence("the log is short") == "The log is short."
    assert sentence("yaw_rate is inverted.") == "yaw_rate is inverted."
    assert sentence("") == ""


def test_a_long_reason_is_cut_between_clauses() -> None:
    reason = "the log does not tell it; " + "roll motion gives a ratio only, " * 5 + "and so on; " + "x" * 300
    assert gist(reason, 200).endswith("and so on\xa0…")
    assert gist("short; whole") == "short; whole"
    assert gist("the height and the mass of the (loaded body of the vehicle as driven that day", 46) == (
        "the height and the mass\xa0…"
    )
    assert len(gist("x" * 900, 190)) <= 192


def test_a_long_text_is_cut_at_a_words_end() -> None:
    assert clean("lacks accel_y (lateral acceleration)", 20) == "lacks accel_y…"
    assert clean("Roll stiffness; Roll damping; Roll inertia", 38) == "Roll stiffness; Roll damping; Roll…"
    assert clean("one two three", 8) == "one two…"


def test_a_long_name_without_blanks_is_cut_within() -> None:
    assert clean("x" * 30, 10) == "x" * 9 + "…"
    assert clean("a " + "x" * 30, 10) == "a xxxxxxx…"
