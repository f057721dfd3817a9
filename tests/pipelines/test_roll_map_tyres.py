"""What tyres add to a roll against the axles: as known beforehand, or as a gyro beside the springs shows it."""

from __future__ import annotations

import re

import numpy as np
import pytest

from pipelines.estimators.roll_map.answers import Coefficients, log_answers
from pipelines.estimators.roll_map.tyre_share import RIGID, STIFFENS, by_stated_stiffness, drawn_tyres
from pipelines.results import Prior


def drawn(gain: float | None, std: float = 0.02, slow: float = 0.0, rigid: float = RIGID):
    """Draws of the gain, beforehand 1.2 ± 0.05, after a gyro that showed `gain`, with what tyres take off c (1 beforehand)."""
    rng = np.random.default_rng(1)
    names = ("a", "b", "c") if gain is None else ("a", "b", "c", "rate_gain")
    mean = np.array([100.0, 6.0, 0.8, gain or 1.0])[: len(names)]
    spread = np.diag(np.array([5.0, 1.0, 0.1, std])[: len(names)] ** 2)
    weak = np.array([80.0, 6.0, 0.6, 0.15])[: len(names)]
    coefficients = Coefficients(names, mean, spread, mean, weak)
    before = 1.2 + 0.05 * rng.standard_normal(20_000)
    return drawn_tyres(before, np.ones(20_000), coefficients, slow, rigid=rigid, rng=rng)


@pytest.mark.parametrize("chance", [RIGID, 0.03])
def test_without_a_gyro_rigid_tyres_stay_possible(chance: float) -> None:
    gain, loss = drawn(None, rigid=chance)
    assert np.mean(gain == 1.0) == pytest.approx(chance, abs=0.01)
    assert ((loss == 0.0) == (gain == 1.0)).all()
    assert np.median(gain) == pytest.approx(1.2, abs=0.01)


def test_a_gyro_tells_tyres_that_give() -> None:
    gain, _ = drawn(1.25)
    assert np.mean(gain == 1.0) < 1e-3
    # two normal figures of 1.2 ± 0.05 and 1.25 ± 0.02
    assert gain.mean() == pytest.approx(1.2 + 0.05 * 25 / 29, abs=0.003)
    assert gain.std() == pytest.approx(0.05 * (4 / 29) ** 0.5, abs=0.002)


def test_a_gyro_tells_rigid_tyres() -> None:
    gain, loss = drawn(1.01, std=0.03)
    assert np.mean(gain == 1.0) > 0.95
    assert np.mean(loss == 0.0) > 0.95


def test_on_roads_that_lean_a_gyro_tells_less() -> None:
    assert drawn(1.15, slow=1.0)[0].std() > 1.5 * drawn(1.15)[0].std()
    # less than any tyres make of it: the road leans, and nobody knows by how much
    assert np.mean(drawn(0.85, slow=1.0)[0] == 1.0) == pytest.approx(RIGID, abs=0.01)


def test_a_gain_that_no_tyres_have_tells_nothing() -> None:
    assert np.mean(drawn(2.5)[0] == 1.0) == pytest.approx(RIGID, abs=0.01)


def gradient(gain: float | None, *, slow: float = 0.0, stated: bool = False):
    """The roll gradient by deflections, after a gyro that showed `gain`, steady roll known to 2 %."""
    share = 1 / drawn(gain, slow=slow)[0]
    names = ("a", "b", "c")
    known = Coefficients(names, np.array([100.0, 6, 0.8]), np.diag([4.0, 0.1, 0.01]), np.ones(3), np.ones(3))
    sensor = (np.zeros(len(share)), share, np.zeros(len(share)))
    return log_answers(known, sensor, True, "of the body", {}, np.random.default_rng(3), tyres_stated=stated)[
        "roll_gradient_degpg"
    ]


@pytest.mark.parametrize(("gain", "slow"), [(None, 0.0), (0.85, 1.0), (2.5, 0.0)])
def test_a_gradient_of_which_usual_tyres_make_a_part_is_no_more_than_weak(
    gain: float | None, slow: float
) -> None:
    found = gradient(gain, slow=slow)
    assert found.status == "weak"
    assert re.search(r"the tyres' part of it \(1[67]%\) is what usual tyres add", found.reason)
    assert found.reason.count("tire_vertical_rate_npm") == 1
    assert gradient(gain, slow=slow, stated=True).status == "identified"


@pytest.mark.parametrize("gain", [1.25, 1.01])
def test_a_gradient_whose_tyres_the_gyro_tells_is_identified(gain: float) -> None:
    found = gradient(gain)
    assert found.status == "identified"
    assert "usual tyres add" not in found.reason


def _by_springs(stated: tuple[float, float], arm_std: float = 0.12):
    """Draws of the gain 1 + K / K_tyre, of which K is a moment arm times what the angle tells, before and after stated springs."""
    rng = np.random.default_rng(2)
    stiffness = 100e3 * (1 + arm_std * rng.standard_normal(40_000))
    gain = 1 + stiffness / 400e3
    coefficients = Coefficients(("a",), np.array([100.0]), np.eye(1), np.array([80.0]), np.array([60.0]))
    likely = by_stated_stiffness(stiffness, Prior(*stated, "vehicle file"))
    none = np.zeros(len(gain))
    return gain, drawn_tyres(gain, none, coefficients, 0.0, rigid=0.0, rng=rng, likely=likely)[0]


def test_stated_springs_tell_the_tyres_share() -> None:
    before, after = _by_springs((110e3, 2e3))
    std = np.hypot(2e3, STIFFENS * 110e3)
    # two normal figures of the stiffness, 100 ± 12 and 110 ± 5.9 kN m/rad, and a tenth of a chance of a file that is wrong
    both = 1 / (1 / 12e3**2 + 1 / std**2)
    assert np.median(after) == pytest.approx(1 + both * (100e3 / 12e3**2 + 110e3 / std**2) / 400e3, abs=0.003)
    assert after.std() < 0.65 * before.std()
    assert np.quantile(after, (0.16, 0.84)) == pytest.approx(
        np.median(after) + np.array([-1, 1]) * both**0.5 / 400e3, abs=0.004
    )


def test_springs_that_contradict_every_draw_are_taken_for_wrong() -> None:
    before, after = _by_springs((190e3, 4e3), arm_std=0.06)
    assert np.median(after) == pytest.approx(np.median(before), abs=0.02)
    assert after.std() > 0.8 * before.std()
