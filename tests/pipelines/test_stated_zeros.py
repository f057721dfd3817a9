"""What the deflection sensors show with the empty vehicle, told in the vehicle file: taken off, and then known as well as that."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from loaded_drive import LOADED, loaded_drive
from loaded_drive import told as told_by
from plant_balance import vehicle_file

from parsers.drive import Drive
from parsers.errors import VehicleError
from pipelines.joint.vehicle.suspension import READ_N
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.prepare.deflection_zero import NAMES, less_their_zeros, with_zero_open
from pipelines.vehicles.keys import ZERO_KEYS
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

FILE = Path("vehicle.toml")
ZEROS_M = (0.003, -0.002, 0.002, -0.003)
"""Of the four sensors: their left ones show more than there is."""


@pytest.fixture(scope="module")
def driven() -> Drive:
    return loaded_drive()


def _off(drive: Drive) -> Drive:
    signals = dict(drive.signals)
    for name, zero in zip(NAMES, ZEROS_M, strict=True):
        signals[name] = replace(signals[name], values=signals[name].values + zero)
    return replace(drive, signals=signals)


def _stated(vehicle: Vehicle, std_m: float = 0.0003) -> Vehicle:
    told = {key: Quantity(zero, std_m, "vehicle file") for key, zero in zip(ZERO_KEYS, ZEROS_M, strict=True)}
    return replace(vehicle, sensors={**vehicle.sensors, **told})


def test_what_they_show_is_taken_off_and_said(driven: Drive) -> None:
    drive, vehicle = less_their_zeros(_off(driven), _stated(Vehicle()))
    for name in NAMES:
        assert drive.signals[name].values == pytest.approx(driven.signals[name].values, abs=1e-12)
    said = [d for d in drive.record.decisions if d.kind == "zero"]
    assert [d.signal for d in said] == list(NAMES)
    assert "3.0 ± 0.3 mm" in said[0].evidence
    assert vehicle.deflection_zero == "empty"
    # of one sensor alone, and of a log without them
    one = replace(Vehicle(), sensors={ZERO_KEYS[1]: Quantity(0.001, 0.0003, "vehicle file")})
    moved, _ = less_their_zeros(driven, one)
    assert moved.signals[NAMES[0]] is driven.signals[NAMES[0]]
    assert moved.signals[NAMES[1]].values == pytest.approx(driven.signals[NAMES[1]].values - 0.001)
    bare = replace(driven, signals={n: s for n, s in driven.signals.items() if n not in NAMES})
    assert less_their_zeros(bare, one) == (bare, one)
    assert less_their_zeros(driven, Vehicle()) == (driven, Vehicle())


def test_a_vehicle_that_begins_where_its_stated_zeros_are_is_empty(driven: Drive) -> None:
    """Sensors that all begin at nought would else be taken for zeroed under the load."""
    signals = dict(driven.signals)
    for name, zero in zip(NAMES, ZEROS_M, strict=True):
        first = signals[name].values[:50].mean()
        signals[name] = replace(signals[name], values=signals[name].values - first + zero)
    drive, vehicle = with_zero_open(*less_their_zeros(replace(driven, signals=signals), _stated(Vehicle())))
    assert vehicle.deflection_zero == "empty"
    assert all("begin at zero" not in d.found for d in drive.record.decisions)


def test_zeros_are_known_as_well_as_they_were_read() -> None:
    file = vehicle_file(LOADED, None)
    usual, read = before_the_log(file), before_the_log(_stated(file))
    for wheel, axle in (("fl", "front"), ("rr", "rear")):
        rate = file.quantities[f"spring_rate_{axle}_npm"].value
        i = usual.index(f"zero_{wheel}")
        assert read.std[i] == pytest.approx(np.hypot(0.0003 * rate, READ_N))
        assert read.std[i] < 0.5 * usual.std[i]
    text = "[sensors]\nsuspension_deflection_fl_m = 0.004\nsuspension_deflection_rr_m = {value = -0.002, std = 0.0001}"
    sensors = parse_vehicle(text, FILE).sensors
    assert (sensors["suspension_deflection_fl_m"].value, sensors["suspension_deflection_fl_m"].std) == (
        0.004,
        0.0005,
    )
    assert sensors["suspension_deflection_rr_m"].std == 0.0001


def test_zeros_of_the_empty_vehicle_and_of_a_loaded_one_exclude_each_other() -> None:
    text = '[vehicle]\ndeflection_zero = "loaded"\n[sensors]\nsuspension_deflection_fl_m = 0.004'
    with pytest.raises(VehicleError, match="deflection_zero"):
        parse_vehicle(text, FILE)


def test_a_zero_in_millimetres_is_refused() -> None:
    with pytest.raises(VehicleError, match="suspension_deflection_fl_m"):
        parse_vehicle("[sensors]\nsuspension_deflection_fl_m = 4.0", FILE)


def test_the_lateral_place_is_told_where_the_zeros_are(driven: Drive) -> None:
    file = vehicle_file(LOADED, None)
    level = {key: Quantity(0.0, 0.1, "vehicle file") for key in ("imu_roll_deg", "imu_pitch_deg")}
    file = replace(file, sensors={**file.sensors, **level})
    unsure = told_by(_off(driven), file)["cg_lateral_offset_m"]
    told = told_by(*less_their_zeros(_off(driven), _stated(file)))["cg_lateral_offset_m"]
    clean = told_by(driven, _stated(file))["cg_lateral_offset_m"]
    assert unsure.value is not None
    assert told.value is not None
    assert clean.value is not None
    assert told.std is not None
    assert unsure.std is not None
    assert told.value == pytest.approx(clean.value, abs=1e-4)
    assert abs(unsure.value - clean.value) > 0.008
    assert told.std < unsure.std
