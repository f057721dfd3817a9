"""The mirror solution: h and I/(m h) give the same roll motion, which a real posterior must hold and say."""

from __future__ import annotations

import re

import numpy as np
import plant_roll as plant
import pytest

from pipelines.estimators.roll_map.estimator import RollMap
from pipelines.estimators.roll_map.height import plain, two_peaks
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Vehicle

TALL = plant.Car(
    sprung_height=1.05,
    roll_axis=0.05,
    body_inertia=490.0,
    stiffness=150_000.0,
    damping=9_000.0,
    imu_height=1.05,
)
"""Arm 1.0 m where sqrt(I/m) is 0.55 m: the mirror's arm is 0.30 m."""


def _estimate(car: plant.Car, know: plant.Knowledge, body: str) -> Estimate:
    rng = np.random.default_rng(4)
    motion = plant.simulate(car, plant.sine_with_dwell(5.0, 4))
    quiet = plant.Sensors(accel_noise=0.01, roll_noise=1e-4, rate_noise=5e-4)
    drive = plant.without(plant.record(motion, car, quiet, rng), "suspension")
    vehicle = plant.vehicle_of(car, know, rng)
    vehicle = Vehicle("mirror", body, vehicle.quantities, vehicle.load, vehicle.sensors, vehicle.reference)
    estimator = RollMap()
    prepared = estimator.prepare(drive, {})
    return estimator.estimate(prepared, vehicle, {}, np.random.default_rng(1))


def test_two_heights_are_said_and_held() -> None:
    """Mass and inertia known well, the stiffness not at all, the height hardly."""
    know = plant.Knowledge(
        mass=0.005, stiffness=None, inertia=0.01, roll_axis=0.005, imu=0.005, height=(0.75, 0.35)
    )
    found = _estimate(TALL, know, "SUV").parameters["cg_height_m"]
    mirror_arm = TALL.body_inertia / (TALL.sprung_kg * TALL.arm)
    sprung = TALL.roll_axis + mirror_arm
    mirror = (TALL.sprung_kg * sprung + TALL.unsprung_kg * TALL.hub_height) / TALL.mass
    assert mirror < 0.6 * TALL.cg_height
    if found.low is None or found.high is None:
        pytest.fail("the interval is missing")
    said = re.search(r"two heights fit, ([0-9.]+) m and ([0-9.]+) m", found.reason)
    assert said is not None
    lower, upper = (float(text) for text in said.groups())
    assert lower == pytest.approx(mirror, abs=0.12)
    assert upper == pytest.approx(TALL.cg_height, abs=0.12)
    assert found.low < lower < upper < found.high
    assert found.low < TALL.cg_height < found.high
    assert found.status != "identified"


def test_near_the_mirror_line_the_inertia_term_cannot_help() -> None:
    """A car's arm is near sqrt(I/m): there c hardly changes with h, which is said."""
    know = plant.Knowledge(mass=0.005, stiffness=None, inertia=0.01, roll_axis=0.005, imu=0.005)
    found = _estimate(plant.Car(), know, "SUV").parameters["cg_height_m"]
    assert "mirror image fits as well" in found.reason
    assert found.low is not None
    assert found.high is not None
    assert found.low < plant.Car().cg_height < found.high


def test_peaks_of_known_densities() -> None:
    rng = np.random.default_rng(2)
    one = rng.normal(0.6, 0.05, 20_000)
    two = np.concatenate((rng.normal(0.4, 0.04, 10_000), rng.normal(0.9, 0.04, 10_000)))
    flat = np.full(20_000, 1 / 20_000)
    assert two_peaks(one, flat) is None
    peaks = two_peaks(two, flat)
    assert peaks is not None
    assert peaks == pytest.approx((0.4, 0.9), abs=0.04)


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (95950, 1900, "95 950 ± 1 900"),
        (0.56781, 0.0123, "0.5678 ± 0.012"),
        (-1234567, 45000, "-1 234 600 ± 45 000"),
        (748.2, 0.0, "748.2"),
    ],
)
def test_figures_in_sentences(value: float, std: float, text: str) -> None:
    assert plain(value, std) == text
