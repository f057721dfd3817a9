"""Presets that give as real vehicles do: roll centres that come down with the body, loads that go along with their patches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.simulation.plant.vehicle import PlantVehicle

DROP_FRONT, DROP_REAR, PATCH = (0.5, 1.6), (0.4, 1.2), (0.1, 0.7)
"""Ranges, as random vehicles have them: of a roll centre, over what the body goes down; of a patch's way across, what the load goes along."""


def giving(vehicle: PlantVehicle, seed: int) -> PlantVehicle:
    """The vehicle with drawn figures of these; roll centres of rigid axles stay. Draws nothing from a study's own stream."""
    rng = np.random.default_rng([20261128, seed])
    front, rear, patch = (float(rng.uniform(*bounds)) for bounds in (DROP_FRONT, DROP_REAR, PATCH))
    return replace(
        vehicle,
        roll_center_drop_front=0.0 if vehicle.camber_compensation_front >= 1 else front,
        roll_center_drop_rear=0.0 if vehicle.camber_compensation_rear >= 1 else rear,
        patch_give=patch,
    )
