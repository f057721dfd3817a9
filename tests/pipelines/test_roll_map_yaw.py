"""What yaw acceleration does to roll, as a distance, and what stays open of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipelines.estimators.roll_map.yaw import yaw_lever
from pipelines.vehicles.priors import measured_product
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

PRODUCT = measured_product(None)[0]


def _vehicle(rear_centre: float, imu: float = 1.2) -> Vehicle:
    return parse_vehicle(
        "[vehicle]\nmass_kg = 1500\nwheelbase_m = 2.7\ncg_to_front_axle_m = 1.35\ncg_height_m = 0.55\n"
        f"roll_center_height_front_m = 0.05\nroll_center_height_rear_m = {rear_centre}\n"
        f"[sensors]\nimu_behind_front_axle_m = {imu}\n",
        Path("vehicle.toml"),
    )


def test_lever_of_a_level_roll_axis_is_the_place_less_the_product() -> None:
    lever = yaw_lever(_vehicle(0.05))
    assert lever is not None
    assert lever[0] == pytest.approx(1.35 - 1.2 - 1.35**2 * PRODUCT / 0.5)


def test_lever_of_a_roll_axis_that_rises_to_the_rear_follows_from_the_moments() -> None:
    """Forces ± I_zz r'/L at roll centres 0.05 and 0.15 m above ground, about a CG 0.55 m up, over m h."""
    lever, level = yaw_lever(_vehicle(0.15)), yaw_lever(_vehicle(0.05))
    assert lever is not None
    assert level is not None
    mass, yaw_inertia = 1500.0, 1500.0 * 1.35**2
    pushed = yaw_inertia / 2.7
    moment = pushed * (0.55 - 0.05) - pushed * (0.55 - 0.15) + PRODUCT * yaw_inertia
    arm = 0.55 - 0.10
    assert lever[0] == pytest.approx(0.15 - moment / (mass * arm))
    assert lever[0] < level[0]


def test_lever_needs_the_accelerometers_place_and_bears_a_file_without_roll_centres() -> None:
    bare = parse_vehicle("[vehicle]\nmass_kg = 1500\n", Path("vehicle.toml"))
    placed = parse_vehicle(
        "[vehicle]\nmass_kg = 1500\n[sensors]\nimu_behind_front_axle_m = 1.2\n", Path("vehicle.toml")
    )
    assert yaw_lever(bare) is None
    lever = yaw_lever(placed)
    assert lever is not None
    # the place of the CG is not known either: 7 % of a wheelbase
    assert -0.4 < lever[0] < 0.05
    assert lever[1] > 0.15
    assert np.isfinite(lever).all()


def test_a_vehicle_low_in_front_turns_into_the_bend_less_and_a_pickup_more() -> None:
    """Measured with z down, told with z up: minivans are tall behind, pickups have a low bed."""
    means = {body: measured_product(body)[0] for body in ("Pickup", "Sedan", "SUV", "Minivan")}
    assert means["Pickup"] > 0 > means["Sedan"] > means["Minivan"]
    assert means["SUV"] < 0
    assert measured_product("lorry") == measured_product(None)
    assert measured_product(None)[1] == pytest.approx(0.021, abs=0.001)
