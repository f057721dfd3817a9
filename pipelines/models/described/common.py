"""Priors that several models share."""

from __future__ import annotations

from pipelines.bayes.priors import Known, Normal, Uniform
from pipelines.vehicles.vehicle import Quantity, Vehicle


def about(name: str, quantity: Quantity, low: float, high: float, at_least: float = 0.0) -> Known:
    """A vehicle quantity as a normal prior, its spread at least `at_least` of its value, within what the model allows.

    A quantity outside of that gives an even prior over all of it.
    """
    spread = max(quantity.std, at_least * abs(quantity.value), 1e-9 * abs(quantity.value), 1e-12)
    if not low < quantity.value < high:
        return Known(name, Uniform(low, high), low > 0, "anything that the model can be run at")
    return Known(name, Normal(quantity.value, spread, low, high), low > 0, quantity.source)


def usual(name: str, low: float, high: float, why: str, log: bool = True) -> Known:
    """An even prior."""
    return Known(name, Uniform(low, high), log, why)


def sprung_share(vehicle: Vehicle) -> float:
    """Sprung mass over mass of the empty vehicle."""
    mass = vehicle.get("mass_kg")
    hubs = [vehicle.get(f"unsprung_mass_{axle}_kg") for axle in ("front", "rear")]
    if mass is None:
        return 0.9
    return 1.0 - sum(0.05 * mass.value if q is None else q.value for q in hubs) / mass.value
