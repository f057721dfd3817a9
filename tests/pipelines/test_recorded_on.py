"""A log that the vehicle file says is of a vehicle on the road: no piece of physics is left out, and tyres give."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from parsers.errors import VehicleError
from pipelines.estimators.brake_roll.vehicle import known_of
from pipelines.estimators.roll_map.priors import STIFFER, draw_vehicle, rigid_tyres
from pipelines.evidence import Evidence, Values
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.simple_models import physics_doubts
from pipelines.joint.inference import infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.rigid_tyres import NAME, TYRES
from pipelines.models.axle_load import patch_shift
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle
from tests.pipelines.joint_parts import linear, vehicle

FEET = ("patch_lag", "patch_side", "pitch_path")


def said(what: str | None) -> Vehicle:
    return replace(vehicle(tire_vertical_rate_npm=(250e3, 12e3)), recorded_on=what)


def row(file: Vehicle, name: str) -> tuple[float, float]:
    known = before_the_log(file)
    at = known.index(name)
    return float(known.mean[at]), float(known.std[at])


@pytest.mark.parametrize("what", ["vehicle", "simulation"])
def test_the_file_says_what_the_log_is_of(what: str) -> None:
    parsed = parse_vehicle(f'[vehicle]\nrecorded_on = "{what}"\n', Path("vehicle.toml"))
    assert parsed.recorded_on == what
    assert parsed.real == (what == "vehicle")


def test_another_word_is_an_error_that_names_the_right_ones() -> None:
    with pytest.raises(VehicleError, match="'vehicle', 'simulation'"):
        parse_vehicle('[vehicle]\nrecorded_on = "road"\n', Path("vehicle.toml"))


def test_a_vehicle_leaves_no_physics_out_and_a_simulation_may() -> None:
    known = before_the_log(said(None))
    joint = find_mode([linear({"empty_mass": 1.0}, 1900.0, 15.0)], known)
    assert physics_doubts(joint, said("vehicle")) == []
    asked = {d.doubt.text for d in doubts_of(joint, said(None))}
    left = {d.doubt.text for d in doubts_of(joint, said("vehicle"))}
    simple = {d.text for d in physics_doubts(joint, said(None))}
    assert simple
    assert asked - left == simple
    assert {d.text for d in physics_doubts(joint, said("simulation"))} == simple


@pytest.mark.parametrize("name", FEET)
def test_feet_are_as_on_vehicles(name: str) -> None:
    """Surer, and within what a silent file leaves possible."""
    (usual, wide), (mean, spread) = row(said(None), name), row(said("vehicle"), name)
    assert 0 < spread < 0.8 * wide
    assert abs(mean - usual) < wide
    assert row(said("simulation"), name) == (usual, wide)


def test_the_lag_is_what_makes_no_power_from_nowhere() -> None:
    squash = 3 * patch_shift(1900.0, 250e3)[0]
    assert row(said("vehicle"), "patch_lag")[0] == pytest.approx(2 / 3 * squash)


def test_stated_figures_of_a_rig_stand_as_they_are() -> None:
    stated = {"tire_lateral_rate_npm": (160e3, 8e3), "tire_longitudinal_rate_npm": (370e3, 2e4)}
    files = [
        replace(vehicle(**stated, patch_path_pitch_mprad=(0.4, 0.03)), recorded_on=w)
        for w in (None, "vehicle")
    ]
    for name in FEET:
        assert row(files[0], name) == row(files[1], name)


def test_its_tyres_give_and_those_of_a_simulation_may_not() -> None:
    rates = []
    for what in (None, "vehicle"):
        file = said(what)
        draws, _, _ = draw_vehicle(file, np.random.default_rng(0), 20_000)
        rates.append(float(np.mean(draws.tyre_roll > 0.5 * STIFFER * np.median(draws.tyre_roll))))
        assert rates[-1] == pytest.approx(rigid_tyres(file), abs=0.003)
    assert rates[0] > 0
    assert rates[1] == 0


def test_braking_takes_the_roll_stiffness_of_tyres_that_give() -> None:
    figures = {"roll_stiffness_nmprad": (90e3, 2e3), "tire_vertical_rate_npm": (250e3, 2e3)}
    silent, real = (known_of(replace(vehicle(**figures), recorded_on=what)) for what in (None, "vehicle"))
    assert silent is not None
    assert real is not None
    assert silent.stiffness is not None
    assert real.stiffness is not None
    tyres = 250e3 * 1.6**2
    assert real.stiffness.value == pytest.approx(90e3 * tyres / (tyres + 90e3))
    assert real.stiffness.value < silent.stiffness.value
    assert real.stiffness.std < silent.stiffness.std


def test_rigid_tyres_are_not_asked_for() -> None:
    """A drive that shows tyres which hardly give: those of a simulator, or a reading that is wrong on the road."""

    def predict(values: Values) -> FloatArray:
        found = np.asarray(5000.0 / np.asarray(values[TYRES]) * 1e3)
        return found[None] if np.ndim(found) else np.array([float(found)])

    none = Evidence(
        "roll", "made up", "tyres' give", "by hand", np.array([0.0]), np.array([[1.5**2]]), predict, (TYRES,)
    )
    drive = [none, linear({"load": 1.0}, 100.0, 10.0)]
    silent, real = (
        infer(drive, replace(vehicle(), recorded_on=what), np.random.default_rng(0))
        for what in (None, "vehicle")
    )
    assert silent is not None
    assert real is not None
    assert any(NAME in text for text in silent.record.spoke_for)
    assert not any(NAME in text for text in real.record.spoke_for)
