"""Bars stated as nought at both axles: a vehicle without any, or a figure that nobody looked up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.weighed import Weighed
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.no_bars import NOT_LOOKED_UP, bars_not_looked_up
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import linear, vehicle

FRONT, REAR = (f"anti_roll_stiffness_{axle}_nmprad" for axle in ("front", "rear"))
NONE = vehicle(**{FRONT: (0.0, 0.0), REAR: (0.0, 0.0)})
SPRINGS = 0.5 * 35e3 * 1.6**2


def _bars(file: Vehicle, seen: float) -> list[Weighed]:
    """The doubts about bars, where a log has so much more roll stiffness than the front springs, N m/rad."""
    known = before_the_log(file)
    evidence = [linear({"spring_front": 0.5 * 1.6**2, "bar_front": 1.0}, SPRINGS + seen, 2000.0)]
    found = doubts_of(find_mode(evidence, known), file)
    return [each for each in found if each.doubt.text == "stated anti-roll bars wrong"]


def test_two_noughts_may_be_the_bars_that_such_vehicles_have() -> None:
    bars = bars_not_looked_up(before_the_log(NONE), NONE)
    assert bars.keys() == {"bar_front", "bar_rear"}
    assert bars["bar_front"] == (pytest.approx(0.6 * SPRINGS), pytest.approx(0.5 * SPRINGS))
    # one entry for each place where a load may lie
    assert sum(each.weight for each in _bars(NONE, 0.0)) < NOT_LOOKED_UP
    found = _bars(NONE, 0.6 * SPRINGS)
    assert sum(each.weight for each in found) > 0.9
    seen = found[0]
    # the bar that the log has, in place of next to none
    row = before_the_log(NONE).index("bar_front")
    gradient = np.zeros(seen.gain.shape[1])
    gradient[row] = before_the_log(NONE).std[row]
    assert seen.on(gradient)[0] > 0.4 * SPRINGS


def test_one_nought_or_none_and_lorries_are_taken_at_their_word() -> None:
    one = vehicle(**{REAR: (0.0, 0.0)})
    heavy = replace(NONE, body="Truck")
    for file in (one, vehicle(), heavy):
        assert not bars_not_looked_up(before_the_log(file), file)
