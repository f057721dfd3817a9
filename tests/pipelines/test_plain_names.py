"""Every unknown has words that a reader of a report knows."""

from __future__ import annotations

import pytest

from pipelines.joint.vehicle.plain_names import plain_name
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.vehicles.vehicle import Vehicle


@pytest.mark.parametrize("name", before_the_log(Vehicle()).names)
def test_every_unknown_has_words_of_its_own(name: str) -> None:
    words = plain_name(name)
    assert "_" not in words
    assert words != name.replace("_", " ") or name in ("wheelbase", "load", "roll_inertia", "pitch_inertia")


def test_no_two_unknowns_share_their_words() -> None:
    names = before_the_log(Vehicle()).names
    assert len({plain_name(name) for name in names}) == len(names)


def test_places_and_balances_are_said() -> None:
    assert plain_name("roll_center_rear") == "roll centre's height, rear axle"
    assert plain_name("zero_fl") == "zero of the deflection, front left"
    assert plain_name("gain_pitch_tyre") == "model error of the pitch balance by tyre forces"
    assert plain_name("axle_pitch_gain") == "axle pitch gain"
