"""A vehicle that never moves: what its scales tell is told, and nothing of what its motion would."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipelines.analyze import Request, analyze
from pipelines.joint.counted import counted
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.vehicles.vehicle_file import parse_vehicle
from tests.pipelines.joint_parts import linear

FILE = """
[vehicle]
body = "Van"
mass_kg = {value = 1900, std = 5}
cg_to_front_axle_m = {value = 1.45, std = 0.003}
wheelbase_m = 3.1
track_front_m = 1.65
track_rear_m = 1.65
wheel_radius_m = 0.34
spring_rate_front_npm = {value = 32e3, std = 600}
spring_rate_rear_npm = {value = 40e3, std = 800}
pitch_center_height_m = {value = 0.2, std = 0.02}
tire_vertical_rate_npm = {value = 240e3, std = 8e3}
brake_gain_nmppa = {value = 7e-4, std = 2e-5}
"""


def parked(folder: Path, seconds: float = 120.0, **more: float) -> Path:
    """A log of every production signal and axle loads, all of them noise about rest."""
    rng = np.random.default_rng(5)
    n = round(seconds * 50)

    def noisy(value: float, noise: float) -> np.ndarray:
        return np.round(value + noise * rng.standard_normal(n), 4)

    columns = {"Time [s]": np.arange(n) / 50.0}
    columns |= {
        "accel_x [m/s^2]": noisy(0.05, 0.02),
        "accel_y [m/s^2]": noisy(-0.03, 0.02),
        "accel_z [m/s^2]": noisy(9.81, 0.02),
    }
    columns |= {f"{axis}_rate [deg/s]": noisy(0.0, 0.05) for axis in ("roll", "pitch", "yaw")}
    columns |= {f"Wheel speed {w} [km/h]": np.zeros(n) for w in ("FL", "FR", "RL", "RR")}
    columns |= {
        "Vehicle speed [km/h]": np.zeros(n),
        "Brake pressure [bar]": noisy(20.0, 0.1),
        "Drive torque [Nm]": noisy(0.0, 1.0),
    }
    columns |= {name: noisy(value, 5.0) for name, value in more.items()}
    path = folder / "parked.csv"
    pl.DataFrame(columns).write_csv(path)
    return path


@pytest.mark.parametrize("loads", [{}, {"Axle load front [N]": 10_200.0, "Axle load rear [N]": 10_400.0}])
def test_a_parked_vehicle_tells_what_it_weighs_and_nothing_else(
    tmp_path: Path, loads: dict[str, float]
) -> None:
    (tmp_path / "vehicle.toml").write_text(FILE, encoding="utf-8")
    log = parked(tmp_path, **loads)
    found = analyze(Request(logs=(log,), vehicle=tmp_path / "vehicle.toml")).verdict
    for name in ("cg_height_m", "roll_arm_m", "pitch_arm_m", "roll_inertia_kgm2"):
        assert name not in found or found[name].status == "not_identifiable"
    if loads:
        mass = found["mass_kg"]
        assert mass.value is not None
        assert mass.std is not None
        assert abs(mass.value - 20_600 / 9.81) < 3 * mass.std


def test_a_relation_without_figures_is_left_out_and_said() -> None:
    known = before_the_log(parse_vehicle(FILE, Path("vehicle.toml")))
    nothing = replace(
        linear({"empty_mass": 1.0}, 1900.0, 5.0), observed=np.zeros(0), covariance=np.zeros((0, 0))
    )
    kept, dropped = counted([nothing], known)
    assert not kept
    assert len(dropped) == 1
