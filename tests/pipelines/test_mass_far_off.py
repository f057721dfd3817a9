"""A mass that is stated more closely than people err: it may be off by what they err by."""

from __future__ import annotations

import pytest

from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.stated_figures import FAR_OFF, chance_wrong, file_doubts
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.unknowns import before_the_log
from tests.pipelines.joint_parts import linear, vehicle


def _far(std: float) -> list[float]:
    """Spreads in kg of the doubts of a mass of 1500 kg that is stated to std."""
    file = vehicle(mass_kg=(1500.0, std))
    joint = find_mode([linear({"empty_mass": 1.0}, 1500.0, 40.0)], before_the_log(file))
    return [
        std * float(d.precision[0, 0]) ** -0.5
        for d in file_doubts(joint, file)
        if d.text == "stated mass wrong"
    ]


def test_the_doubt_reaches_as_far_whatever_is_stated() -> None:
    assert max(_far(4.5)) == max(_far(15.0)) == pytest.approx(120.0)
    # five of its own spreads are as much
    assert _far(30.0) == pytest.approx([150.0])


def test_a_log_that_has_another_mass_speaks_for_it_and_one_that_agrees_against_it() -> None:
    file = vehicle(mass_kg=(1500.0, 5.0))
    weights = {}
    for seen in (1500.0, 1620.0):
        joint = find_mode([linear({"empty_mass": 1.0}, seen, 40.0)], before_the_log(file))
        found = doubts_of(joint, file, "")
        weights[seen] = sum(w.weight for w in found if w.doubt.text == "stated mass wrong")
    chance = chance_wrong("stated mass", file) + FAR_OFF["stated mass"][1]
    assert weights[1500.0] < chance
    # three of the log's spreads: some eleven times likelier by the far one
    assert 0.15 < weights[1620.0] < 0.5
