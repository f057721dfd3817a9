"""Units of channels: what a log's unit text means, and its factor to SI. Impossible conversions are refused."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from parsers.errors import MappingError

STANDARD_GRAVITY = 9.80665
"""m/s²: the definition of the unit g."""


@dataclass(frozen=True)
class Unit:
    """SI value = value * scale + offset, for one quantity.

    rise: that is a rise over run, and its angle (rad) is the SI value: a road's slope in per cent.

    quantity "angle" and "geographic_angle" share texts; wheel speeds in rad/s need a wheel radius, so an
    "angular_rate" is never taken for a "speed".
    """

    text: str
    quantity: str
    scale: float
    offset: float = 0.0
    rise: bool = False


_DEG = math.pi / 180
_RPM = 2 * math.pi / 60

_FOOT_POUND = 1.3558179483314004
_FOOT_POUNDS = (
    " ".join(
        f"{one}{mark}{other}"
        for pound in ("lb", "lbf", "lbs")
        for one, other in (("ft", pound), (pound, "ft"))
        for mark in ("", "*", "·", ".", "-")
    )
    + " foot-pound foot-pounds footpounds pound-foot pound-feet poundfeet"
)
"""N·m, and its spellings."""

# quantity -> {scale to SI: spellings}; spellings are compared after `_plain`
_SPELLINGS: dict[str, list[tuple[float, str]]] = {
    "acceleration": [
        (
            1.0,
            "m/s2 m/s^2 m/s/s mps2 m/sec2 m/sec^2 m*s-2 m·s-2 ms-2 m.s-2 meter/s2 metre/s2 mpss m/ss meters/s2 metres/s2",
        ),
        (STANDARD_GRAVITY, "g gn g0 gs g's 'g' gforce g-force g_force"),
        (STANDARD_GRAVITY / 1000, "mg milli-g"),
        (0.01, "cm/s2 cm/s^2 gal"),
        (0.001, "mm/s2 mm/s^2 mm/sec2 mm/sec^2"),
        (0.3048, "ft/s2 ft/s^2 ft/sec2 ft/sec^2"),
    ],
    "angular_rate": [
        (
            1.0,
            "rad/s rad/sec radps rads rad*s-1 rad.s-1 1/s rad/second radian/s radians/s radians/second radians/sec",
        ),
        (
            _DEG,
            "deg/s deg/sec degps °/s °/sec deg/second degree/s degrees/s degree/sec degrees/sec degree/second degrees/second "
            "degs/s degs/sec dps º/s ˚/s grad/s",
        ),
        (_DEG / 1000, "mdeg/s mdps"),
        (_DEG / 60, "deg/min °/min"),
        (0.001, "mrad/s"),
        (60 * _RPM, "rev/s revs/s rps"),
        (_RPM, "rpm 1/min r/min u/min min-1 rev/min revs/min"),
        (_DEG / 100, "0.01deg/s"),
    ],
    "angle": [
        (1.0, "rad radian radians"),
        (_DEG, "deg ° degree degrees degs º ˚ grad"),
        (0.001, "mrad"),
        (_DEG / 1000, "mdeg millideg millidegree millidegrees"),
        (_DEG / 60, "arcmin '"),
        (_DEG / 3600, "arcsec"),
        (2 * math.pi, "turn turns rev revs revolution revolutions"),
        (math.pi / 200, "gon gons gradian gradians"),
    ],
    "slope": [],
    "geographic_angle": [
        (1.0, "deg ° degree degrees º ˚ degn °n degreesn degreesnorth dege °e degreese degreeseast"),
        (1 / _DEG, "rad radian radians"),
        (1 / 60, "min minute minutes arcmin '"),
        (1e-7, "1e-7deg deg*1e-7 1e-7° dege7"),
    ],
    "speed": [
        (
            1.0,
            "m/s mps m/sec m/second ms-1 m*s-1 m.s-1 meter/s metre/s meters/s metres/s meters/sec meters/second metres/second",
        ),
        (
            1 / 3.6,
            "km/h kmh kph kmph km/hr kmperhour km/hour kilometers/hour kilometres/hour kilometer/hour kilometre/hour",
        ),
        (0.44704, "mph mi/h mi/hr mile/h miles/h miles/hr mile/hour miles/hour"),
        (1852 / 3600, "kn knot knots kt kts kns"),
        (0.3048, "ft/s ft/sec fps feet/s feet/second"),
        (0.01, "cm/s"),
        (0.001, "mm/s"),
    ],
    "length": [
        (1.0, "m meter metre meters metres mtr mmsl m(msl) mamsl"),
        (0.001, "mm"),
        (0.01, "cm"),
        (1000.0, "km"),
        (0.0254, 'in inch inches "'),
        (0.3048, "ft feet foot"),
        (1e-6, "um µm μm"),
        (2.54e-5, "thou mil mils"),
    ],
    "force": [
        (1.0, "n newton newtons"),
        (1000.0, "kn"),
        (10.0, "dan"),
        (STANDARD_GRAVITY, "kgf kg kp"),
        (STANDARD_GRAVITY * 1000, "t tonne"),
        (4.4482216152605, "lbf lb lbs"),
    ],
    "torque": [
        (1.0, "nm n*m n.m n·m n-m newtonmeter"),
        (1000.0, "knm kn*m kn·m"),
        (10.0, "danm dan*m dan·m"),
        (0.01, "ncm n*cm n·cm"),
        (0.001, "nmm n*mm n·mm"),
        (STANDARD_GRAVITY, "kgfm kgf*m kgf·m kgf-m kgm kg*m kg·m kpm kp*m"),
        (_FOOT_POUND, _FOOT_POUNDS),
        (
            _FOOT_POUND / 12,
            _FOOT_POUNDS.replace("foot", "inch").replace("feet", "inches").replace("ft", "in"),
        ),
    ],
    "pressure": [
        (1.0, "pa pascal n/m2"),
        (100.0, "hpa mbar"),
        (1000.0, "kpa"),
        (1e6, "mpa n/mm2 n/mm^2"),
        (1e5, "bar bars barg bara bar(g) bar(a) barabs dan/cm2 dan/cm^2"),
        (6894.757293168361, "psi psig psia lbf/in2 lbf/in^2 lb/in2 lb/in^2 lbs/in2 lbf/sqin"),
        (STANDARD_GRAVITY * 1e4, "kgf/cm2 kgf/cm^2 kg/cm2 kg/cm^2 kp/cm2 kp/cm^2"),
        (101_325.0, "atm"),
        (101_325.0 / 760, "mmhg torr"),
    ],
    "mass": [(1.0, "kg"), (1000.0, "t"), (0.45359237, "lb lbs")],
    "time": [
        (1.0, "s sec secs second seconds"),
        (1e-3, "ms msec millisecond milliseconds"),
        (1e-6, "us µs μs usec microsecond microseconds"),
        (1e-9, "ns nsec nanosecond nanoseconds"),
        (60.0, "min minute minutes"),
        (3600.0, "h hr hour hours"),
    ],
    "ratio": [(1.0, "- 1 none ratio"), (0.01, "% percent")],
    "count": [(1.0, "- 1 none # sats")],
}

_SPELLINGS["slope"] = [*_SPELLINGS["angle"], (0.01, "% percent pct")]
_RISES = frozenset({"%", "percent", "pct"})
"""Of a slope: rise over run."""

SI_TEXT: dict[str, str] = {
    "acceleration": "m/s²",
    "angular_rate": "rad/s",
    "angle": "rad",
    "slope": "rad",
    "geographic_angle": "°",
    "speed": "m/s",
    "length": "m",
    "force": "N",
    "torque": "N·m",
    "pressure": "Pa",
    "mass": "kg",
    "time": "s",
    "ratio": "–",
    "count": "–",
}
"""How a quantity's unit inside cogest is printed."""

# Spellings where upper and lower case differ in meaning are looked up before folding.
_CASED: dict[tuple[str, str], float] = {
    ("pressure", "MPa"): 1e6,
    ("pressure", "mPa"): 1e-3,
    ("force", "kN"): 1000.0,
    ("force", "kn"): 1000.0,
    ("speed", "kN"): math.nan,
    ("acceleration", "Mg"): math.nan,
}


_READ_AS_LATIN = re.compile("\N{LATIN CAPITAL LETTER A WITH CIRCUMFLEX}(?=[²³¹°µ·])")
_LOST_POWER = re.compile(r"(?i)^((?:[mc]?m|ft)/s(?:ec)?)[?\ufffd\xbf]$")
_LOST_DEGREE = re.compile(r"(?i)^[?\ufffd\xbf](?=/s(?:ec)?$)")


def _mended(text: str) -> str:
    """A unit whose ² or ° got lost on its way through another encoding: "m/sÂ²", "m/s?", "?/s".

    Nothing but ² stands behind a length per second, and nothing but ° alone before "/s", in units of a vehicle's log.
    """
    if text.isascii() and "?" not in text:
        return text
    text = _READ_AS_LATIN.sub("", text)
    return _LOST_DEGREE.sub("°", _LOST_POWER.sub(r"\1²", text))


def _plain(text: str) -> str:
    """Fold the ways in which loggers write the same unit."""
    text = _mended(text.strip().strip("[]()").strip())
    text = (
        text.replace("²", "2")
        .replace("¹", "1")
        .replace("⁻", "-")
        .replace("**", "^")
        .replace("\N{REPLACEMENT CHARACTER}", "°")
    )
    text = re.sub(r"\s*/\s*", "/", text)
    text = re.sub(r"\bper\b", "/", text).replace(" / ", "/")
    text = re.sub(r"\s+", "", text).lower().replace("squared", "2").replace("^2", "2")
    text = re.sub(r"/(?:seconds?|sec)(?=2?$)", "/s", text)
    # "m s-2", "rad*s^-1" and the like
    return re.sub(r"[*·.]?s\^?-([12])$", lambda power: "/s2" if power[1] == "2" else "/s", text)


_LOOKUP: dict[tuple[str, str], float] = {
    (quantity, _plain(word)): scale
    for quantity, rows in _SPELLINGS.items()
    for scale, words in rows
    for word in words.split()
}


_TICKS = re.compile(r"(0*[1-9]\d{0,5}(?:\.\d{1,6})?|0\.0*[1-9]\d{0,5})\s*([^\d\s.]\S*)")
"""A counter's step: "10 ms"."""


def find_unit(text: str | None, quantity: str) -> Unit | None:
    """The unit that `text` means for a quantity, or None where the text is empty or means nothing there."""
    if text is None or not text.strip():
        return None
    if quantity == "time" and (ticks := _TICKS.fullmatch(text.strip().strip("[]()").strip())):
        each = find_unit(ticks[2], quantity)
        return None if each is None else Unit(text.strip(), quantity, float(ticks[1]) * each.scale)
    cased = _CASED.get((quantity, text.strip().strip("[]()").strip()))
    scale = cased if cased is not None else _LOOKUP.get((quantity, _plain(text)))
    if scale is None or math.isnan(scale):
        return None
    return Unit(text.strip(), quantity, scale, rise=quantity == "slope" and _plain(text) in _RISES)


def spellings() -> dict[str, list[str]]:
    """Quantity -> the unit texts that are understood for it."""
    return {
        quantity: [word for _, words in rows for word in words.split()]
        for quantity, rows in _SPELLINGS.items()
    }


def quantities_of(text: str | None) -> frozenset[str]:
    """All quantities for which a unit text has a meaning."""
    if text is None or not text.strip():
        return frozenset()
    return frozenset(quantity for quantity in _SPELLINGS if find_unit(text, quantity) is not None)


def require_unit(text: str, quantity: str, *, place: str) -> Unit:
    """Like `find_unit`, but raises MappingError with the spellings that would have been understood."""
    unit = find_unit(text, quantity)
    if unit is None:
        known = ", ".join(words.split()[0] for _, words in _SPELLINGS[quantity])
        raise MappingError(
            f"unit {text!r} is no unit of {quantity.replace('_', ' ')}",
            place=place,
            hint=f"use one of {known}",
        )
    return unit
