"""Roll per lateral acceleration on a rough road: the accelerometer holds what the road rolls, the gyros tell what was steered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.brake_roll.lateral import LateralData, LateralKnown, fit_lateral, lively_band
from pipelines.filters.linear_response import linear_response
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise
from pipelines.prepare.lowpass import lowpass

RATE_HZ, BAND_HZ, SECONDS, GAIN = 50.0, 5.0, 120.0, 0.0106
SPEED = 12.0


def _drive(road_radps: float, seed: int = 0) -> LateralData:
    """Bends of some ten seconds, on a road that rolls the body between 1 and 4 Hz; the unit sits 0.4 m above the roll axis."""
    rng = np.random.default_rng(seed)
    n = round(SECONDS * RATE_HZ)
    time = np.arange(n) / RATE_HZ
    steered = 3.0 * np.sin(2 * np.pi * time / 11) * np.sin(2 * np.pi * time / 37 + 0.3)
    rows = (np.zeros(1, np.int64), np.full(1, n, np.int64))
    out = linear_response(steered, *discretise(RollCoefficients(1.0, 0.07, 0.009), 1 / RATE_HZ), 1.0, rows)
    roll, rate = GAIN * out[:, 0], GAIN * out[:, 1]
    road = rng.standard_normal(n)
    road = lowpass(road, RATE_HZ, 4.0) - lowpass(road, RATE_HZ, 1.0)
    road *= road_radps / float(np.std(road))
    angle = np.cumsum(road) / RATE_HZ
    f_y = steered + GRAVITY * (roll + angle) - 0.4 * np.gradient(rate + road) * RATE_HZ
    noise = {name: lowpass(rng.standard_normal(n), RATE_HZ, BAND_HZ) for name in ("f", "p", "r")}
    return LateralData(
        RATE_HZ, BAND_HZ, f_y + 0.02 * noise["f"], rate + road + 1e-3 * noise["p"], steered / SPEED + 1e-3 * noise["r"],
        np.full(n, SPEED), None, None, np.ones(n, bool), rows,
    )  # fmt: skip


KNOWN = LateralKnown()
SENSED = GAIN / (1 + GRAVITY * GAIN)
"""What is fitted: roll over the acceleration that the leaning body senses, gravity's part in it."""


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("without", ["", "speed", "both"])
def test_the_road_is_no_answer_to_steering(without: str, seed: int) -> None:
    data = _drive(0.04, seed)
    if without:
        data = replace(data, speed=None, yaw_rate=None if without == "both" else data.yaw_rate)
    fit = fit_lateral(data, KNOWN)
    assert fit is not None
    assert fit.gain == pytest.approx(SENSED, rel=0.03)
    assert fit.std < 0.05 * SENSED


def test_the_band_is_that_of_the_steering() -> None:
    data = _drive(0.04)
    assert lively_band(data) < 0.8
    assert lively_band(replace(data, speed=None)) < 0.8
    # nobody tells: no quicker than drivers weave
    assert lively_band(replace(data, speed=None, yaw_rate=None)) == pytest.approx(1.0)


def test_where_nothing_tells_the_steering_a_rough_road_makes_it_less_sure() -> None:
    blind = [fit_lateral(replace(_drive(road), speed=None, yaw_rate=None), KNOWN) for road in (0.0, 0.04)]
    smooth, rough = blind
    assert smooth is not None
    assert rough is not None
    assert rough.std > 5 * smooth.std
    assert abs(rough.gain - SENSED) < 2 * rough.std
