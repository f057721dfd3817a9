"""The studies' vehicle files: a measured vehicle's figures are off by what they say, and by no more."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.vehicle_data import ABSOLUTE_M, FARTHEST, RELATIVE, curves, measured, paths, upright
from pipelines.simulation.loads import truth
from pipelines.simulation.logs.vehicle import data_sheet, sheet_values
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.simulation.sensors.sets import DEFAULT_MOUNT
from pipelines.vehicles.kinematics import spring_curve
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

PLANT = replace(PRESETS["suv"], sprung_cg_left_m=0.01)
TRUE = sheet_values(PLANT) | {k: truth(PLANT, ())[k] for k in ("cg_height_m", "cg_lateral_offset_m")}
TRUE["camber_compensation"] = upright(PLANT)


def sheet(seed: int = 1) -> Vehicle:
    return parse_vehicle(data_sheet(PLANT, DEFAULT_MOUNT, np.random.default_rng(seed)), Path("vehicle.toml"))


def test_figures_are_off_by_their_stated_spreads() -> None:
    draws = [measured(sheet(), PLANT, np.random.default_rng(seed)) for seed in range(200)]
    for key in (*RELATIVE, *ABSOLUTE_M):
        z = np.array([(v.quantities[key].value - TRUE[key]) / v.quantities[key].std for v in draws])
        assert 0.8 < np.sqrt(np.mean(z**2)) < 1.2, key
        assert np.abs(z).max() <= FARTHEST + 1e-9


def test_without_errors_the_figures_are_the_truth_and_say_how_sure_they_would_be() -> None:
    told = measured(sheet(), PLANT, np.random.default_rng(0), errors=0.0).quantities
    assert told["mass_kg"].value == pytest.approx(TRUE["mass_kg"])
    assert told["mass_kg"].std == pytest.approx(0.0025 * TRUE["mass_kg"])
    assert told["cg_lateral_offset_m"].value == pytest.approx(TRUE["cg_lateral_offset_m"])
    assert told["cg_lateral_offset_m"].value > 0.005


def test_what_no_rig_measures_stays_as_the_data_sheet_has_it() -> None:
    before, after = sheet().quantities, measured(sheet(), PLANT, np.random.default_rng(3)).quantities
    curves_told = {*curves(PLANT, after), *paths(PLANT), "tire_lateral_rate_npm"}
    assert set(after) - set(before) == {
        "cg_height_m",
        "cg_lateral_offset_m",
        "camber_compensation",
        *curves_told,
    }
    for key in ("drag_area_m2", "brake_gain_nmppa", "roll_inertia_kgm2", "damper_rate_front_nspm"):
        assert after[key] == before[key]
    assert all(after[key].std < before[key].std for key in ("mass_kg", "roll_center_height_rear_m"))


def test_the_rig_s_curves_are_those_of_the_springs_whose_rates_it_found() -> None:
    told = measured(sheet(), PLANT, np.random.default_rng(0), errors=0.0).quantities
    found = spring_curve(told, "rear")
    assert found is not None
    (square, _), (cube, _) = found
    # the plant's force: k d (1 + s d²)
    assert square == pytest.approx(0.0, abs=1e-6)
    assert cube == pytest.approx(told["spring_rate_rear_npm"].value * PLANT.spring_stiffening_pm2)
    assert told["bump_stop_clearance_front_m"].value == PLANT.bump_clearance_m
