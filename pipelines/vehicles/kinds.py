"""What kind of vehicle a file describes, and what such vehicles carry where nobody says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pipelines.vehicles.measured import known_body
from pipelines.vehicles.vehicle import Vehicle

Kind = Literal["car", "carrier", "heavy"]

CARRIERS = frozenset(("Van", "Pickup"))
CARRIER_WORDS = ("motorhome", "camper", "ambulance", "delivery", "boxvan")
HEAVY_WORDS = ("truck", "lorry", "bus", "coach", "tractor", "tipper")
HEAVY_KG = 3500.0
"""Empty mass from which on a van, a pickup or a vehicle whose body nobody names is a lorry. What is called a passenger car stays one: an
SUV of 3.8 t is a wrong mass, and a lorry's load would hide it."""
LONG_M, LONG_KG = 3.3, 1800.0
"""Wheelbase and empty mass from which on a vehicle whose body nobody names carries goods, or many people."""

DRIVER = (75.0, 15.0)
"""kg."""

LOAD_SPREAD, LOAD_SPREAD_STD = (0.05, 0.06), (0.02, 0.045)
"""A load's own inertia about its own CG over its mass, in roll over the track squared and in pitch over the wheelbase squared, and how
sure that is: in a car a metre wide. Along, a driver alone has 0.01, persons in two rows 0.03, two in front and as much in the boot 0.1
or more."""


@dataclass(frozen=True)
class UsualLoad:
    """kg. mean, std: all that is carried, as a normal law. further, most: what is beside the driver, mean of an exponential law and
    its end."""

    mean: float
    std: float
    further: float
    most: float


def kind_of(vehicle: Vehicle) -> Kind:
    """By the body's name, else by mass and wheelbase."""
    mass, length = vehicle.get("mass_kg"), vehicle.get("wheelbase_m")
    style, text = known_body(vehicle.body), "".join(c for c in (vehicle.body or "").casefold() if c.isalpha())
    kilos = 0.0 if mass is None else mass.value
    if style is not None and style not in CARRIERS:
        return "car"
    if kilos >= HEAVY_KG or (style is None and any(word in text for word in HEAVY_WORDS)):
        return "heavy"
    if style is not None:
        return "carrier"
    long = length is not None and length.value >= LONG_M and kilos >= LONG_KG
    return "carrier" if long or any(word in text for word in CARRIER_WORDS) else "car"


def usual_load(vehicle: Vehicle, kilos: float) -> UsualLoad:
    """kilos: the empty mass. Cars are driven with a third of what they may carry, vans and lorries empty or full, which is more
    than half of their own mass, or more than all of it."""
    kind = kind_of(vehicle)
    if kind == "heavy":
        return UsualLoad(0.35 * kilos, 0.45 * kilos, 0.3 * kilos, 1.5 * kilos)
    if kind == "carrier":
        return UsualLoad(0.17 * kilos, 0.22 * kilos, 0.15 * kilos, 0.8 * kilos)
    return UsualLoad(0.10 * kilos, 0.12 * kilos, 130.0, 400.0)
