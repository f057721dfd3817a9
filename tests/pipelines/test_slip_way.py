"""Slips of braked wheels that contradict all else: they are unsure, before the file is blamed for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence
from pipelines.joint.posterior import find_mode
from pipelines.joint.reached import Reached, reach
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.slip_way import CARRIER, CHANCE, NAME, WIDER, slip_ways
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import linear, vehicle

WEIGHED = vehicle(cg_to_front_axle_m=(1.3, 0.003), cg_lateral_offset_m=(0.004, 0.002))
STD = 0.01


def slips(place: float) -> Evidence:
    """What the slips say of the empty vehicle's place."""
    return replace(linear({"empty_x": 1.0}, place, STD), carrier=CARRIER, kind="pitch")


def _reached(evidence: list[Evidence], file: Vehicle) -> Reached:
    found = reach(evidence, file, np.random.default_rng(0))
    assert found is not None
    return found


@pytest.mark.parametrize("off", [0.0, 0.02, 0.06])
def test_odds_are_those_of_two_integrals(off: float) -> None:
    evidence, known = [slips(1.3 + off)], before_the_log(WEIGHED)
    ((odds, found, unsure),) = slip_ways(find_mode(evidence, known), evidence, known)

    def log_density(std: float) -> float:
        spread = std**2 + 0.003**2
        return float(-0.5 * off**2 / spread - 0.5 * np.log(spread))

    exact = log_density(WIDER * STD) - log_density(STD) + np.log(CHANCE / (1 - CHANCE))
    assert odds == pytest.approx(exact, abs=0.01)
    assert np.allclose(unsure[0].covariance, WIDER**2 * STD**2)
    assert found.known is known


def test_slips_against_all_else_are_unsure_and_the_file_stands() -> None:
    found = _reached([slips(1.36), linear({"load": 1.0}, 100.0, 10.0)], WEIGHED)
    assert found.found[0].startswith(NAME)
    places = [
        joint.known.mean[row] + joint.known.std[row] * joint.u[row]
        for joint in (found.joint, *(other for _, other in found.others))
        for row in [joint.known.index("empty_x")]
    ]
    assert abs(places[0] - 1.3) < 0.01


def test_slips_that_go_with_the_rest_are_not_asked() -> None:
    assert _reached([slips(1.31), linear({"load": 1.0}, 100.0, 10.0)], WEIGHED).found == ()


def test_without_slips_there_is_no_such_way() -> None:
    evidence = [linear({"empty_x": 1.0}, 1.4, STD)]
    known = before_the_log(WEIGHED)
    assert list(slip_ways(find_mode(evidence, known), evidence, known)) == []
