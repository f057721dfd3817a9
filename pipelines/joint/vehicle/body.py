"""The body that the unknowns make: the empty vehicle of the vehicle file plus a load of unknown mass at an unknown place.

So mass, CG place and height stay consistent whatever the relations teach.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipelines.joint.vehicle.remembered import once
from pipelines.models.roll import GRAVITY

TYRE_SHARE = 1.15
"""Sag of the body over that of its springs: the tyres give as well, by about a seventh."""

BRAKED_FRONT = 0.65
"""Share of the front axle in braking: about its share of the load meanwhile."""

SOFTEST = 20.0
"""Spring rate over the mass on it that no vehicle is below, 1/s²: 0.7 Hz."""

Values = Mapping[str, float]
"""The unknowns by name, SI."""


@dataclass(frozen=True)
class Body:
    """The loaded vehicle. Lengths m: x behind the front axle, y left, h above ground; sprung and whole."""

    sprung: float
    unsprung: float
    x: float
    y: float
    h: float
    mass: float
    whole_x: float
    whole_y: float
    whole_h: float

    @property
    def moment(self) -> float:
        """m h of the whole vehicle, kg m: what load transfer sees."""
        return self.mass * self.whole_h


def carrying(p: Values, axle: str) -> Any:
    """Rate of a spring that carries a load, N/m, one vehicle's or many's.

    Where the file has no rates some vehicles of a search or of draws have next to none, or less, and would sink without end.
    """
    return np.maximum(p[f"spring_{axle}"], 0.25 * SOFTEST * p["empty_mass"])


@once
def body_of(p: Values, sag: float | None) -> Body:
    """Put empty vehicle and load together.

    sag: how much lower the loaded body stands than the empty one, m; None: not measured, so what springs and tyres give.
    """
    if sag is None:
        sag = TYRE_SHARE * GRAVITY * p["load"] / (2 * (carrying(p, "front") + carrying(p, "rear")))
    unsprung = p["unsprung_front"] + p["unsprung_rear"]
    empty = p["empty_mass"] - unsprung
    sprung = empty + p["load"]
    length, hub = p["wheelbase"], hub_height(p)
    x = (p["empty_mass"] * p["empty_x"] - p["unsprung_rear"] * length + p["load"] * p["load_x"]) / sprung
    y = (p["empty_mass"] * p["empty_y"] + p["load"] * p["load_y"]) / sprung
    rest = p["empty_mass"] * p["empty_h"] - unsprung * hub
    h = (rest + p["load"] * p["load_h"]) / sprung - sag
    mass = sprung + unsprung
    return Body(
        sprung, unsprung, x, y, h, mass,
        (sprung * x + p["unsprung_rear"] * length) / mass,
        sprung * y / mass,
        (sprung * h + unsprung * hub) / mass,
    )  # fmt: skip


def hub_height(p: Mapping[str, Any]) -> Any:
    """Of the empty vehicle's wheel centres above ground, m: below the radius on which the wheels roll, as tyres are squashed."""
    return p["radius"] - p["hub_low"]


def empty_corner(p: Values, axle: str) -> float:
    """The suspension's force at a wheel of the empty vehicle at rest, N."""
    share = p["empty_x"] / p["wheelbase"]
    part = 1 - share if axle == "front" else share
    return 0.5 * GRAVITY * (p["empty_mass"] * part - p[f"unsprung_{axle}"])


def held_rate(p: Values, axle: str) -> float:
    """N/m by which each standing tyre of an axle holds its wheel where it is: going up, it would go sideways by its roll centre's height."""
    side: float = 2 * p[f"roll_center_{axle}"] / p[f"track_{axle}"]
    return p[f"standing_{axle}"] * side * side


def even_factor(scale: Any) -> Any:
    """A scale error about 1, a number or an array, as a factor that is as far up for more as it is down for less.

    A scale that divides another unknown and is normal itself pulls that by its variance: masses by several torques 0.2 % low.
    """
    return np.exp(scale - 1)


def body_inertias(p: Values) -> tuple[float, float]:
    """Roll and pitch inertia of the loaded sprung body about its own CG, kg m².

    From those of the empty whole vehicle (what data sheets and the measured vehicles tell): less the wheels and what the
    body's CG is away from the whole's, plus what the load brings by its distance.
    """
    unsprung = p["unsprung_front"] + p["unsprung_rear"]
    empty = p["empty_mass"] - unsprung
    hub, length = hub_height(p), p["wheelbase"]
    x = (p["empty_mass"] * p["empty_x"] - p["unsprung_rear"] * length) / empty
    y = p["empty_mass"] * p["empty_y"] / empty
    h = (p["empty_mass"] * p["empty_h"] - unsprung * hub) / empty
    low = (hub - p["empty_h"]) ** 2
    wheels_roll = p["unsprung_front"] * (0.25 * p["track_front"] ** 2 + low)
    wheels_roll = wheels_roll + p["unsprung_rear"] * (0.25 * p["track_rear"] ** 2 + low)
    wheels_pitch = p["unsprung_front"] * (p["empty_x"] ** 2 + low)
    wheels_pitch = wheels_pitch + p["unsprung_rear"] * ((length - p["empty_x"]) ** 2 + low)
    lifted = empty * (h - p["empty_h"]) ** 2
    reduced = empty * p["load"] / (empty + p["load"])
    above = (p["load_h"] - h) ** 2
    roll = p["roll_inertia"] - wheels_roll - lifted + reduced * (above + (p["load_y"] - y) ** 2)
    pitch = p["pitch_inertia"] - wheels_pitch - lifted - empty * (x - p["empty_x"]) ** 2
    pitch = pitch + reduced * (above + (p["load_x"] - x) ** 2)
    wide, long = p["load_wide"] * p["track_front"] ** 2, p["load_long"] * length**2
    return roll + wide * p["load"], pitch + long * p["load"]
