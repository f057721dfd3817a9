"""A deflection whose zero is off reads as that travel would: on the spring, and on the bar of its axle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.load_balance.forces import FORCES, Terms
from pipelines.joint.vehicle.unknowns import CORNERS, before_the_log
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import vehicle

OFF = 0.001
"""m."""


def _terms(lever: list[float], file: Vehicle, **more: float) -> tuple[Terms, dict[str, float]]:
    known = before_the_log(file)
    p = {**known.at(np.zeros(len(known.names))), **more}
    terms = Terms()
    FORCES["deflection"](p, lever, terms)
    return terms, p


@pytest.mark.parametrize("wheel", CORNERS)
@pytest.mark.parametrize("lever", [[1.0, 1.0, 1.0, 1.0], [0.8, -0.8, 0.8, -0.8]], ids=["sum", "roll"])
def test_a_zero_is_the_travel_that_it_is_off_by(wheel: str, lever: list[float]) -> None:
    rate = "spring_front" if wheel[0] == "f" else "spring_rear"
    right, p = _terms(lever, vehicle())
    off, _ = _terms(lever, vehicle(), **{f"zero_{wheel}": OFF * p[rate]})
    assert off["one"] - right["one"] == pytest.approx(OFF * right[f"d_{wheel}"])


def test_springs_that_level_themselves_are_off_by_a_force_and_twist_no_bar() -> None:
    lever = [0.8, -0.8, 0.8, -0.8]
    file = replace(vehicle(), self_levelling="both")
    right, _ = _terms(lever, file)
    off, _ = _terms(lever, file, zero_fl=300.0)
    assert off["one"] - right["one"] == pytest.approx(0.8 * 300.0)
