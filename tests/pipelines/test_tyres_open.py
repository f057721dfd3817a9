"""Tyres that may give or not leave open so much of a roll gradient as is seen by deflections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.rigid_tyres import TYRES_PART, rigid, tyres_open
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import linear

KNOWN = before_the_log(Vehicle())


def joints() -> tuple[Joint, Joint]:
    weighed = [linear({"empty_mass": 1.0}, 1800.0, 20.0)]
    return find_mode(weighed, KNOWN), find_mode(weighed, rigid(KNOWN))


@pytest.mark.parametrize(
    ("chance", "share"), [(0.0, 0.0), (0.02, 0.0), (0.25, 0.43), (0.5, 0.5), (0.97, 0.0)]
)
def test_share_is_that_of_two_kinds_and_none_where_one_is_sure(chance: float, share: float) -> None:
    soft, stiff = joints()
    assert tyres_open(soft, ((chance, stiff),)) == pytest.approx(share * TYRES_PART, abs=0.002)
    # told the other way round it is the same
    assert tyres_open(stiff, ((1 - chance, soft),)) == pytest.approx(share * TYRES_PART, abs=0.002)


def test_other_ways_with_the_same_tyres_leave_nothing_open() -> None:
    soft, _ = joints()
    assert tyres_open(soft, ((0.3, replace(soft, u=np.zeros(len(soft.u)))),)) == 0.0
