"""A fitted-out vehicle's training drive, another one, and its map: made once for all tests of the mapping."""

from __future__ import annotations

import pytest
from wheel_force_drives import Made, make

from pipelines.simulation.loads import Load
from pipelines.suspension_mapping.record import SuspensionMap
from pipelines.suspension_mapping.train import train, training_drive


@pytest.fixture(scope="session")
def training() -> Made:
    return make("handling_track", (Load(75.0, 1.3, 0.37, 0.8),), 1, 80.0)


@pytest.fixture(scope="session")
def other() -> Made:
    return make("urban", (Load(75.0, 1.3, 0.37, 0.8), Load(250.0, 2.3, -0.3, 1.1)), 2, 60.0)


@pytest.fixture(scope="session")
def suspension_map(training: Made) -> SuspensionMap:
    return train([training_drive(training.drive, "training.csv")], training.vehicle, "suv (simulated)")
