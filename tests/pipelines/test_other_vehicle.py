"""A vehicle file that is another vehicle's: told from one wrong figure, and no answer is taken from it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence
from pipelines.joint.inference import Inference, infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.reached import reach
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.other_vehicle import (
    BOUND,
    CHANCE,
    NAME,
    TEXT,
    TURNED,
    another,
    other_ways,
    turned_odds,
)
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import linear, vehicle

KNOWN = before_the_log(vehicle())
SMALLER = {"empty_mass": 0.72, "spring_front": 0.7, "spring_rear": 0.75, "wheelbase": 0.88}
"""What a log of a smaller car has of the file's figures."""


def _log(shares: Mapping[str, float], surely: float = 0.01) -> list[Evidence]:
    """A log that has unknowns at these shares of the file's figures."""
    figures = {name: float(KNOWN.mean[KNOWN.index(name)]) for name in shares}
    return [
        replace(linear({n: 1.0}, shares[n] * value, surely * value, n), carrier=n)
        for n, value in figures.items()
    ]


def _odds(evidence: Sequence[Evidence], file: Vehicle) -> float:
    ((odds, *_),) = other_ways(find_mode(evidence, KNOWN), evidence, (), KNOWN, file)
    return odds


def _told(evidence: Sequence[Evidence], file: Vehicle) -> Inference:
    found = infer(evidence, file, np.random.default_rng(0))
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("turning", "likelier"), [(None, 1.0), (1.0, 0.6), (1.08, 0.6), (0.84, 2.0), (0.7, 15.0), (1.4, 15.0)]
)
def test_a_log_that_sees_nothing_of_the_file_leaves_the_chance_as_it_was(
    turning: float | None, likelier: float
) -> None:
    """The open prior is a normal law times what binds it: its mass must be taken account of."""
    odds = _odds([linear({"load_y": 1.0}, 0.01, 0.1)], replace(vehicle(), turning=turning))
    assert odds == pytest.approx(math.log(likelier * CHANCE / (1 - CHANCE)), abs=0.05)


def test_figures_that_are_right_speak_against_it() -> None:
    evidence = _log(dict.fromkeys(SMALLER, 1.0))
    assert _odds(evidence, replace(vehicle(), turning=0.7)) < -5
    assert reach(evidence, replace(vehicle(), turning=0.7), np.random.default_rng(0)).found == ()  # type: ignore[union-attr]


def test_one_wrong_figure_is_that_figure() -> None:
    for wrong in SMALLER.keys() - {"wheelbase"}:
        shares = {**dict.fromkeys(SMALLER, 1.0), wrong: SMALLER[wrong]}
        found = reach(_log(shares), vehicle(), np.random.default_rng(0))
        assert found is not None
        assert found.another < 0.05


def test_what_is_stated_as_exact_is_open_in_no_way() -> None:
    """One wrong figure without a spread is no other vehicle's file, which would be the only way that could explain it."""
    exact = vehicle(mass_kg=(1900.0, 0.0))
    evidence = [linear({"empty_mass": 1.0}, 0.72 * 1900.0, 19.0), linear({"load": 1.0}, 100.0, 10.0)]
    found = reach(evidence, exact, np.random.default_rng(0))
    assert found is not None
    assert found.another < 0.05
    known = before_the_log(exact)
    free, _ = another(known, exact)
    row = known.index("empty_mass")
    assert free.std[row] == known.std[row]


@pytest.mark.parametrize("turning", [None, 0.7])
def test_a_smaller_car_with_a_larger_ones_file_has_no_answer(turning: float | None) -> None:
    found = _told(_log(SMALLER), replace(vehicle(), turning=turning))
    assert found.record.spoke_for == (TEXT,)
    for name in ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "roll_stiffness_nmprad"):
        entry = found.parameters[name]
        assert entry.status == "not_identifiable"
        assert entry.reason.startswith("the vehicle file seems to be another vehicle's (odds 100%)")
        # nor by what joins it with other methods afterwards
        assert entry.refused


@pytest.mark.parametrize("turning", [None, 0.82, 0.5])
def test_a_wheelbase_that_is_far_off_may_be_another_vehicles_however_well_the_rest_fits(
    turning: float | None,
) -> None:
    """A road that shows it at 0.82 of the file's, beside a right mass and springs: a slip of the pen, or vehicles that are alike."""
    evidence = _log({**dict.fromkeys(SMALLER, 1.0), "wheelbase": 0.82})
    found = _told(evidence, replace(vehicle(), turning=turning))
    told = " ".join(found.record.spoke_for)
    assert "stated wheelbase wrong" in told
    assert NAME in told
    assert found.parameters["mass_kg"].status != "identified"


def test_a_wheelbase_that_is_off_by_a_little_is_a_slip_of_the_pen() -> None:
    evidence = _log({**dict.fromkeys(SMALLER, 1.0), "wheelbase": 0.97}, surely=0.002)
    found = reach(evidence, vehicle(), np.random.default_rng(0))
    assert found is not None
    assert found.found[0].startswith("stated wheelbase wrong")
    assert found.another < 0.05


def test_what_binds_is_of_the_files_vehicle() -> None:
    free, bound = another(KNOWN, vehicle())
    assert len(bound) == len(BOUND)
    values = free.at(np.zeros(len(free.names)))
    for relation in bound:
        assert relation.predict(values) == pytest.approx(1.0)
    assert np.all(free.std >= KNOWN.std)
    assert np.array_equal(free.mean, KNOWN.mean)


def test_a_file_that_states_next_to_nothing_is_nobodys() -> None:
    figures = {n: q for n, q in vehicle().quantities.items() if n != "mass_kg"}
    file = replace(vehicle(), quantities=figures)
    known = before_the_log(file)
    evidence = [linear({"load": 1.0}, 100.0, 10.0)]
    assert list(other_ways(find_mode(evidence, known), evidence, (), known, file)) == []


def test_a_steering_ratio_alone_that_is_another_asks_and_takes_nothing() -> None:
    """Every relation is as the file has it: what is left of the doubt is small, and no answer moves."""
    evidence = _log(dict.fromkeys(SMALLER, 1.0))
    plain, asked = (_told(evidence, replace(vehicle(), turning=t)) for t in (None, 0.6))
    assert NAME not in " ".join(asked.record.spoke_for)
    for name, entry in plain.parameters.items():
        assert asked.parameters[name].status == entry.status


@pytest.mark.parametrize(
    ("turning", "others", "least"),
    [(1.31, 5.0, 5.0), (1.31, -1.0, None), (1.05, 5.0, None), (None, 5.0, None)],
)
def test_a_contradiction_of_a_drive_that_turns_unlike_the_file_is_as_likely_another_vehicles(
    turning: float | None, others: float, least: float | None
) -> None:
    """Beside the likeliest other cause: of two oddities one would have to be chance."""
    found = find_mode([linear({"load": 1.0}, 100.0, 10.0)], KNOWN)
    odds = turned_odds(found, KNOWN, replace(vehicle(), turning=turning), others)
    assert odds == (-math.inf if least is None else pytest.approx(least + math.log(TURNED / (1 - TURNED))))


def test_a_drive_torque_that_doubles_on_a_file_of_another_steering_is_no_torque_alone() -> None:
    """All that the log has of the mass by torque is twice the file's: a wrong range, or a van with a hatchback's file."""
    kilos = float(KNOWN.mean[KNOWN.index("empty_mass")])
    rows = {"load": 1.0, "empty_mass": 1.0, "drive_scale": -kilos}
    log = [
        replace(linear(rows, 1.0 * kilos, 0.02 * kilos, "drive"), carrier="drive"),
        replace(linear({"load": 1.0}, 100.0, 40.0, "scales"), carrier="scales"),
    ]
    for turning, doubted in ((1.0, False), (1.35, True)):
        found = reach(log, replace(vehicle(), turning=turning), np.random.default_rng(0))
        assert found is not None
        assert (found.another > 0.3) == doubted
