"""Vehicles' knowledge made by hand, for the tests of tables and of outlying vehicles."""

from __future__ import annotations

from collections.abc import Mapping

from pipelines.hierarchy.records import LoadChange, Trend, VehicleKnowledge, VehicleParameter
from pipelines.results import Identification, ParameterEstimate, Prior

UNITS = {"roll_stiffness_nmprad": ("Roll stiffness", "N·m/rad"), "empty_mass_kg": ("Empty mass", "kg")}


def estimate(
    name: str, value: float | None, std: float | None, *, prior: tuple[float, float] | None = None,
    status: Identification = "identified", reference: float | None = None,
) -> ParameterEstimate:  # fmt: skip
    """An answer with a normal interval."""
    low, high = (None, None) if value is None or std is None else (value - 1.96 * std, value + 1.96 * std)
    known = None if prior is None else Prior(*prior, "vehicle file")
    return ParameterEstimate(name, value, std, low, high, status, "by hand", known, reference, ("prior",))


def knowledge(
    vehicle_id: str,
    vehicle: Mapping[str, ParameterEstimate],
    drives: Mapping[str, Mapping[str, ParameterEstimate]] | None = None,
    changes: tuple[LoadChange, ...] = (),
    found: tuple[Trend, ...] = (),
) -> VehicleKnowledge:
    """A vehicle."""
    parameters = {
        name: VehicleParameter(e, *UNITS.get(name, (name, "")), None, 3) for name, e in vehicle.items()
    }
    return VehicleKnowledge(vehicle_id, parameters, drives or {}, changes, found)
