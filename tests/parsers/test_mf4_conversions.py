"""MF4 conversions built by hand, and formulas as texts."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.mf4.algebra import FormulaError, evaluate
from parsers.mf4.conversions import convert
from parsers.mf4.model import Conversion


def test_conversions_by_hand() -> None:
    x = np.array([-1.0, 0.0, 99.0, 99.5, 100.0, 250.0, 251.0])
    ranges = Conversion(6, np.array([0.0, 99.0, 1.0, 100.0, 250.0, 2.0, 3.0]))
    assert convert(ranges, x, whole_numbers=True).tolist() == [3, 1, 1, 3, 2, 2, 3]
    assert convert(ranges, x).tolist() == [3, 1, 3, 3, 2, 3, 3]
    table = Conversion(5, np.array([10.0, 1.0, 20.0, 2.0]))
    assert convert(table, np.array([0.0, 14.0, 15.0, 16.0, 99.0, np.nan]))[:5].tolist() == [1, 1, 1, 2, 2]
    linear = Conversion(1, np.array([-5.0, 0.5]))
    named = Conversion(7, np.array([255.0, 254.0]), ("not available", None, linear))
    got = convert(named, np.array([10.0, 254.0, 255.0]))
    assert got[:2].tolist() == [0.0, 122.0]
    assert np.isnan(got[2])


def test_a_table_without_a_default_leaves_what_it_does_not_list() -> None:
    """Ranges to scales and values to texts; the first that fits counts."""
    linear, shifted = Conversion(1, np.array([7.0, 3.0])), Conversion(1, np.array([1000.0, 2.0]))
    scales = Conversion(8, np.array([0.0, 99.0, 50.0, 199.0]), (linear, shifted, None))
    got = convert(scales, np.array([3.0, 60.0, 145.0, 200.0]), whole_numbers=True)
    assert got.tolist() == [16.0, 187.0, 1290.0, 200.0]
    assert convert(scales, np.array([99.0]), whole_numbers=False).tolist() == [1198.0]
    special = Conversion(7, np.array([198.0, 199.0]), ("SNA", "sensor error", None))
    raw = np.array([197.0, 198.0, 199.0])
    got = convert(special, raw, whole_numbers=True)
    assert got[0] == 197.0
    assert np.isnan(got[1:]).all()
    assert raw.tolist() == [197.0, 198.0, 199.0]
    gears = Conversion(7, np.array([0.0, 1.0, 2.0]), ("park", "reverse", "neutral"))
    assert convert(gears, np.array([0.0, 2.0, 5.0]), whole_numbers=True).tolist() == [0.0, 2.0, 5.0]
    mixed = Conversion(7, np.array([198.0, 199.0]), ("reserve", linear))
    got = convert(mixed, np.array([5.0, 198.0, 199.0]), whole_numbers=True)
    assert np.isnan(got[1])
    assert got[[0, 2]].tolist() == [5.0, 604.0]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2*X+1", 7.0),
        ("-X^2", -9.0),
        ("2^X^0.5*0+X**2", 9.0),
        ("(X1-1)/4", 0.5),
        ("sqrt(X+6)*pi", 3 * np.pi),
        ("1e-3*X", 0.003),
    ],
)
def test_formulas(text: str, value: float) -> None:
    assert evaluate(text, np.array([3.0]))[0] == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["", "X+", "__import__('os')", "X.real", "(X", "X)", "f(X)", "(" * 500 + "X", "X" * 3000]
)
def test_formulas_that_are_no_formulas(text: str) -> None:
    with pytest.raises(FormulaError):
        evaluate(text, np.array([3.0]))
