"""What the verdict says of the roll motion's mirror solution and flat line, and whether two heights of a density are a mirror's."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map.height import mirrored
from pipelines.estimators.roll_map.posterior import Posterior
from pipelines.joint.mirror import QUICK_ROLL, mirror_words, said_of_mirror
from pipelines.models.roll import mirror_height

MASS, INERTIA = 1600.0, 650.0


def test_near_the_flat_line() -> None:
    words = mirror_words(MASS, INERTIA, 0.62, 0.02)
    assert "flat line" in words
    assert f"{np.sqrt(INERTIA / MASS):.2f} m" in words


@pytest.mark.parametrize(("std", "said"), [(0.02, "leaves that out"), (0.3, "both are held")])
def test_the_mirror_solution(std: float, said: str) -> None:
    words = mirror_words(MASS, INERTIA, 1.0, std)
    assert f"{mirror_height(1.0, MASS, INERTIA):.2f} m (mirror solution)" in words
    assert said in words


def test_nothing_of_a_slow_motion_or_of_no_vehicle() -> None:
    told = {"sprung_mass_kg": (MASS, 10.0), "roll_inertia_kgm2": (INERTIA, 50.0), "roll_arm_m": (1.0, 0.1)}
    assert said_of_mirror({}, told) == ""
    assert "mirror" in said_of_mirror({QUICK_ROLL: 1.0}, told)
    assert said_of_mirror({QUICK_ROLL: 1.0}, {**told, "roll_arm_m": (-0.1, 0.1)}) == ""


def test_two_heights_are_a_mirror_s_only_where_their_arms_say_so() -> None:
    arm = np.linspace(0.8, 1.0, 50)
    values = {"cg_height_m": 0.9 * arm + 0.1, "roll_arm_m": arm, "mirror": INERTIA / (MASS * arm**2)}
    posterior = Posterior(values, np.full(50, 0.02), 50.0)
    other = mirror_height(0.9, MASS, INERTIA)
    assert mirrored((0.9 * other + 0.1, 0.91), posterior)
    assert not mirrored((0.8, 0.91), posterior)
