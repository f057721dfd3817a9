"""What the mass of a loaded vehicle may be, by the empty one that the vehicle file states."""

from __future__ import annotations

from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.vehicle import Vehicle

MOST_LOAD = {"car": 0.6, "carrier": 1.2, "heavy": 3.0}
"""Load over the empty mass beyond which none is: half as much again as what is registered (27 to 40 % of cars, twice a lorry's own)."""

LIGHTER = 0.9
"""Of the stated mass: below it is no vehicle of that kind, with an empty tank and nobody in it."""

LEAST_SPRUNG = 0.75
"""Share of the mass that stands on springs and struts: hubs, wheels and axles are a quarter at the most."""

SURELY = 4.0
"""Standard deviations of the stated mass by which it must lie beyond."""


def loaded_limits(vehicle: Vehicle) -> tuple[float, float] | None:
    """Least and most mass, kg; None where the file states none."""
    stated = vehicle.get("mass_kg")
    if stated is None:
        return None
    off = SURELY * stated.std
    return max(LIGHTER * stated.value - off, 0.0), (1 + MOST_LOAD[kind_of(vehicle)]) * stated.value + off
