"""`powertrain` in the vehicle file: read, checked, and heard by the prior of the joint posterior."""

from __future__ import annotations

from pathlib import Path

import pytest

from parsers.errors import VehicleError
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.vehicles.vehicle_file import parse_vehicle

FILE = """[vehicle]
body = "SUV"
mass_kg = 2400
{}
"""


def _known(line: str) -> tuple[float, float]:
    known = before_the_log(parse_vehicle(FILE.format(line), Path("vehicle.toml")))
    row = known.index("empty_h")
    return float(known.mean[row]), float(known.std[row])


def test_the_joint_prior_hears_it() -> None:
    silent, battery = _known(""), _known('powertrain = "battery"')
    assert battery[0] < 0.92 * silent[0]
    assert battery[1] > 1.5 * silent[1]
    stated = _known('powertrain = "battery"\ncg_height_m = {value = 0.6, std = 0.01}')
    assert stated == (0.6, 0.01)


def test_a_powertrain_that_there_is_not_names_those_that_there_are() -> None:
    with pytest.raises(VehicleError, match=r"powertrain.*'electric'.*'combustion', 'hybrid', 'battery'"):
        parse_vehicle(FILE.format('powertrain = "electric"'), Path("vehicle.toml"))
