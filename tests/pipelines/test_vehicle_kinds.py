"""Cars, vans, lorries and buses: told apart, each with the loads that such vehicles carry, and springs that level themselves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from parsers.errors import VehicleError
from pipelines.joint.doubts.carried import BELLOWS, LEVELLED, LEVELS, level_chance
from pipelines.joint.doubts.listed import doubts_of, said
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.reached import reach
from pipelines.joint.vehicle.unknowns import BY_SPRINGS, CORNERS, before_the_log
from pipelines.joint.ways.levelled import as_levelled
from pipelines.models.roll import GRAVITY
from pipelines.vehicles.axle_loads import by_springs, carried_in_words
from pipelines.vehicles.kinds import kind_of, usual_load
from pipelines.vehicles.spring_base import rigid_axle
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import read_vehicle
from tests.pipelines.joint_parts import linear, vehicle


def of(body: str | None, mass: float, wheelbase: float = 2.7) -> Vehicle:
    figures = {"mass_kg": (mass, 20.0), "wheelbase_m": (wheelbase, 0.01)}
    return Vehicle(body=body, quantities={k: Quantity(*v, "vehicle file") for k, v in figures.items()})


@pytest.mark.parametrize(
    ("body", "mass", "wheelbase", "kind"),
    [
        ("Sedan", 1500, 2.7, "car"),
        ("SUV", 2600, 3.4, "car"),
        ("SUV", 3760, 2.8, "car"),
        (None, 1500, 2.7, "car"),
        (None, 2400, 3.0, "car"),
        ("Van", 1900, 3.0, "carrier"),
        ("Pickup truck", 2100, 3.3, "carrier"),
        ("Motorhome", 3000, 4.0, "carrier"),
        (None, 2100, 3.66, "carrier"),
        ("box truck", 3300, 4.0, "heavy"),
        ("City bus", 11600, 5.9, "heavy"),
        (None, 7700, 5.2, "heavy"),
        ("Van", 3800, 4.3, "heavy"),
    ],
)
def test_kinds(body: str | None, mass: float, wheelbase: float, kind: str) -> None:
    assert kind_of(of(body, mass, wheelbase)) == kind
    assert rigid_axle(of(body, mass, wheelbase), "rear") == (kind != "car")


def test_a_lorry_may_carry_more_than_itself_and_a_car_may_not() -> None:
    """A load of 1.2 empty masses is usual of a lorry and hardly possible in a car."""
    for mass, most in ((1500.0, 400.0), (7700.0, 1.5 * 7700)):
        before = before_the_log(of(None, mass))
        row = before.index("load")
        away = (1.2 * mass - before.mean[row]) / before.std[row]
        assert (away < 2.5) == (mass > 3500)
        assert usual_load(of(None, mass), mass).most == most


def _weighed(mass: float, levelling: str | None = None) -> tuple[Joint, Vehicle]:
    """Deflections say: empty. The axles' scales say: 60 % of the empty mass is carried."""
    file = replace(vehicle(mass_kg=(mass, 0.01 * mass)), body=None, self_levelling=levelling)
    known = before_the_log(file)
    wheels = {f"zero_{wheel}": 1.0 for wheel in CORNERS}
    seen = [
        linear({"load": GRAVITY, **wheels}, 0.0, 0.01 * GRAVITY * mass, "deflections"),
        linear({"empty_mass": 1.0, "load": 1.0}, 1.6 * mass, 0.02 * mass, "axle loads"),
    ]
    return find_mode(seen, known), file


def test_deflections_that_the_axle_loads_contradict_are_those_of_springs_that_level_themselves() -> None:
    joint, file = _weighed(9000.0)
    doubts = doubts_of(joint, file)
    assert sum(d.weight for d in doubts if d.doubt.text == LEVELS) > 0.9
    assert any(text.startswith(LEVELS) for text in said(doubts))


def test_without_a_contradiction_the_doubt_keeps_its_chance() -> None:
    file = replace(vehicle(), body=None)
    joint = find_mode([linear({"load": 1.0, "zero_fl": 1e-6}, 180.0, 10.0)], before_the_log(file))
    weight = sum(d.weight for d in doubts_of(joint, file) if d.doubt.text == LEVELS)
    assert weight == pytest.approx(LEVELLED["car"], rel=0.05)
    without = find_mode([linear({"load": 1.0}, 180.0, 10.0)], before_the_log(file))
    assert not any(d.doubt.text == LEVELS for d in doubts_of(without, file))


def test_large_suvs_have_air_springs_more_often() -> None:
    def chance(body: str | None, mass: float) -> float:
        return level_chance(replace(vehicle(mass_kg=(mass, 20.0)), body=body))

    assert chance("SUV", 2100.0) > 5 * chance("SUV", 1500.0)
    assert chance("SUV", 1500.0) == chance("Sedan", 2100.0) == LEVELLED["car"]


def test_what_does_not_settle_it_makes_it_one_cause_among_others() -> None:
    """An SUV whose deflections say that it is empty, and whose scales have 130 kg in it: a wrong empty mass, or springs that level."""
    file = vehicle(mass_kg=(2200.0, 22.0))
    wheels = {f"zero_{wheel}": 1.0 for wheel in CORNERS}
    seen = [
        replace(linear({"load": GRAVITY, **wheels}, 0.0, 0.008 * GRAVITY * 2200.0), carrier="deflections"),
        replace(linear({"empty_mass": 1.0, "load": 1.0}, 2200.0 + 130.0, 15.0), carrier="axle loads"),
    ]
    found = reach(seen, file, np.random.default_rng(0))
    assert found is not None
    assert any(text.startswith(LEVELS) for text in found.found)
    assert any(text.startswith("stated mass wrong") for text in found.found)


@pytest.mark.parametrize("levelling", ["none", "rear", "both"])
def test_what_the_file_says_of_levelling_is_not_doubted(levelling: str) -> None:
    joint, file = _weighed(9000.0, levelling)
    assert not any(d.doubt.text == LEVELS for d in doubts_of(joint, file))
    known = joint.known
    load = known.at(joint.u)["load"]
    stiff = [float(known.std[known.index(f"zero_{wheel}")]) for wheel in ("fl", "rl")]
    if levelling == "both":
        assert load == pytest.approx(0.6 * 9000, rel=0.05)
    assert (stiff[1] > 10 * stiff[0]) == (levelling == "rear")
    assert (stiff[0] > 1e3) == (levelling == "both")


def test_the_key_is_read_and_checked(tmp_path: Path) -> None:
    path = tmp_path / "car.toml"
    path.write_text('[vehicle]\nmass_kg = 9000\nself_levelling = "both"\n')
    assert read_vehicle(path).self_levelling == "both"
    path.write_text('[vehicle]\nmass_kg = 9000\nself_levelling = "yes"\n')
    with pytest.raises(VehicleError, match="found 'yes', expected one of 'none', 'rear', 'both'"):
        read_vehicle(path)


def test_what_axle_loads_show_is_read_and_checked(tmp_path: Path) -> None:
    path = tmp_path / "lorry.toml"
    path.write_text('[vehicle]\nmass_kg = 9000\naxle_load_by = "springs"\n')
    stated = read_vehicle(path)
    assert by_springs(stated) == 1.0
    assert carried_in_words(1.0, stated)[0].value == "what the springs carry"
    path.write_text('[vehicle]\nmass_kg = 9000\naxle_load_by = "air"\n')
    with pytest.raises(VehicleError, match="found 'air', expected one of 'tires', 'springs'"):
        read_vehicle(path)


@pytest.mark.parametrize(("kind", "chance"), [("SUV", 0.03), ("Van", 0.3), ("Truck", 0.5)])
def test_where_nobody_says_axle_loads_may_be_the_springs(kind: str, chance: float) -> None:
    """Lorries' and vans' buses send what bellows or leaf springs tell; the doubt is of logs that have axle loads."""
    file = replace(vehicle(), body=kind)
    seen = [linear({BY_SPRINGS: 1.0, "load": 1e-3}, 0.5, 1.0)]
    joint = find_mode(seen, before_the_log(file))
    assert sum(d.doubt.chance for d in doubts_of(joint, file) if d.doubt.text == BELLOWS) == pytest.approx(
        chance
    )
    assert f"{chance:.0%}" in carried_in_words(0.5, file)[0].value
    for other, told in (
        ([linear({"load": 1.0}, 100.0, 50.0)], file),
        (seen, replace(file, axle_load_by="tires")),
    ):
        joint = find_mode(other, before_the_log(told))
        assert not any(d.doubt.text == BELLOWS for d in doubts_of(joint, told))
    assert carried_in_words(0.0, file) == []


def test_where_it_is_almost_sure_the_drive_is_joined_so() -> None:
    joint, file = _weighed(9000.0)
    levelled = as_levelled(joint, file)
    assert levelled is not None
    assert levelled[0].self_levelling == "both"
    assert levelled[1]
    blind = find_mode([linear({"load": 1.0}, 3000.0, 100.0)], before_the_log(file))
    assert as_levelled(blind, file) is None
    assert as_levelled(*_weighed(9000.0, "none")) is None
