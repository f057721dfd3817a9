"""The mirror solution: h and I/(m h) give the same roll motion, which a real posterior must hold and say."""

from __future__ import annotations

import re

import numpy as np
import plant_roll as plant
import pytest

from pipelines.estimators.roll_map.estimator import RollMap
from pipelines.estimators.roll_map.height import plain, two_peaks, vehicle_answers
from pipelines.estimators.roll_map.posterior import Posterior
from pipelines.models.roll import RollCoefficients, height_sensitivity, mirror_height, suspension_of
from pipelines.results import Estimate, Prior
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


def test_two_heights_are_never_identified() -> None:
    """However narrow they are against the prior."""
    rng = np.random.default_rng(5)
    heights = np.concatenate((rng.normal(0.5, 0.01, 10_000), rng.normal(0.7, 0.01, 10_000)))
    values = dict.fromkeys(
        (
            "cg_height_m",
            "sprung_cg_height_m",
            "roll_arm_m",
            "roll_inertia_kgm2",
            "mass_kg",
            "sprung_mass_kg",
            "roll_stiffness_nmprad",
            "roll_damping_nmsprad",
            "mirror",
        ),
        heights,
    )
    flat = np.full(len(heights), 1 / len(heights))
    prior = {"cg_height_m": Prior(0.6, 1.0, "test")}
    found = vehicle_answers(Posterior(values, flat, 1e4), prior, True, True, (True, True), {})
    height = found["cg_height_m"]
    assert height.status == "weak"
    assert "two heights fit" in height.reason
    assert height.low is not None
    assert height.high is not None
    assert height.low < 0.5 < 0.7 < height.high
    one = {name: rng.normal(0.6, 0.01, len(heights)) for name in values}
    again = vehicle_answers(Posterior(one, flat, 1e4), prior, True, True, (True, True), {})
    assert again["cg_height_m"].status == "identified"


@pytest.mark.parametrize("height", [0.74, 0.60])
def test_the_mirror_has_the_same_motion(height: float) -> None:
    """Berntorp's model: h and I/(m h), with K and D in proportion, give the same a, b, c; both come back from them."""
    mass, inertia, stiffness, damping = 1800.0, 500.0, 65e3, 5.5e3
    other = mirror_height(height, mass, inertia)
    scale = other / height
    real, image = (
        RollCoefficients(k / (mass * h), d / (mass * h), inertia / (mass * h) + h)
        for k, d, h in ((stiffness, damping, height), (scale * stiffness, scale * damping, other))
    )
    assert (image.a, image.b, image.c) == pytest.approx((real.a, real.b, real.c), rel=1e-12)
    assert suspension_of(real, mass, inertia) == pytest.approx((stiffness, damping, height), rel=1e-9)
    lower = suspension_of(real, mass, inertia, upper=False)
    assert lower == pytest.approx((scale * stiffness, scale * damping, other), rel=1e-9)
    flat = np.sqrt(inertia / mass)
    assert height_sensitivity(float(flat), mass, inertia) == pytest.approx(0.0, abs=1e-12)
    assert height_sensitivity(height, mass, inertia) > 0 > height_sensitivity(other, mass, inertia)
    # less than any height gives: the flat line's height is the nearest
    assert suspension_of(RollCoefficients(50.0, 4.0, 1.9 * float(flat)), mass, inertia)[2] < 1.01 * flat
