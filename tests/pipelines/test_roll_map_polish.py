"""The motion by instruments: known answers, what noise of the angle carries into the input, and honest errors where noise is wide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import fit_roll
from pipelines.estimators.roll_map.likelihood import QUIET, Problem, named
from pipelines.estimators.roll_map.model import known_parameters, whitened
from pipelines.estimators.roll_map.motion import simulated
from pipelines.estimators.roll_map.polish import refine
from pipelines.estimators.roll_map.spectrum import Shifter, motion_band
from pipelines.results import FloatArray

RATE = 16.0
TRUTH = {
    "a": 110.0,
    "b": 7.0,
    "c": 0.8,
    "delay": 0.0,
    "roll_offset": 0.0,
    "rate_offset": 0.0,
    "rate_lag": 0.0,
}


def _slalom() -> FloatArray:
    t = np.arange(0, 36, 1 / RATE)
    return 4 * np.sin(2 * np.pi * (0.3 * t + 0.004 * t * t)) * np.minimum(t / 3, 1)


def _data(accel: FloatArray, roll: FloatArray, rate: FloatArray, density: float, *, axles: bool) -> RollData:
    n = len(accel)
    starts, stops = np.array([0]), np.array([n])
    sent = Shifter(accel, starts, stops, RATE, held=True)
    band = motion_band(accel, [(0, n)], RATE)
    return RollData(
        step_s=1 / RATE, rows=np.arange(n), starts=starts, stops=stops, accel=accel, roll=roll, rate=rate,
        whole_roll=roll, whole_rate=rate, yaw=np.zeros(n), shifter=sent,
        clean_shifter=Shifter(accel, starts, stops, RATE, held=True, band=band), band=band,
        yaw_shifter=None, against_axles=axles, has_roll=True, has_rate=True, has_yaw=False, rate_shift_s=0.0,
        band_hz=0.5 * RATE, top_hz=3.0, every=1, slow_share=0.0, input_noise=density, drive_rows=n, rate_with_accel=True,
    )  # fmt: skip


def _sensed(noise: float, seed: int) -> RollData:
    """The model's answer to a slalom, read by noisy sensors; the accelerometer's noise is not in the motion."""
    rng = np.random.default_rng(seed)
    push = _slalom()
    nothing = np.zeros(len(push))
    truth = TRUTH | {"rate_gain": 1.0}
    moved = -simulated(_data(push, nothing, nothing, 1e-6, axles=True), truth)
    accel = push + noise * rng.standard_normal(len(push))
    roll, rate = moved[:, 0], moved[:, 1]
    roll = roll + 0.01 * noise * rng.standard_normal(len(push))
    rate = rate + 0.03 * noise * rng.standard_normal(len(push))
    return _data(accel, roll, rate, noise**2 / RATE, axles=True)


def _problem(data: RollData) -> Problem:
    return Problem(data, known_parameters(data, None, 0.2, 0.05, None, frozenset()))


def test_without_noise_the_planted_motion_comes_back_from_a_start_that_is_off() -> None:
    problem = _problem(_sensed(1e-4, 1))
    start = problem.near({**TRUTH, "a": 113.0, "b": 6.0, "c": 0.9, "rate_gain": 1.02})
    x, _, settled = refine(problem, start, 40)
    found = named(problem.known, x)
    assert settled
    assert (found["a"], found["b"], found["c"]) == pytest.approx((110.0, 7.0, 0.8), rel=2e-3)


def test_an_end_is_sought_near_the_start_alone_where_none_farther_off_is_of_use(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A whole band that has nothing of the sure band's motion cost 13 to 50 s of climbing, and was then left."""
    data = _sensed(1e-3, 1)
    known = known_parameters(data, None, 0.2, 0.05, None, frozenset())
    edges = np.array([data.size])
    far = {**TRUTH, "a": 300.0, "b": 1.0, "c": 0.05, "rate_gain": 1.0, "log_input_noise": -3.0}
    assert data.whole

    def climbs(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("pipelines.estimators.roll_map.fit.climb", climbs)
    assert not fit_roll(data, known, edges, far, close=True).converged
    with pytest.raises(AssertionError):
        fit_roll(data, known, edges, far)
    near = fit_roll(data, known, edges, {**TRUTH, "rate_gain": 1.0}, close=True)
    assert near.converged
    assert near.values["a"] == pytest.approx(110.0, rel=2e-3)


def test_wide_noise_of_the_input_does_not_bias_the_instruments() -> None:
    """A noise of 0.1 m/s² up to 8 Hz beside a slalom below 1 Hz: mean errors within three of their own standard errors.

    b and the delay stand for each other within what is known of the delay (10 ms are 1.1 of b).
    """
    errors = []
    for seed in range(8):
        problem = _problem(_sensed(0.1, seed))
        x, _, _ = refine(problem, problem.near(TRUTH | {"rate_gain": 1.0}), 40)
        found = named(problem.known, x)
        errors.append([found[name] - TRUTH[name] for name in "abc"])
    spread = np.std(errors, axis=0, ddof=1)
    assert (np.abs(np.mean(errors, axis=0)) < 3 * spread / np.sqrt(8)).all()
    assert (spread < (2.0, 2.0, 0.25)).all()


def test_the_angles_noise_in_the_input_is_counted_as_it_is_on_average() -> None:
    """Against the horizon the input is f - g φ: white noise of the angle alone, through the model and the filter."""
    quiet = np.zeros(4000)
    data = _data(quiet, quiet, quiet, 1e-6, axles=False)
    problem = _problem(data)
    weights = named(problem.known, problem.near(TRUTH)) | {"log_roll_noise": np.log(0.002)}
    noise = 0.002 * np.random.default_rng(3).standard_normal(4000)
    noisy = replace(data, roll=noise, whole_roll=noise)
    still = weights | dict.fromkeys(QUIET, 0.0)
    error, variance = whitened(noisy, weights, simulated(noisy, still), clip=1e9)
    x = problem.near(weights)
    alone = _of_the_angle(problem, x, weights)
    assert alone == pytest.approx(float(np.nansum(error**2 / variance)), rel=0.1)


def _of_the_angle(problem: Problem, x: FloatArray, weights: dict[str, float]) -> float:
    """What the noises carry, less the accelerometer's part."""
    other = Problem(problem.data, problem.known)
    other.probes = other.probes[:1]
    return float((problem.carried([x], weights) - other.carried([x], weights))[0])
