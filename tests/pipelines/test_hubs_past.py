"""What the hubs' links take of their inertia past the springs: one share for posterior, struts and planes, with room towards all of it."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.joint.vehicle.hubs import hubs_past_draws, hubs_past_of
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.vehicles.vehicle import Quantity, Vehicle

COUNT = 200_000


def test_silent_files_leave_room_for_arms_that_point_at_the_middle() -> None:
    mean, std = hubs_past_of(Vehicle())
    drawn = hubs_past_draws(Vehicle(), np.random.default_rng(0), COUNT)
    assert (drawn.mean(), drawn.std()) == (pytest.approx(mean, abs=0.005), pytest.approx(std, rel=0.01))
    # plane models of the whole vehicle have all of it past the springs
    assert np.mean(drawn > 0.9) > 0.02
    assert (1 - mean) / std < 2.6


def test_stated_arms_are_taken_as_they_are() -> None:
    stated = Vehicle(
        quantities={f"wheel_recession_{axle}": Quantity(0.05, 0.02, "rig") for axle in ("front", "rear")}
    )
    known = before_the_log(stated)
    i = known.names.index("hubs_past")
    assert hubs_past_of(stated) == (known.mean[i], known.std[i])
    drawn = hubs_past_draws(stated, np.random.default_rng(0), COUNT)
    assert drawn.std() == pytest.approx(known.std[i], rel=0.01)
