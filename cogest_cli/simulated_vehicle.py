"""The vehicle of `cogest simulate --vehicle FILE`: the plant's, and in words what it has not from the file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from parsers.errors import VehicleError

if TYPE_CHECKING:
    from pipelines.simulation.plant.vehicle import PlantVehicle
    from pipelines.vehicles.vehicle import Vehicle


def vehicle_of_file(path: Path) -> tuple[PlantVehicle, Sequence[str]]:
    """The vehicle that a file describes, and sentences on what is not the file's. Raises VehicleError."""
    from pipelines.simulation.logs.vehicle import plant_vehicle
    from pipelines.vehicles.vehicle_file import read_vehicle

    stated = read_vehicle(path)
    made = plant_vehicle(stated)
    return made, [*_of_preset(stated), *_not_taken(stated, made)]


def _of_preset(stated: Vehicle) -> list[str]:
    """Where no preset has the file's body, what stands in for it."""
    from pipelines.simulation.plant.vehicle import PRESETS

    if any(preset.body == stated.body for preset in PRESETS.values()):
        return []
    name = next(iter(PRESETS))
    which = f"no preset is a {stated.body}" if stated.body else "the vehicle file names no body"
    return [f"{which}: what it does not state is that of `{name}`"]


def _not_taken(stated: Vehicle, made: PlantVehicle) -> list[str]:
    """Figures of the file without effect: the plant has parts of its own in their place."""
    vain = sorted(key for key in stated.quantities if not _counts(stated, key, made))
    if not vain:
        return []
    hint = ": its springs and bars make its own" if vain == ["roll_stiffness_nmprad"] else ""
    return [f"the simulated vehicle does not take the file's {', '.join(vain)}{hint}"]


def _counts(stated: Vehicle, key: str, made: PlantVehicle) -> bool:
    """Whether another value of a figure makes another vehicle, or none."""
    from pipelines.simulation.logs.vehicle import plant_vehicle

    quantity = stated.quantities[key]
    other = replace(quantity, value=quantity.value * 1.001 + 1e-6)
    try:
        return plant_vehicle(replace(stated, quantities={**stated.quantities, key: other})) != made
    except VehicleError:
        return True
