"""Loads as a user writes them: "120@x=1.6,y=0,z=1.75", or a mass at a place by name ("roof:120")."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Mapping

from parsers.errors import SettingsError
from pipelines.simulation.loads import Load
from pipelines.simulation.plant.vehicle import PlantVehicle

_MOST_KG = 30_000
_EXAMPLE = "write MASS@x=BEHIND_FRONT_AXLE,y=LEFT,z=ABOVE_GROUND or PLACE:MASS, e.g. 120@x=1.6,y=0,z=1.75 or roof:120"
_PERSON_KG = 75.0
_ROOF_M = {
    "Sedan": 1.45, "Hatchback": 1.47, "Wagon": 1.48, "SUV": 1.72, "Minivan": 1.74, "Pickup": 1.80, "Van": 2.20,
    "Truck": 3.00,
}  # fmt: skip
"""Height of the roof above ground by body; another body takes that of an SUV."""


def _number(text: str, spec: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SettingsError(
            f"load {spec!r}: found {text!r}, expected a number", hint=_EXAMPLE, wrong_usage=True
        )
    return value


def _roof(vehicle: PlantVehicle, mass_kg: float) -> list[Load]:
    height = 0.25
    above = _ROOF_M.get(vehicle.body, _ROOF_M["SUV"]) + height / 2
    return [Load(mass_kg, 0.52 * vehicle.wheelbase_m, 0.0, above, 1.2, 1.0, height)]


def _rear(vehicle: PlantVehicle, mass_kg: float) -> list[Load]:
    return [Load(mass_kg, 0.95 * vehicle.wheelbase_m, 0.0, vehicle.wheel_radius_rear_m + 0.45, 0.7, 1.0, 0.4)]


def _side(vehicle: PlantVehicle, mass_kg: float) -> list[Load]:
    left = 0.25 * vehicle.track_rear_m
    return [Load(mass_kg, 0.62 * vehicle.wheelbase_m, left, vehicle.wheel_radius_rear_m + 0.4, 0.8, 0.4, 0.5)]


def _seats(vehicle: PlantVehicle, mass_kg: float) -> list[Load]:
    """The driver first, then beside, then behind; what four people would not weigh is shared among them."""
    places = [(0.48, 0.37), (0.48, -0.37), (0.80, 0.37), (0.80, -0.37)]
    above = vehicle.wheel_radius_front_m + 0.42
    each = max(_PERSON_KG, mass_kg / len(places))
    loads = []
    for share, left in places:
        person = min(each, mass_kg)
        if person <= 0:
            break
        loads.append(Load(person, share * vehicle.wheelbase_m, left, above, 0.5, 0.45, 0.9))
        mass_kg -= person
    return loads


PLACES: Mapping[str, tuple[str, Callable[[PlantVehicle, float], list[Load]]]] = {
    "roof": ("on the roof, in its middle", _roof),
    "rear": ("on the floor above the rear axle", _rear),
    "side": ("on the floor, a quarter of the track left of the middle", _side),
    "seats": ("people: the driver first, 75 kg each", _seats),
}
"""Places by name: a line on each, and what puts a mass there."""


def parse_load(spec: str, vehicle: PlantVehicle) -> list[Load]:
    """Read one load. Raises SettingsError naming what was found and how to write it."""
    name, colon, mass = spec.partition(":")
    if colon:
        if name not in PLACES:
            near = difflib.get_close_matches(name, PLACES, n=1, cutoff=0.5)
            raise SettingsError(
                f"load {spec!r}: there is no place {name!r}",
                hint=f"did you mean {near[0]!r}?" if near else f"known are {', '.join(PLACES)}",
                wrong_usage=True,
            )
        kilograms = _number(mass, spec)
        _check_mass(kilograms, spec)
        return PLACES[name][1](vehicle, kilograms)
    found = re.fullmatch(r"([^@]+)@\s*x\s*=([^,]+),\s*y\s*=([^,]+),\s*z\s*=([^,]+)", spec)
    if not found:
        raise SettingsError(f"load {spec!r} cannot be read", hint=_EXAMPLE, wrong_usage=True)
    kilograms, behind, left, above = (_number(text, spec) for text in found.groups())
    _check_mass(kilograms, spec)
    if not -2 <= behind <= vehicle.wheelbase_m + 2:
        raise SettingsError(
            f"load {spec!r}: x is {behind:g} m, the wheelbase {vehicle.wheelbase_m:g} m",
            hint=_EXAMPLE,
            wrong_usage=True,
        )
    if abs(left) > vehicle.track_rear_m or not 0 <= above <= 5:
        raise SettingsError(f"load {spec!r} lies outside the vehicle", hint=_EXAMPLE, wrong_usage=True)
    return [Load(kilograms, behind, left, above)]


def _check_mass(mass_kg: float, spec: str) -> None:
    if not 0 < mass_kg <= _MOST_KG:
        text = f"load {spec!r}: found {mass_kg:g} kg, expected more than 0 and at most {_MOST_KG}"
        raise SettingsError(text, hint=_EXAMPLE, wrong_usage=True)
