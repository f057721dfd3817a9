"""The vehicles of the full plant: the record and the presets."""

from __future__ import annotations

from pipelines.simulation.plant.body import Corners, PlantVehicle
from pipelines.simulation.plant.presets import PRESETS

__all__ = ["PRESETS", "Corners", "PlantVehicle"]
