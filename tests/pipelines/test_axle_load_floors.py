"""What weighing cannot be surer of: rolling resistance beside the CG's place, gravity, and how much the loads themselves scatter."""

from __future__ import annotations

import numpy as np
import plant_axle_load as plant
import pytest

from pipelines.estimators.axle_load_gls.estimator import AxleLoadGls
from pipelines.estimators.gpc_bayesian_map.estimator import DEFAULTS, GpcBayesianMap
from pipelines.estimators.hekf_ekf.estimator import HekfEkf
from pipelines.models.axle_load import mean_error
from pipelines.vehicles.vehicle import Vehicle

BOTH = ("axle_load_rear", "axle_load_front", "accel_x", "speed")
LORRY = plant.Lorry(gain=0.0, spin=0.0, rolling=0.03)
NOTHING = {
    "load_scale_std": 0.0,
    "load_offset_std": 0.0,
    "force_scale_std": 0.0,
    "model_std": 0.0,
    "accel_offset_std": 0.0,
}


def file_of(rolling: float) -> Vehicle:
    """rolling: resistance times radius, m; the radius is 0.52."""
    return plant.vehicle(LORRY, rolling_resistance=rolling / 0.52)


def test_rolling_resistance_is_not_taken_for_a_cg_further_back() -> None:
    method, settings = GpcBayesianMap("axle_load"), {**DEFAULTS, "model_error_scale": 0.0}
    drive = plant.record(LORRY, plant.motion(hill=0.0), plant.Sensors(accel=0.02), BOTH)
    found = method.estimate(
        method.prepare(drive, settings), file_of(0.03), settings, np.random.default_rng(0)
    )
    for name, true in (
        ("cg_to_front_axle_m", LORRY.axle),
        ("mass_kg", LORRY.mass),
        ("cg_height_m", LORRY.height),
    ):
        entry = found.parameters[name]
        assert entry.value is not None
        assert entry.std is not None
        assert abs(entry.value - true) < 2.5 * entry.std, name
    place = found.parameters["cg_to_front_axle_m"]
    assert place.value == pytest.approx(LORRY.axle, abs=0.012)
    # a zero of 0.05 m/s² in the accelerometer reads as 5 mm of place
    assert place.std is not None
    assert place.std > 0.004


def test_no_allowance_leaves_a_mass_that_is_known_to_nought() -> None:
    for method in (AxleLoadGls(), HekfEkf()):
        drive = plant.record(LORRY, plant.motion(), plant.Sensors(), BOTH)
        settings = {k: v for k, v in NOTHING.items() if k in {s.name for s in method.settings}}
        found = method.estimate(
            method.prepare(drive, settings), file_of(0.03), settings, np.random.default_rng(0)
        )
        for name, entry in found.parameters.items():
            assert entry.std is None or entry.std > 0, (method.name, name)
    drive = plant.record(LORRY, plant.motion(), plant.Sensors(), BOTH)
    method = AxleLoadGls()
    mass = method.estimate(
        method.prepare(drive, NOTHING), file_of(0.03), NOTHING, np.random.default_rng(0)
    ).parameters["mass_kg"]
    assert mass.low is not None
    assert mass.high is not None
    # gravity differs by as much from place to place
    assert mass.high - mass.low > 2 * 1.96 * 0.0009 * LORRY.mass
    assert mass.low < LORRY.mass < mass.high


def test_the_error_of_a_mean_is_by_stretches_and_never_nought_of_what_scatters() -> None:
    rng = np.random.default_rng(0)
    slow = np.repeat(rng.normal(0, 1, 100), 50)
    assert mean_error(slow, 10.0) == pytest.approx(1 / np.sqrt(100), rel=0.3)
    assert mean_error(slow[:60], 10.0) == pytest.approx(float(np.std(slow[:60])))
