"""Column headers: what is the name and what the unit. "AY [g]", "ay (m/s^2)", "speed_kmh", "Time[s]"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from parsers.signals import COLUMNS
from parsers.unit_words import is_unit, plain_unit
from parsers.units import SI_TEXT


@dataclass(frozen=True)
class ColumnName:
    """A column's header. header: as it stands in the file. name: without a unit in brackets. unit: or None."""

    header: str
    name: str
    unit: str | None = None


# "yaw_rate_degps": endings that are a unit. Single letters only where they are common and hardly end a word.
_ENDINGS: dict[str, str] = {
    "mps2": "m/s²",
    "ms2": "m/s²",
    "m/s2": "m/s²",
    "m/s^2": "m/s²",
    "m_s2": "m/s²",
    "g": "g",
    "radps": "rad/s",
    "rad/s": "rad/s",
    "rads": "rad/s",
    "rad_s": "rad/s",
    "degps": "deg/s",
    "dps": "deg/s",
    "deg/s": "deg/s",
    "degs": "deg/s",
    "deg_s": "deg/s",
    "rad": "rad",
    "deg": "deg",
    "kmh": "km/h",
    "kph": "km/h",
    "kmph": "km/h",
    "km/h": "km/h",
    "km_h": "km/h",
    "mph": "mph",
    "mps": "m/s",
    "m/s": "m/s",
    "m_s": "m/s",
    "knots": "knots",
    "kts": "knots",
    "rpm": "rpm",
    "mm": "mm",
    "cm": "cm",
    "m": "m",
    "nm": "N·m",
    "kn": "kn",
    "dan": "daN",
    "kgf": "kgf",
    "lbf": "lbf",
    "bar": "bar",
    "kpa": "kPa",
    "mpa": "MPa",
    "psi": "psi",
    "km_per_h": "km/h",
    "km_per_hour": "km/h",
    "m_per_s": "m/s",
    "m_per_sec": "m/s",
    "m_per_s2": "m/s²",
    "m_per_s_2": "m/s²",
    "m_per_s^2": "m/s²",
    "m_per_sec2": "m/s²",
    "deg_per_s": "deg/s",
    "deg_per_sec": "deg/s",
    "rad_per_s": "rad/s",
    "rad_per_sec": "rad/s",
    "lbft": "lb·ft",
    "ftlb": "ft·lb",
    "pct": "%",
    "percent": "%",
    "ns": "ns",
    "nsec": "ns",
    "us": "us",
    "usec": "us",
    "ms": "ms",
    "msec": "ms",
    "s": "s",
    "sec": "s",
    "seconds": "s",
}
_BRACKETS = re.compile(
    r"^(?P<name>.*?)\s*(?:\[(?P<a>[^\[\]]*)\]|\((?P<b>[^()]*)\)|\{(?P<c>[^{}]*)\}|<(?P<d>[^<>]*)>)\s*$"
)
_INDEX = re.compile(r"\S\[1\]$")
"""Of "gyro[1]", beside which gyro[0] and gyro[2] stand: a place, while "Slip [1]" has a unit."""

_AFTER_MARK = re.compile(r"^(?P<name>.*\S)\s*(?:,|\s/|\sin)\s+(?P<unit>\S+)$")
_AFTER_BLANK = re.compile(r"^(?P<name>.*[^\s/,])\s+(?P<unit>\S+)$")
_AFTER_SLASH = re.compile(r"^(?P<name>[^/.]*[^/.\s])/\(?(?P<unit>[^()]+)\)?$")
_DIVISORS = frozenset((
    "g", "°", "deg", "rad", "mm", "cm", "m", "N", "kN", "Nm", "bar", "kPa", "MPa", "Pa", "%", "m/s", "km/h", "m/s2", "m/s²",
    "m/s^2", "°/s", "deg/s", "rad/s", "1/min",
))  # fmt: skip
"""Units that may stand behind a slash without blanks: others could be a path's part ("cell/v")."""
_PLAIN_WORDS = frozenset(("kmh", "kph", "mph", "rpm", "deg", "mm", "cm", "kpa", "mpa", "psi", "nm", "kn"))
"""Units that stand after a blank and can hardly be a word of a name ("roll bar" and "Vorderrad" hold such); others have a sign in them."""
_TIME_UNITS = frozenset(("s", "sec", "ms", "us", "µs", "ns"))
_TIME_WORDS = re.compile(r"(time|stamp|^t|zeit|sec|elapsed|duration|dt)", re.IGNORECASE)


def split_header(header: str) -> ColumnName:
    """Split a column header into name and unit.

    A unit in brackets, after a comma, " / " or " in ", after a blank alone ("Speed km/h") or a slash alone ("a_x/g") leaves the name ("AY [g]" -> "AY", "g").
    A unit as an ending stays part of it ("speed_kmh" -> "speed_kmh", "km/h"), as in the canonical columns.
    """
    header = header.strip()
    spec = COLUMNS.get(header)
    if spec is not None:
        si = "deg" if spec.quantity == "geographic_angle" else SI_TEXT[spec.quantity]
        return ColumnName(header, header, si.replace("–", "-"))
    match = _AFTER_SLASH.match(header)
    if match is not None and _is_divided(match["name"], match["unit"]):
        return ColumnName(header, match["name"], plain_unit(match["unit"]))
    match = _BRACKETS.match(header)
    if match is not None and match["name"]:
        unit = next(part for part in (match["a"], match["b"], match["c"], match["d"]) if part is not None)
        if is_unit(unit) and not _INDEX.search(header):
            return ColumnName(header, match["name"], plain_unit(unit))
    match = _AFTER_MARK.match(header)
    if match is not None and is_unit(match["unit"]):
        return ColumnName(header, match["name"], plain_unit(match["unit"]))
    match = _AFTER_BLANK.match(header)
    if match is not None and _stands_alone(match["name"], match["unit"]):
        return ColumnName(header, match["name"], plain_unit(match["unit"]))
    return ColumnName(header, header, unit_ending(header))


def _is_divided(name: str, unit: str) -> bool:
    """Whether a name is divided by its unit, as standards write a table's head: "t/ms", "a_x/g", "v/(km/h)"; no path is."""
    if unit.lower() in _TIME_UNITS:
        return _TIME_WORDS.search(name) is not None
    return unit in _DIVISORS


def _stands_alone(name: str, unit: str) -> bool:
    """Whether a word behind a blank is a unit: "Speed km/h", "YawRate deg/s", "Time s"."""
    if unit.lower() in _TIME_UNITS:
        return _TIME_WORDS.search(name) is not None
    signs = any(sign in unit for sign in "/²") and not unit.startswith("/")
    return (signs or unit.lower() in _PLAIN_WORDS) and is_unit(unit)


def split_unit(name: str) -> tuple[str, str | None]:
    """A name without what stands behind it where units do, and that: "Speed (km/h)", "Speed, km/h" -> ("Speed", "km/h")."""
    header = split_header(name)
    if header.name != header.header:
        return header.name, header.unit
    found = re.fullmatch(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*", name.strip())
    if found and found.group(1) and not found.group(2).strip().isdigit():
        return found.group(1), found.group(2).strip() or None
    return name.strip(), None


def unit_ending(name: str) -> str | None:
    """The unit at the end of a name, after an underscore: "YawRate_deg/s" -> "deg/s"."""
    lower = name.lower()
    for parts in (4, 3, 2, 1):
        pieces = lower.rsplit("_", parts)
        if len(pieces) != parts + 1 or not pieces[0]:
            continue
        ending = "_".join(pieces[1:])
        unit = _ENDINGS.get(ending)
        if unit == "kn" and name.endswith("kN"):
            return "kN"
        if unit is not None and not (unit == "s" and not _TIME_WORDS.search(pieces[0])):
            return unit
    return None


def unique_names(names: Sequence[ColumnName]) -> tuple[tuple[ColumnName, ...], tuple[str, ...]]:
    """Give repeated names a number (name, name_2 …) and nameless columns a name; also the names that were repeated."""
    used = {column.name for column in names}
    seen: set[str] = set()
    repeated: list[str] = []
    result = []
    for place, column in enumerate(names, start=1):
        name = column.name or f"column_{place}"
        if name in seen or (not column.name and name in used):
            if column.name and column.name not in repeated:
                repeated.append(column.name)
            number = 2
            while f"{name}_{number}" in seen or f"{name}_{number}" in used:
                number += 1
            name = f"{name}_{number}"
        seen.add(name)
        result.append(ColumnName(column.header, name, column.unit))
    return tuple(result), tuple(repeated)
