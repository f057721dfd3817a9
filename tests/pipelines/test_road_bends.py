"""Roads that lean into their bends: an angle against the horizon does not tell how far the body leans in them."""

from __future__ import annotations

import numpy as np
import plant_roll as plant
import pytest

from parsers.drive import Drive, Signal
from pipelines.estimators.roll_map.estimator import RollMap
from pipelines.prepare.bends import road_share
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

G = 9.80665
A, SPEED, STEP_S = 110.0, 15.0, 0.01
"""m/s² a rad of roll, m/s, s."""


def drive(across: FloatArray, lean: float) -> Drive:
    """A body that follows at once, on a road that leans by `lean` (rad a m/s²) into its bends."""
    rng = np.random.default_rng(1)
    bank = -lean * across
    roll = (across + G * bank) / (A - G) + bank
    columns = {
        "accel_y": across + G * roll + 0.02 * rng.standard_normal(len(across)),
        "roll": roll + 1e-4 * rng.standard_normal(len(across)),
        "yaw_rate": across / SPEED + 1e-4 * rng.standard_normal(len(across)),
        "speed": np.full(len(across), SPEED),
    }
    t = np.arange(len(across)) * 10_000_000
    return Drive({n: Signal(n, t, v, n) for n, v in columns.items()}, plant.bare_record(len(t) * STEP_S))


def road(seconds: float, bend_s: float) -> FloatArray:
    """Bends of either side, one after the other."""
    rng = np.random.default_rng(2)
    count = int(seconds / bend_s)
    heights = rng.uniform(0.8, 2.5, count) * np.where(rng.random(count) < 0.5, -1, 1)
    bump = np.sin(np.pi * np.arange(int(bend_s / STEP_S)) * STEP_S / bend_s)
    return np.concatenate([height * bump for height in heights])


def gradient(made: Drive) -> ParameterEstimate:
    estimator = RollMap()
    found = estimator.estimate(
        estimator.prepare(made, {}), Vehicle(), {"draws": 1000.0}, np.random.default_rng(1)
    )
    return found.parameters["roll_gradient_degpg"]


TRUE = float(np.degrees(G / A))


@pytest.mark.parametrize("lean", [0.0, 0.001, 0.002])
def test_slow_bends_of_a_road_are_never_sure(lean: float) -> None:
    found = gradient(drive(road(300.0, 14.0), lean))
    assert found.status != "identified"
    if found.value is not None and found.std is not None:
        assert abs(found.value - TRUE) < 2.5 * found.std


def test_what_is_steered_quickly_and_what_goes_round_and_round_is_on_flat_ground() -> None:
    t = np.arange(0.0, 60.0, STEP_S)
    quick = gradient(drive(3.0 * np.sin(2 * np.pi * 0.5 * t), 0.0))
    # six turns on a pad, quicker and quicker
    rounds = gradient(drive(np.minimum(0.08 * np.arange(0.0, 90.0, STEP_S), 5.0), 0.0))
    # (a body without inertia is not this estimator's: of the quick one only how sure it is)
    assert quick.status == rounds.status == "identified"
    assert rounds.value == pytest.approx(TRUE, rel=0.05)


def test_share_that_a_road_may_have() -> None:
    bends, pad = road(300.0, 14.0), np.full(9000, 3.0)
    starts = np.zeros(1, np.int64)
    assert road_share(bends / SPEED, bends, STEP_S, starts) == pytest.approx(1.0)
    assert road_share(pad / SPEED, pad, STEP_S, starts) == pytest.approx(0.0)
    both = np.concatenate((bends, pad))
    share = float(np.sum(bends**2) / np.sum(both**2))
    assert road_share(both / SPEED, both, STEP_S, starts) == pytest.approx(share, abs=0.02)
    # cut into stretches of a few seconds nobody sees the turns
    assert road_share(pad / SPEED, pad, STEP_S, np.arange(0, 9000, 500)) == pytest.approx(1.0)
    assert road_share(None, pad, STEP_S, starts) == 1.0
