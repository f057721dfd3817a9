"""A roll damping that the vehicle file states is known before the log, unless its dampers are."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.joint.information import Spread, prior_spreads
from pipelines.joint.vehicle.stated import stated_relations
from pipelines.joint.vehicle.unknowns import before_the_log
from tests.pipelines.joint_parts import vehicle

NAME = "roll_damping_nmsprad"


def _known(**figures: tuple[float, float]) -> Spread:
    file = vehicle(**figures)
    return prior_spreads(before_the_log(file), stated_relations(file), np.random.default_rng(0))[NAME]


@pytest.mark.parametrize("stated", [3500.0, 6500.0])
def test_a_stated_roll_damping_is_what_was_known(stated: float) -> None:
    """Three files, one without it and one with a fiftieth of it, gave one answer."""
    usual, told = _known(), _known(**{NAME: (stated, 0.02 * stated)})
    assert told.mean == pytest.approx(stated, rel=0.06)
    # what a drive's own speeds make of dampers with knees stays open
    assert 0.1 < told.std / told.mean < 0.2
    assert told.std < 0.75 * usual.std


def test_dampers_that_are_stated_themselves_are_not_counted_twice() -> None:
    dampers = {f"damper_rate_{axle}_nspm": (1600.0, 80.0) for axle in ("front", "rear")}
    alone, beside = _known(**dampers), _known(**dampers, **{NAME: (9000.0, 100.0)})
    assert beside.mean == pytest.approx(alone.mean, rel=0.02)
