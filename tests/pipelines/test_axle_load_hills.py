"""Hills that nobody measured, few rows, and two forms that differ: the height from axle loads and a speed says what it may be wrong by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import plant_axle_load as plant

from pipelines.estimators.axle_load_gls.estimator import AxleLoadGls
from pipelines.estimators.axle_load_gls.fit import few_rows
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Quantity

ESTIMATOR = AxleLoadGls()
LORRY = plant.Lorry()


def driven(seed: int, seconds: float, slope: float) -> plant.Motion:
    """A drive over hills of the given rms slope, which hang together over some 8 s of it."""
    moved = plant.motion(seconds)
    rng = np.random.default_rng(seed)
    kernel = np.exp(-0.5 * (np.arange(-2400, 2401) / 800) ** 2)
    hills = np.convolve(rng.standard_normal(len(moved.time) + 4800), kernel, "valid")
    hills *= slope / max(float(np.std(hills)), 1e-9)
    return replace(moved, grade=hills)


def height(seed: int, seconds: float, slope: float) -> ParameterEstimate:
    names = ("axle_load_rear", "speed")
    drive = plant.record(LORRY, driven(seed, seconds, slope), plant.Sensors(), names, seed)
    found = ESTIMATOR.estimate(
        ESTIMATOR.prepare(drive, {}), plant.vehicle(LORRY), {}, np.random.default_rng(seed)
    )
    return found.parameters["cg_height_m"]


def test_hills_taken_as_flat_are_in_the_interval() -> None:
    told = [height(seed, 45.0, 0.04) for seed in range(12)]
    heights = [h for h in told if h.status != "not_identifiable"]
    assert len(heights) >= 6
    away = [abs(h.value - 1.03) / h.std for h in heights if h.value is not None and h.std is not None]
    assert max(away) < 2.6
    assert float(np.sqrt(np.mean(np.square(away)))) < 1.3


def test_a_road_taken_as_flat_is_less_sure_than_one_whose_slope_was_measured() -> None:
    moved = driven(0, 40.0, 0.0)
    spreads = []
    for names in (("axle_load_rear", "speed"), ("axle_load_rear", "speed", "road_grade")):
        drive = plant.record(LORRY, moved, plant.Sensors(), names, 0)
        found = ESTIMATOR.estimate(
            ESTIMATOR.prepare(drive, {}), plant.vehicle(LORRY), {}, np.random.default_rng(0)
        )
        spreads.append(found.diagnostics["moment_mh_std_kgm"] / found.diagnostics["moment_mh_kgm"])
    # 0.02 g of hills over 1 m/s² of force, some five hills in the drive
    assert spreads[0] > np.hypot(spreads[1], 0.01)


def test_a_flat_road_still_tells_the_height() -> None:
    found = height(0, 120.0, 0.0)
    assert found.status == "identified"
    assert found.value is not None
    assert abs(found.value - 1.03) < 0.06


def test_seconds_of_driving_are_weak_at_most() -> None:
    assert all(height(seed, 8.0, 0.0).status != "identified" for seed in range(3))


def test_few_rows_have_students_interval() -> None:
    # 2.776 / 1.960 with four degrees of freedom
    assert abs(few_rows(8) - 2.006) < 0.01
    assert few_rows(10_000) < 1.001


def test_a_height_that_the_file_knows_better_is_weak() -> None:
    drive = plant.record(
        LORRY, driven(0, 120.0, 0.0), plant.Sensors(), ("axle_load_rear", "accel_x", "speed"), 0
    )
    prepared = ESTIMATOR.prepare(drive, {})
    told = {}
    for std in (0.02, 0.2):
        known = plant.vehicle(LORRY)
        stated = Quantity(1.03, std, "vehicle file")
        known = replace(known, quantities={**known.quantities, "cg_height_m": stated})
        told[std] = ESTIMATOR.estimate(prepared, known, {}, np.random.default_rng(0)).parameters[
            "cg_height_m"
        ]
    assert told[0.2].status == "identified"
    assert told[0.02].status == "weak"
    assert "what the vehicle file says" in told[0.02].reason
