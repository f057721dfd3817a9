"""A vehicle file without a mass: what a mass scales is told only by logs that tell the mass."""

from __future__ import annotations

from collections.abc import Mapping

from pipelines.results import ParameterEstimate

SCALED = ("_kg", "_nmprad", "_nmsprad", "_kgm2", "_nspm")
"""Endings of parameters that go with the mass."""

GIVE_MASS = "the vehicle's mass is not known: give mass_kg (and body) in a vehicle file"


def without_mass(parameters: Mapping[str, ParameterEstimate]) -> dict[str, ParameterEstimate]:
    """The answers of a drive whose vehicle file has no mass: where the log tells none either, stiffness, damping and inertia would be those of
    the mass that any vehicle may have, and are not told."""
    mass = parameters.get("mass_kg")
    if mass is None or mass.status != "not_identifiable":
        return dict(parameters)
    return {
        name: ParameterEstimate(
            name, None, None, None, None, "not_identifiable", GIVE_MASS, None, entry.reference, ()
        )
        if name.endswith(SCALED)
        else entry
        for name, entry in parameters.items()
    }
