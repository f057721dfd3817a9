"""What an inertial unit shows on level ground, and where the load lies: told in the vehicle file."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from parsers.errors import VehicleError
from pipelines.estimators.load_balance.forces import Terms
from pipelines.estimators.load_balance.specific_force import forward, sideways
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.body import body_of
from pipelines.joint.vehicle.stated import stated_beside, stated_relations
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.models.roll import GRAVITY
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle
from tests.pipelines.joint_parts import linear, vehicle

FILE = Path("vehicle.toml")


def _told(**sensors: tuple[float, float]) -> Vehicle:
    return replace(vehicle(), sensors={k: Quantity(*pair, "vehicle file") for k, pair in sensors.items()})


@pytest.mark.parametrize(
    ("roll", "pitch", "offset_y", "offset_x"), [(1.2, -0.4, 0.0, 0.0), (0.3, 0.8, 0.05, -0.03)]
)
def test_the_stated_level_is_what_the_balances_take_off(
    roll: float, pitch: float, offset_y: float, offset_x: float
) -> None:
    """On level ground no specific force is left across and along once the unit is set straight as the balances do it."""
    known = before_the_log(_told())
    values = known.at(np.zeros(len(known.names))) | {
        "askew_roll": math.radians(roll), "askew_pitch": math.radians(pitch), "offset_y": offset_y, "offset_x": offset_x,
    }  # fmt: skip
    across, along = (
        float(e.predict(values)[0])
        for e in stated_relations(_told(imu_roll_deg=(0.0, 0.1), imu_pitch_deg=(0.0, 0.1)))
    )
    # what such a unit reads: + right side down shows f_y, + nose down shows - f_x
    read = {
        "fy": GRAVITY * math.radians(across),
        "fx": -GRAVITY * math.radians(along),
        "fz": GRAVITY,
        "one": 1.0,
    }
    for adds, own, other in ((sideways, "fy", "fx"), (forward, "fx", "fy")):
        terms: Terms = {}
        adds(values, body_of(values, 0.0), 1.0, terms)
        parts = {name: terms.get(name, 0.0) for name in ("fy", "fx", "fz", "one")}
        parts["fx"] += terms.get("fx_brake", 0.0)
        parts[other] = 0.0
        assert sum(parts[name] * read[name] for name in parts) == pytest.approx(0.0, abs=1e-9), own
    if offset_y == offset_x == 0.0:
        assert (across, along) == pytest.approx((roll, pitch))


def test_a_levelled_unit_narrows_mounting_and_offset_together() -> None:
    file = _told(imu_roll_deg=(0.5, 0.05))
    known = before_the_log(file)
    joint = find_mode((linear({"load": 1.0}, 180.0, 10.0), *stated_relations(file)), known)
    rows = [known.index("askew_roll"), known.index("offset_y")]
    slope = np.degrees(np.array([known.std[rows[0]], -known.std[rows[1]] / GRAVITY]))
    assert float(np.sqrt(slope @ joint.covariance[np.ix_(rows, rows)] @ slope)) == pytest.approx(
        0.05, rel=0.01
    )
    assert float(slope @ joint.u[rows]) == pytest.approx(0.5, abs=0.01)
    # which of the two it is stays as open as before
    assert joint.covariance[rows[1], rows[1]] > 0.4


def test_an_empty_vehicles_level_is_none_of_a_loaded_one_whose_lean_nobody_tells() -> None:
    file = _told(imu_roll_deg=(0.5, 0.05), imu_pitch_deg=(0.2, 0.05))
    springs = linear({"load": 1.0, "zero_fl": 1.0, "zero_rl": 1.0}, 180.0, 10.0)
    assert [e.title for e in stated_beside((springs,), file)] == [
        "stated imu_roll_deg",
        "stated imu_pitch_deg",
    ]
    for lean_unknown in (
        linear({"load": 1.0}, 180.0, 10.0),
        linear({"load": 1.0, "zero_rl": 1.0}, 180.0, 10.0),
    ):
        assert stated_beside((lean_unknown,), file) == ()


def test_the_loads_place_is_told_along_and_across() -> None:
    text = (
        "[vehicle]\nmass_kg = 1500\n[load]\nbehind_front_axle_m = -0.4\nleft_m = {value = -0.3, std = 0.02}\n"
    )
    file = parse_vehicle(text, FILE)
    assert not file.load_stated
    assert "no mass_kg" in file.load_unsaid
    known = before_the_log(file)
    mean, std = (dict(zip(known.names, x, strict=True)) for x in (known.mean, known.std))
    assert (mean["load_x"], std["load_x"]) == (-0.4, 0.1)
    assert (mean["load_y"], std["load_y"]) == (-0.3, 0.02)
    assert std["load_h"] > 0.2


def test_an_angle_in_other_units_is_refused() -> None:
    with pytest.raises(VehicleError, match="imu_roll_deg"):
        parse_vehicle("[sensors]\nimu_roll_deg = 90", FILE)
