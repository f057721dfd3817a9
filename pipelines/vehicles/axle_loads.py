"""What an axle load's sensor feels: what the tyres carry, or what the springs do, to which the links' part never comes."""

from __future__ import annotations

from pipelines.results import Assumption
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.vehicle import Vehicle

BY_SPRINGS = {"car": 0.03, "carrier": 0.3, "heavy": 0.5}
"""Chance that it is the springs (bellows' pressure, strain of leaf springs) where the vehicle file is silent: what lorries, buses and vans
send on their buses is that; of cars an axle load comes from wheel force transducers, scales or a simulation."""


def by_springs(vehicle: Vehicle) -> float:
    """Chance that axle loads are what the springs carry: stated (`axle_load_by`), else by the kind of vehicle."""
    if vehicle.axle_load_by is not None:
        return float(vehicle.axle_load_by == "springs")
    return BY_SPRINGS[kind_of(vehicle)]


def carried_in_words(share: float, vehicle: Vehicle) -> list[Assumption]:
    """What axle loads are taken for, for the report; nothing where none are used. share: of the load that was used."""
    if share == 0.0:
        return []
    if vehicle.axle_load_by is not None:
        return [Assumption("axle loads show", f"what the {vehicle.axle_load_by} carry", "vehicle file")]
    chance = by_springs(vehicle)
    text = f"what the tyres carry, or at {chance:.0%} what the springs do, which lacks what the links carry (axle_load_by)"
    return [Assumption("axle loads show", text, "the vehicle file is silent: usual of such vehicles")]
