"""Static stability factor, threshold, and the drive's peak: worked by hand."""

from __future__ import annotations

import numpy as np
import plant_roll as plant
import pytest

from pipelines.results import ParameterEstimate
from pipelines.rollover import assess_rollover
from pipelines.vehicles.vehicle import Quantity, Vehicle

TRACK = {
    "track_front_m": Quantity(1.58, 0.005, "vehicle file"),
    "track_rear_m": Quantity(1.60, 0.005, "vehicle file"),
}
HEIGHT = ParameterEstimate("cg_height_m", 0.66, 0.02, 0.62, 0.70, "identified", "", None, None, ("roll_map",))
GRADIENT = ParameterEstimate("roll_gradient_degpg", 9.0, 0.1, 8.8, 9.2, "identified", "")


@pytest.fixture(scope="module")
def scene() -> tuple[plant.Drive, plant.Array]:
    car = plant.Car()
    motion = plant.simulate(car, plant.slalom(5.0, seconds=20))
    # the sensor's own point of the body moves a little more than the road: gravity's part is what must go
    level = (motion["accel_y"] - plant.G * np.sin(motion["roll"])) / np.cos(motion["roll"])
    return plant.record(motion, car, plant.Sensors(), np.random.default_rng(1)), level


def test_known_answer(scene: tuple[plant.Drive, plant.Array]) -> None:
    drive, road = scene
    found = assess_rollover(
        {"cg_height_m": HEIGHT, "roll_gradient_degpg": GRADIENT}, Vehicle(quantities=TRACK), drive
    )
    factor, threshold = found.static_stability_factor, found.threshold_g
    assert factor is not None
    assert threshold is not None
    assert factor.value == pytest.approx(1.59 / (2 * 0.66), rel=2e-3)
    assert factor.low == pytest.approx(1.59 / (2 * 0.70), rel=5e-3)
    assert factor.high == pytest.approx(1.59 / (2 * 0.62), rel=5e-3)
    sensed = np.radians(9.0)
    lean = 1 + sensed / (1 - sensed) * (1 - 0.08 / 0.66)
    assert threshold.value == pytest.approx(1.59 / (2 * 0.66) / lean, rel=3e-3)
    assert found.peak_lateral_acceleration_g == pytest.approx(np.abs(road).max() / 9.80665, rel=0.03)
    assert found.peak_rollover_coefficient == pytest.approx(
        found.peak_lateral_acceleration_g / factor.value
        if factor.value and found.peak_lateral_acceleration_g
        else 0
    )
    assert found.peak_time_s == pytest.approx(np.argmax(np.abs(road)) / plant.RATE, abs=0.15)
    assert "without gravity's part" in found.notes[-1]


def test_without_roll_the_sensed_value_is_said(scene: tuple[plant.Drive, plant.Array]) -> None:
    drive, road = scene
    bare = plant.without(drive, "roll", "suspension")
    found = assess_rollover({"cg_height_m": HEIGHT}, Vehicle(quantities=TRACK), bare)
    assert found.peak_lateral_acceleration_g is not None
    assert found.peak_lateral_acceleration_g > np.abs(road).max() / 9.80665 * 1.05
    assert "sensed" in found.notes[-1]
    assert found.threshold_g is not None
    assert found.static_stability_factor is not None
    assert found.threshold_g.value == found.static_stability_factor.value


def test_what_is_missing_is_said(scene: tuple[plant.Drive, plant.Array]) -> None:
    drive, _ = scene
    none = ParameterEstimate("cg_height_m", None, None, None, None, "not_identifiable", "")
    found = assess_rollover({"cg_height_m": none}, Vehicle(quantities=TRACK), drive)
    assert found.static_stability_factor is None
    assert found.peak_rollover_coefficient is None
    assert found.peak_lateral_acceleration_g is not None
    assert "CG height is not known" in found.notes[0]
    found = assess_rollover({"cg_height_m": HEIGHT}, Vehicle(), plant.without(drive, "accel"))
    assert "no track width" in found.notes[0]
    assert found.peak_lateral_acceleration_g is None
    assert "no peak" in found.notes[-1]
