"""A single method's masses and places against what the vehicle file says: forces in another unit, a wheel that is missing, or a digit too many
make a vehicle that is none, and a method that looks at its own equations alone calls it identified."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pipelines.results import Estimate, ParameterEstimate
from pipelines.vehicles.mass_limits import LEAST_SPRUNG, loaded_limits
from pipelines.vehicles.vehicle import Vehicle

SURELY = 4.0
"""Standard deviations of the answer by which it must lie beyond what the file allows."""

LEAST_CORNER, MOST_CORNER = 0.06, 0.48
"""Share of the vehicle's mass on one wheel, of what stands on four."""

NO_MASS = ("natural_frequency", "damping_ratio", "gradient", "radius")
"""How names go on of what no scale of the forces enters."""


def _contradictions(estimate: Estimate, vehicle: Vehicle) -> Iterator[str]:
    limits, length = loaded_limits(vehicle), vehicle.get("wheelbase_m")
    for name, p in estimate.parameters.items():
        if p.value is None or p.std is None or p.status == "not_identifiable":
            continue
        low, high = p.value - SURELY * p.std, p.value + SURELY * p.std
        if limits is not None and name in ("mass_kg", "sprung_mass_kg"):
            least = limits[0] if name == "mass_kg" else LEAST_SPRUNG * limits[0]
            if high < least or low > limits[1]:
                yield f"{name} {p.value:.0f} kg"
        elif limits is not None and name.startswith("corner_mass_"):
            if high < LEAST_CORNER * limits[0] or low > MOST_CORNER * limits[1]:
                yield f"{name} {p.value:.0f} kg"
        elif name == "cg_to_front_axle_m" and length is not None and (high < 0 or low > length.value):
            yield f"{name} {p.value:.2f} m"


def _doubted(p: ParameterEstimate, words: str) -> ParameterEstimate:
    if p.status == "not_identifiable" or any(word in p.name for word in NO_MASS):
        return p
    return replace(p, status="weak", refused=words, reason=words + p.reason)


def held_against(estimate: Estimate, vehicle: Vehicle) -> Estimate:
    """The estimate; none of it identified that a scale of the forces goes into where its mass or place is that of no such vehicle."""
    said = list(_contradictions(estimate, vehicle))
    if not said:
        return estimate
    stated = vehicle.get("mass_kg")
    beside = f" for an empty mass of {stated.value:.0f} kg in the vehicle file" if stated else ""
    words = (
        f"{', '.join(said[:2])}{beside}: no load makes that; forces in another unit (kgf, kN), a wheel or an axle that is missing, "
        "or a wrong figure in the vehicle file; "
    )
    return replace(estimate, parameters={name: _doubted(p, words) for name, p in estimate.parameters.items()})
