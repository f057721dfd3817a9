"""Unit texts: what they mean, what they do not, and that no two spellings contradict each other."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parsers.errors import MappingError
from parsers.signals import SIGNALS
from parsers.units import SI_TEXT, find_unit, quantities_of, require_unit, spellings


@pytest.mark.parametrize(
    ("text", "quantity", "scale"),
    [
        ("m/s²", "acceleration", 1.0),
        ("[m/s^2]", "acceleration", 1.0),
        ("m s⁻²", "acceleration", 1.0),
        ("m*s^-2", "acceleration", 1.0),
        ("rad s⁻¹", "angular_rate", 1.0),
        ("°·s-1", "angular_rate", math.pi / 180),
        ("m s-1", "speed", 1.0),
        ("min-1", "angular_rate", math.pi / 30),
        ("g", "acceleration", 9.80665),
        ("(G)", "acceleration", 9.80665),
        ("mg", "acceleration", 0.00980665),
        ("°/s", "angular_rate", math.pi / 180),
        ("\ufffd/s", "angular_rate", math.pi / 180),
        ("deg / s", "angular_rate", math.pi / 180),
        ("deg per s", "angular_rate", math.pi / 180),
        ("rad/s", "angular_rate", 1.0),
        ("km/h", "speed", 1 / 3.6),
        ("KPH", "speed", 1 / 3.6),
        ("knots", "speed", 1852 / 3600),
        ("mph", "speed", 1609.344 / 3600),
        ("min", "geographic_angle", 1 / 60),
        ("min", "time", 60.0),
        ("bar", "pressure", 1e5),
        ("MPa", "pressure", 1e6),
        ("mPa", "pressure", 1e-3),
        ("kN", "force", 1000.0),
        ("kn", "speed", 1852 / 3600),
        ("KN", "speed", 1852 / 3600),
        ("[kN]", "force", 1000.0),
        ("[mPa]", "pressure", 1e-3),
        ("kg", "force", 9.80665),
        ("mm", "length", 0.001),
        ("N·m", "torque", 1.0),
        ("%", "ratio", 0.01),
        ("%", "slope", 0.01),
        ("deg", "slope", math.pi / 180),
    ],
)
def test_known_answers(text, quantity, scale):
    unit = find_unit(text, quantity)
    assert unit is not None
    assert (unit.scale, unit.offset) == (pytest.approx(scale, rel=1e-12), 0.0)


@pytest.mark.parametrize(
    ("text", "quantity"),
    [
        (None, "speed"),
        ("  ", "speed"),
        ("rad/s", "speed"),
        ("km/h", "angular_rate"),
        ("m/s", "acceleration"),
        ("Mg", "acceleration"),
        ("%", "angle"),
        ("%", "torque"),
        ("kN", "speed"),
        ("[kN]", "speed"),
        ("(kN)", "speed"),
        ("furlong", "length"),
    ],
)
def test_what_is_no_unit_of_a_quantity(text, quantity):
    assert find_unit(text, quantity) is None


def test_every_signal_has_a_unit_and_its_own_text_reads_back():
    for spec in SIGNALS.values():
        text = SI_TEXT[spec.quantity]
        if text != "–":
            unit = find_unit(text, spec.quantity)
            assert unit is not None
            assert (unit.scale, unit.offset) == (1.0, 0.0), spec.name


def test_every_spelling_reads_back_however_it_is_written():
    for quantity, words in spellings().items():
        assert len(set(words)) == len(words)
        for word in words:
            plain = find_unit(word, quantity)
            assert plain is not None, word
            for written in (f" {word} ", f"[{word}]", f"({word})"):
                found = find_unit(written, quantity)
                assert found is not None
                assert found.scale == plain.scale, written


def test_quantities_and_the_error_with_its_hint():
    assert quantities_of("deg") == {"angle", "geographic_angle", "slope"}
    assert quantities_of("") == quantities_of(None) == frozenset()
    with pytest.raises(
        MappingError, match=r"\[signals.roll\]: unit 'km/h' is no unit of angle; use one of rad, deg"
    ):
        require_unit("km/h", "angle", place="[signals.roll]")


@given(st.text(max_size=20), st.sampled_from(sorted(SI_TEXT)))
def test_any_text_is_a_finite_unit_or_none(text, quantity):
    unit = find_unit(text, quantity)
    assert unit is None or (math.isfinite(unit.scale) and unit.scale > 0)


@pytest.mark.parametrize(
    ("text", "quantity", "scale"),
    [
        ("ft·lbf", "torque", 1.3558179483),
        ("lbs-ft", "torque", 1.3558179483),
        ("in-lb", "torque", 0.1129848290),
        ("daNm", "torque", 10.0),
        ("Ncm", "torque", 0.01),
        ("psia", "pressure", 6894.757293),
        ("lbf/in²", "pressure", 6894.757293),
        ("kgf/cm2", "pressure", 98066.5),
        ("bar(g)", "pressure", 1e5),
        ("N/m^2", "pressure", 1.0),
        ("turns", "angle", 2 * math.pi),
        ("gon", "angle", math.pi / 200),
        ("degrees per second", "angular_rate", math.pi / 180),
        ("miles per hour", "speed", 0.44704),
        ("kilometres per hour", "speed", 1 / 3.6),
        ("meters/second", "speed", 1.0),
        ("G's", "acceleration", 9.80665),
        ("Meters per second squared", "acceleration", 1.0),
        ("metre/second²", "acceleration", 1.0),
        ("mm/sec2", "acceleration", 0.001),
        ("thou", "length", 2.54e-5),
        ("°N", "geographic_angle", 1.0),
    ],
)
def test_units_written_out_and_of_other_countries(text, quantity, scale):
    unit = find_unit(text, quantity)
    assert unit is not None
    assert unit.scale == pytest.approx(scale, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "quantity", "scale"),
    [
        ("m/sÂ²", "acceleration", 1.0),
        ("m/s\ufffd", "acceleration", 1.0),
        ("[m/s?]", "acceleration", 1.0),
        ("mm/s?", "acceleration", 0.001),
        ("Â°/s", "angular_rate", math.pi / 180),
        ("?/s", "angular_rate", math.pi / 180),
        ("\ufffd/s", "angular_rate", math.pi / 180),
        ("Â°", "angle", math.pi / 180),
        ("\ufffd", "angle", math.pi / 180),
        ("m/s?", "speed", None),
        ("km/h?", "speed", None),
        ("?", "angle", None),  # which is as often written where there is no unit
        ("?/s", "speed", None),
    ],
)
def test_units_that_another_encoding_broke(text: str, quantity: str, scale: float | None) -> None:
    unit = find_unit(text, quantity)
    assert (unit.scale if unit else None) == (scale if scale is None else pytest.approx(scale))
