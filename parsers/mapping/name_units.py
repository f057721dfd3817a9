"""Units that are glued to a name's end: "accel_y_mps2", "speedKmh"."""

from __future__ import annotations

import re
from collections.abc import Iterator

_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
# ways in which a unit is glued to a name: "accel_y_mps2"
_SUFFIX_UNITS = {
    "mps2": "m/s2", "ms2": "m/s2", "m_s2": "m/s2", "radps": "rad/s", "rads": "rad/s", "rad_s": "rad/s",
    "degps": "deg/s", "dps": "deg/s", "deg_s": "deg/s", "degs": "deg/s", "mps": "m/s", "m_s": "m/s", "kmh": "km/h",
    "kph": "km/h", "km_h": "km/h", "mph": "mph", "kn": "kn", "kts": "kn", "deg": "deg", "rad": "rad",
    "degp_sec": "deg/s", "degp_s": "deg/s", "radp_sec": "rad/s", "radp_s": "rad/s", "mp_s2": "m/s2", "mp_sec2": "m/s2",
    "mp_s": "m/s", "mp_sec": "m/s", "kmp_h": "km/h", "bar": "bar", "kpa": "kPa",
    "mpa": "MPa", "pa": "Pa", "mm": "mm", "m": "m", "n": "N", "dan": "daN", "kgf": "kgf", "lbf": "lbf", "kg": "kg", "nm": "Nm", "g": "g",
    "km_per_h": "km/h", "km_per_hour": "km/h", "m_per_s": "m/s", "m_per_sec": "m/s", "m_per_s2": "m/s2", "m_per_s_2": "m/s2",
    "m_per_s^2": "m/s2", "m_per_sec2": "m/s2", "deg_per_s": "deg/s", "deg_per_sec": "deg/s", "rad_per_s": "rad/s", "rad_per_sec": "rad/s",
    "knots": "kn", "knot": "kn", "kmph": "km/h", "psi": "psi", "cm": "cm", "lbft": "lb·ft", "ftlb": "lb·ft", "pct": "%", "percent": "%",
}  # fmt: skip


def without_suffix(name: str) -> Iterator[tuple[str, str | None]]:
    """A name as it stands, then without each unit that may be its end, and that unit."""
    yield name, None
    pieces = name.rstrip().split("_") if "_" in name else name.split()
    if len(pieces) == 1:
        # "yawRateDegPerSec", "speedKmh", "accelYMps2"
        pieces = _CAMEL.sub(" ", name.replace("Per", "p")).split()
    for count in (4, 3, 2, 1):
        ending = "_".join(pieces[-count:])
        # a kilonewton is no knot: this unit alone needs its capital letter
        unit = ending if ending == "kN" else _SUFFIX_UNITS.get(ending.lower())
        if unit is not None and len(pieces) > count:
            yield "_".join(pieces[:-count]), unit
