"""Figures as an engineer reads them: angles in degrees, speeds in km/h."""

from __future__ import annotations

import math

from parsers.signals import SIGNALS

_SHOWN: dict[str, tuple[float, str]] = {
    "angle": (180 / math.pi, "°"),
    "slope": (180 / math.pi, "°"),
    "angular_rate": (180 / math.pi, " °/s"),
    "speed": (3.6, " km/h"),
    "acceleration": (1.0, " m/s²"),
    "geographic_angle": (1.0, "°"),
    "length": (1.0, " m"),
    "pressure": (1e-5, " bar"),
    "force": (1.0, " N"),
    "torque": (1.0, " N·m"),
}

_LONG = 1e9


def show(signal: str, value: float) -> str:
    """A signal's SI value as text, with unit, three significant figures or whole numbers of up to nine digits (damage holds any)."""
    factor, unit = _SHOWN.get(SIGNALS[signal].quantity, (1.0, ""))
    shown = value * factor
    text = f"{shown:.0f}" if 100 <= abs(shown) < _LONG else f"{shown:.3g}"
    return text + unit


def times(count: int, what: str) -> str:
    """1 sample, 2 samples."""
    return f"{count} {what}{'' if count == 1 else 's'}"
