"""Parts of the roll model: planted ones are asked for, absent ones are not, and what stays open is in the spread."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.roll_map.choose import mixed_fit
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import fit_roll
from pipelines.estimators.roll_map.held_out import gain_of, spans_of
from pipelines.estimators.roll_map.likelihood import Problem, named
from pipelines.estimators.roll_map.model import OPTIONS, known_parameters
from pipelines.estimators.roll_map.motion import excess, simulated
from pipelines.estimators.roll_map.select import Verdict, select_parts
from pipelines.estimators.roll_map.spectrum import Shifter, motion_band
from pipelines.results import FloatArray

RATE = 20.0
PLAIN = {
    "a": 110.0,
    "b": 7.0,
    "c": 0.8,
    "delay": 0.0,
    "roll_offset": 0.0,
    "rate_offset": 0.0,
    "rate_lag": 0.0,
}


def _data(accel: FloatArray, roll: FloatArray, rate: FloatArray, axles: bool) -> RollData:
    n = len(accel)
    starts, stops = np.array([0]), np.array([n])
    sent = Shifter(accel, starts, stops, RATE, held=True)
    band = motion_band(accel, [(0, n)], RATE)
    return RollData(
        step_s=1 / RATE, rows=np.arange(n), starts=starts, stops=stops, accel=accel, roll=roll, rate=rate,
        whole_roll=roll, whole_rate=rate, yaw=np.zeros(n), shifter=sent, clean_shifter=sent, band=band,
        yaw_shifter=None, against_axles=axles, has_roll=True, has_rate=True, has_yaw=False, rate_shift_s=0.0,
        band_hz=0.5 * RATE, top_hz=3.0, every=1, slow_share=0.0, input_noise=1e-6, drive_rows=n, rate_with_accel=True,
    )  # fmt: skip


def _quick(seconds: float, rng: np.random.Generator) -> FloatArray:
    """Steering of 0.3 to 1.7 Hz, a new rhythm and strength every few seconds."""
    t = np.arange(0, seconds, 1 / RATE)
    rhythm = np.repeat(rng.uniform(0.3, 1.7, 40), 50)[: len(t)]
    strength = np.repeat(rng.uniform(2.0, 6.0, 40), 50)[: len(t)]
    kernel = np.hanning(21) / np.hanning(21).sum()
    return np.convolve(strength * np.sin(2 * np.pi * np.cumsum(rhythm) / RATE), kernel, mode="same")


def _planted(parts: dict[str, float], seed: int, axles: bool = False, noise: float = 1.0) -> RollData:
    """What sensors with little noise read of the model with these parts."""
    rng = np.random.default_rng(seed)
    accel = _quick(42.0, rng)
    nothing = np.zeros(len(accel))
    quiet = _data(accel, nothing, nothing, axles)
    motion = -simulated(quiet, PLAIN | ({"rate_gain": 1.2} if axles else {}) | parts)
    roll = motion[:, 0] + noise * 3e-4 * rng.standard_normal(len(accel))
    rate = motion[:, 1] + noise * 3e-3 * rng.standard_normal(len(accel))
    return _data(accel, roll, rate, axles)


def _verdict(data: RollData, noise: float = 1.0) -> Verdict:
    """From the plain truth and the noise that is there."""
    levels = {
        "roll_noise": 3e-4 * noise,
        "rate_noise": 3e-3 * noise,
        "input_noise": 1e-3,
        "push": 1e-3,
        "bank": 1e-4,
    }
    start = PLAIN | {f"log_{name}": float(np.log(level)) for name, level in levels.items()}
    return select_parts(data, lambda parts: known_parameters(data, None, 0.2, 0.05, None, parts), start)


@pytest.mark.parametrize(
    ("part", "value", "axles"),
    [
        ("friction", 0.2, True),
        ("knee", 0.5, True),
        ("series", 0.2, True),
        ("stiffening", 8.0, True),
        ("smoothing", 3e-3, False),
    ],
)
def test_a_planted_part_is_asked_for(part: str, value: float, axles: bool) -> None:
    # tyres show in the third order only: it takes quiet sensors
    noise = 0.2 if part == "series" else 1.0
    found = _verdict(_planted({part: value}, 3, axles, noise), noise)
    assert part in found.supported
    assert found.gains[part].total > 2


def test_tyres_are_not_taken_for_a_smoothing() -> None:
    """Against the axles the two look alike, and the smoothing's damping would be a fifth too small."""
    found = _verdict(_planted({"series": 0.2}, 5, True, 0.2), 0.2)
    assert "series" in found.supported
    assert "smoothing" not in found.supported


def test_a_plain_plant_asks_for_nothing() -> None:
    """Five parts on three drives: at most one is called by chance (2.5 % each is 0.4)."""
    called = [len(_verdict(_planted({}, seed, True)).supported) for seed in range(3)]
    assert sum(called) <= 1


def test_parts_that_are_nought_change_nothing() -> None:
    data = _planted({}, 1)
    plain = simulated(data, PLAIN)
    assert simulated(data, PLAIN | dict.fromkeys(OPTIONS, 0.0)) == pytest.approx(plain, abs=1e-15)
    assert np.abs(simulated(data, PLAIN | {"series": 2e-4}) - plain).max() < 1e-3 * np.abs(data.roll).max()


def test_the_knee_is_odd_and_leaves_small_motion_alone() -> None:
    rate = np.linspace(-0.6, 0.6, 121)
    beyond = excess(rate)
    assert beyond == pytest.approx(-beyond[::-1], abs=1e-15)
    assert abs(beyond[62]) < 0.05 * rate[62]
    assert beyond[-1] == pytest.approx(0.6 - 0.17, abs=2e-3)


def test_stretches_share_the_motion_and_short_ones_are_not_cut() -> None:
    data = _planted({}, 2)
    spans = spans_of(data)
    energy = [float(np.sum(data.accel[spans == k] ** 2)) for k in range(spans.max() + 1)]
    assert len(energy) == 13
    assert max(energy) < 1.3 * min(energy)
    assert (np.diff(spans[spans >= 0]) >= 0).all()
    short = _data(data.accel[:200], data.roll[:200], data.rate[:200], False)
    assert spans_of(short).max() == 0
    found = _verdict(short)
    assert (found.supported, found.full_weight) == (frozenset(), 0.5)
    assert len(found.models) == 2


def test_gains_are_paired_and_weights_are_soft() -> None:
    rng = np.random.default_rng(1)
    both = 100 * rng.standard_normal(12)
    sure = gain_of(both + 1.0 + 0.1 * rng.standard_normal(12), both)
    assert sure.real
    assert sure.weight > 0.99
    unsure = gain_of(both + 3 * rng.standard_normal(12), both)
    assert not unsure.real
    assert 0.02 < unsure.weight < 0.98
    assert gain_of(both, both).weight == pytest.approx(0.5)
    # by chance alone, one in forty at most
    chance = [gain_of(rng.standard_normal(10), np.zeros(10)).real for _ in range(2000)]
    assert np.mean(chance) < 0.04


def test_models_that_disagree_widen_the_answer() -> None:
    data = _planted({}, 4)
    fit = fit_roll(data, known_parameters(data, None, 0.2, 0.05, None), np.array([data.size]))
    other = replace(fit, handed=fit.handed + np.array([2.0, 0.0, 0.0]))
    mixed = mixed_fit([(fit, 0.75), (other, 0.25)]).mixed
    assert mixed is not None
    assert mixed.mean[0] == pytest.approx(fit.handed[0] + 0.5)
    assert mixed.between[0, 0] == pytest.approx(0.75)
    alone = fit.jacobian @ fit.covariance @ fit.jacobian.T
    assert mixed.covariance[0, 0] == pytest.approx(alone[0, 0] + 0.75)
    assert mixed_fit([(fit, 1.0)]).mixed is None


def test_a_motion_that_runs_away_costs_everything_and_starts_with_more_damping(recwarn) -> None:
    data = _planted({}, seed=3, axles=True)
    known = known_parameters(data, None, 0.2, 0.05, None, options=frozenset({"series"}))
    problem = Problem(data, known)
    # weak dampers on tyres settle within a tenth of a millisecond: read 30 ms earlier, that motion was huge
    wild = {**PLAIN, "a": 460.0, "b": 0.3, "c": 0.28, "series": 0.17, "rate_lag": 0.03}
    weights = named(known, problem.near(wild))
    assert problem.cost(problem.near(wild), weights) == math.inf
    x = problem.standing(wild, weights)
    assert math.isfinite(problem.cost(x, weights))
    assert named(known, x)["b"] > 0.3
    assert not recwarn.list
