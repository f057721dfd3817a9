"""A load that the vehicle file states and that the drive did not have."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipelines.evidence import Evidence, Values
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.stated_figures import OFTEN_WRONG
from pipelines.joint.file_check import LOAD, file_check, stated_unknowns
from pipelines.joint.inference import Inference, infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.reached import reach
from pipelines.joint.vehicle.unknowns import CORNERS, before_the_log
from pipelines.joint.ways.levelled import as_levelled, rather_another_load
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import read_vehicle
from tests.pipelines.joint_parts import linear, vehicle


def stated(kilos: float, std: float) -> Vehicle:
    """The data sheet with a load of this drive's."""
    return replace(vehicle(), load={"mass_kg": Quantity(kilos, std, "test")})


def deflections(kilos: float, std: float = 12.0) -> Evidence:
    """What the springs say that they carry."""
    wheels = {f"zero_{wheel}": 1.0 for wheel in CORNERS}
    found = linear({"load": GRAVITY, **wheels}, GRAVITY * kilos, GRAVITY * std, "deflections")
    return replace(found, carrier="deflections")


def judged(evidence: list[Evidence], file: Vehicle) -> Inference:
    found = infer(evidence, file, np.random.default_rng(0))
    assert found is not None
    return found


def test_a_load_that_is_not_there_is_found_wrong_and_the_one_that_is_there_told() -> None:
    torques = linear({"empty_mass": 1.0, "load": 1.0}, 2000.0, 10.0)
    rates = [
        replace(linear({f"spring_{axle}": 1.0}, rate, 200.0), carrier=axle)
        for axle, rate in (("front", 35e3), ("rear", 38e3))
    ]
    evidence = [deflections(100.0), replace(torques, carrier="torques"), *rates]
    found = reach(evidence, stated(400.0, 8.0), np.random.default_rng(0))
    assert found is not None
    assert found.found[0].startswith("stated load wrong: the drive fits no vehicle with what the file states")
    mass = judged(evidence, stated(400.0, 8.0)).parameters["mass_kg"]
    assert mass.status == "identified"
    assert mass.value == pytest.approx(2000.0, abs=15.0)


def test_what_is_aboard_otherwise_lies_elsewhere_too() -> None:
    """632 kg in the bed for the 160 kg between the axles of the file: neither springs that level themselves nor the stated place hold."""
    truth = {"load": 632.0, "load_x": 2.9}
    rates = [
        replace(linear({f"spring_{axle}": 1.0}, rate, 200.0), carrier=axle)
        for axle, rate in (("front", 35e3), ("rear", 38e3))
    ]

    def springs(values: Values) -> FloatArray:
        behind = values["load"] * values["load_x"] / values["wheelbase"]
        zeros = sum(np.asarray(values[f"zero_{wheel}"]) for wheel in CORNERS) / GRAVITY
        return np.stack([values["load"] - behind + 0.5 * zeros, behind + 0.5 * zeros])

    behind = truth["load"] * truth["load_x"] / 2.8
    carried = replace(
        deflections(0.0), predict=springs, observed=np.array([truth["load"] - behind, behind]), covariance=np.diag([100.0, 100.0]),
        unknowns=("load", "load_x", "wheelbase", *(f"zero_{wheel}" for wheel in CORNERS)),
    )  # fmt: skip
    torques = replace(linear({"empty_mass": 1.0, "load": 1.0}, 1900 + 632.0, 40.0), carrier="torques")
    file = replace(
        vehicle(),
        load={"mass_kg": Quantity(160.0, 15.0, "t"), "behind_front_axle_m": Quantity(1.8, 0.2, "t")},
    )
    assert stated_unknowns(file)[LOAD] == ("load", "load_x")
    found = judged([carried, torques, *rates], file)
    assert any(text.startswith("stated load wrong") for text in found.record.spoke_for)
    place, mass = found.parameters["cg_to_front_axle_m"], found.parameters["mass_kg"]
    assert place.value is not None
    assert place.std is not None
    assert mass.value == pytest.approx(2532.0, abs=40.0)
    true = (1900 * 1.3 + truth["load"] * truth["load_x"]) / 2532.0
    assert abs(place.value - true) < 2.5 * place.std


def test_the_right_load_is_not_doubted() -> None:
    found = judged([deflections(110.0)], stated(100.0, 8.0))
    assert found.record.spoke_for == ()
    mass = found.parameters["mass_kg"]
    assert mass.low is not None
    assert mass.high is not None
    assert mass.low < 2000.0 < mass.high


def test_a_load_that_the_drive_contradicts_is_a_stated_figure_in_conflict() -> None:
    file = stated(400.0, 8.0)
    joint = find_mode([deflections(100.0)], before_the_log(file))
    assert LOAD in {check.record.relation for check in file_check(joint, file)}
    unseen = find_mode([linear({"empty_h": 1.0}, 0.7, 0.01)], before_the_log(file))
    assert LOAD not in {check.record.relation for check in file_check(unseen, file)}


def test_what_is_not_stated_or_stated_as_exact_is_no_such_figure() -> None:
    assert LOAD not in stated_unknowns(vehicle())
    assert LOAD not in stated_unknowns(stated(0.0, 0.0))
    assert stated_unknowns(stated(0.0, 5.0))[LOAD] == ("load",)


def test_a_doubt_that_the_log_does_not_see_keeps_its_chance() -> None:
    file = stated(100.0, 8.0)
    joint = find_mode([linear({"empty_h": 1.0}, 0.7, 0.01)], before_the_log(file))
    weight = sum(d.weight for d in doubts_of(joint, file) if d.doubt.text == f"{LOAD} wrong")
    assert weight == pytest.approx(OFTEN_WRONG[LOAD], rel=0.2)


def test_springs_that_level_themselves_are_not_blamed_for_it() -> None:
    evidence = [deflections(100.0)]
    file = stated(600.0, 8.0)
    known = before_the_log(file)
    joint = find_mode(evidence, known)
    levelled = find_mode(evidence, before_the_log(replace(file, self_levelling="both")))
    assert rather_another_load(joint, levelled, evidence, known, file)
    assert not rather_another_load(joint, levelled, evidence, known, vehicle())
    found = judged(evidence, file).record.spoke_for
    assert not any("level themselves" in text for text in found)


def test_a_lorry_whose_scales_have_the_stated_load_rather_levels_itself() -> None:
    """Two witnesses for the load against the springs."""
    file = replace(stated(5400.0, 100.0), body=None)
    file = replace(file, quantities={**file.quantities, "mass_kg": Quantity(9000.0, 90.0, "test")})
    known = before_the_log(file)
    evidence = [
        deflections(0.0, 90.0),
        linear({"empty_mass": 1.0, "load": 1.0}, 14400.0, 180.0, "axle loads"),
    ]
    joint = find_mode(evidence, known)
    levelled = as_levelled(joint, file)
    assert levelled is not None
    high = find_mode(evidence, before_the_log(levelled[0]))
    assert not rather_another_load(joint, high, evidence, known, file)


def test_a_bare_number_is_never_surer_than_five_kilograms(tmp_path: Path) -> None:
    path = tmp_path / "car.toml"
    for text, std in (("0", 5.0), ("400", 8.0), ("{value = 0, std = 0}", 0.0)):
        path.write_text(f"[vehicle]\nmass_kg = 1500\n[load]\nmass_kg = {text}\n")
        assert read_vehicle(path).load["mass_kg"].std == std
