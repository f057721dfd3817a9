"""Roll per lateral acceleration on a rough road: the accelerometer holds what the road rolls, the gyros tell what was steered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.brake_roll.lateral import LateralData, LateralKnown, fit_lateral, lively_band
from pipelines.estimators.brake_roll.parts import CORNERING_PITCH_STD, PITCH_STD, STIFFENING
from pipelines.filters.linear_response import linear_response
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray

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


def _sensed(felt: FloatArray, roll: FloatArray, rate: FloatArray, noise: float, seed: int) -> LateralData:
    """A drive's columns without a speed: what the leaning body's accelerometer and the gyros show. felt: without gravity. noise: of
    the roll rate, rad/s."""
    rng = np.random.default_rng(seed)
    n = len(felt)
    own = {name: lowpass(rng.standard_normal(n), RATE_HZ, BAND_HZ) for name in ("f", "p", "r")}
    return LateralData(
        RATE_HZ, BAND_HZ, felt + GRAVITY * roll + 0.02 * own["f"], rate + noise * own["p"],
        felt / SPEED + 1e-3 * own["r"], None, None, None, np.ones(n, bool), (np.zeros(1, np.int64), np.full(1, n, np.int64)),
    )  # fmt: skip


def _on_springs_that_stiffen(strength: float, seed: int) -> LateralData:
    """A slalom of 5 m/s² on T2 φ'' + T1 φ' + φ (1 + s φ²) = G f, in steps of 2 ms. strength: s in rad^-2."""
    fine, lag, inertia = 10, 0.07, 0.009
    n = round(60.0 * RATE_HZ) * fine
    step = 1 / (RATE_HZ * fine)
    time = step * np.arange(n)
    felt = 4.0 * np.sin(2 * np.pi * 0.3 * time) + 1.5 * np.sin(2 * np.pi * 0.11 * time)
    state = np.zeros((n, 2))
    for i in range(1, n):
        roll, rate = state[i - 1]
        push = GAIN * (felt[i - 1] + GRAVITY * roll) - roll * (1 + strength * roll**2)
        rate += step * (push - lag * rate) / inertia
        state[i] = roll + step * rate, rate
    return _sensed(felt[::fine], state[::fine, 0], state[::fine, 1], 1e-3, seed)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_springs_that_stiffen_do_not_lower_the_roll_of_small_angles(seed: int) -> None:
    data = _on_springs_that_stiffen(15.0, seed)
    straight, bent = (
        fit_lateral(data, replace(KNOWN, stiffening=known)) for known in ((0.0, 0.0), STIFFENING)
    )
    assert straight is not None
    assert bent is not None
    assert straight.gain < 0.97 * GAIN
    assert bent.gain == pytest.approx(GAIN, rel=0.02)
    assert bent.fit.value("stiffening") == pytest.approx(15.0 * GAIN**2, rel=0.35)
    # springs that do not: none is found
    plain = fit_lateral(_on_springs_that_stiffen(0.0, seed), replace(KNOWN, stiffening=STIFFENING))
    assert plain is not None
    assert plain.gain == pytest.approx(GAIN, rel=0.02)
    assert abs(plain.fit.value("stiffening")) < 0.15 * 15.0 * GAIN**2


@pytest.mark.parametrize("turns", [1, 3])
def test_a_body_that_pitches_in_a_slow_circle_does_not_roll_more_or_less(turns: int) -> None:
    n = round(100.0 * RATE_HZ)
    felt = 0.5 + 2.25 * (1 - np.cos(np.pi * turns * np.arange(n) / n))
    roll = SENSED * felt * (1 + GRAVITY * SENSED)
    level = _sensed(felt, roll, np.gradient(roll) * RATE_HZ, 1e-4, 0)
    pitch = 1.2e-4 * felt**2
    data = replace(level, roll_rate=level.roll_rate + pitch * felt / SPEED)
    blind, told = (
        fit_lateral(data, replace(KNOWN, pitch=a, cornering_pitch=b))
        for a, b in ((0.0, 0.0), (PITCH_STD, CORNERING_PITCH_STD))
    )
    assert blind is not None
    assert told is not None
    assert abs(blind.gain - SENSED) > 1.5 * abs(told.gain - SENSED)
    assert abs(told.gain - SENSED) < min(0.03 * SENSED, 2.5 * told.std)
    assert told.fit.value("cornering_pitch") == pytest.approx(1.2e-4, abs=3e-5)


def test_what_does_not_follow_on_a_rough_road_makes_it_less_sure() -> None:
    smooth, rough = (fit_lateral(_drive(road, 1), KNOWN) for road in (0.0, 1.5))
    assert smooth is not None
    assert rough is not None
    assert rough.explained < 0.9 < smooth.explained
    assert rough.std > 10 * smooth.std


def test_what_a_filter_bends_at_the_ends_is_left_out() -> None:
    """A slalom of one frequency that stops at once: the roll was 4 % too small, at six of its standard deviations."""
    n = round(40.0 * RATE_HZ)
    felt = 5.0 * np.sin(2 * np.pi * 0.3 * np.arange(n) / RATE_HZ)
    own = (np.zeros(1, np.int64), np.full(1, n, np.int64))
    out = linear_response(felt, *discretise(RollCoefficients(1.0, 0.07, 0.009), 1 / RATE_HZ), 1.0, own)
    roll, rate = GAIN * out[:, 0], GAIN * out[:, 1]
    data = _sensed(felt - GRAVITY * roll, roll, rate, 1e-3, 0)
    fit = fit_lateral(data, KNOWN)
    assert fit is not None
    assert not fit.used[: round(2 * RATE_HZ)].any()
    assert not fit.used[-round(2 * RATE_HZ) :].any()
    assert abs(fit.gain - GAIN) < min(0.025 * GAIN, 2 * fit.std)
    # of a short piece a quarter at most
    short = replace(data, segments=(np.array([0, n // 2]), np.array([n // 2 - 50, n])))
    assert fit_lateral(short, KNOWN) is not None
