"""The quarter car: static load, free motion against the exact solution, step halving, lift-off, terrain spectrum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import welch

from pipelines.models.base_excitation import body_response, response_gain
from pipelines.simulation.quarter_car import (
    QuarterCar,
    Terrain,
    drive_quarter_car,
    off_road_terrain,
    scaled_terrain,
)

CAR = QuarterCar()
LINEAR = replace(CAR, extension_nspm=7000.0, compression_nspm=7000.0)


def rough(seed: int = 1, seconds: float = 30.0) -> Terrain:
    raw = off_road_terrain(16 * seconds + 20, np.random.default_rng(seed))
    return scaled_terrain(raw, CAR, 8.0, seconds, 6.6)


def test_on_flat_ground_nothing_moves_and_the_tyre_carries_the_weight() -> None:
    run = drive_quarter_car(CAR, Terrain(np.zeros(400)), 8.0, 2.0)
    assert not run.accel_sprung.any()
    np.testing.assert_allclose(run.tyre_force, (803 + 98) * 9.80665)
    assert run.off_ground == 0


def test_linear_motion_is_the_matrix_exponential() -> None:
    """A ramp of ground, cubic in between, is a straight line: the exact answer is known."""
    slope = 0.01
    height = np.maximum(np.arange(400) - 1, 0) * 0.05 * slope
    run = drive_quarter_car(LINEAR, Terrain(height), 2.0, 2.0)
    k, b, ku, ms, mu = 63528.0, 7000.0, 204394.0, 803.0, 98.0
    a = np.array([
        [0, 1, 0, 0, 0, 0], [-k / ms, -b / ms, k / ms, b / ms, 0, 0], [0, 0, 0, 1, 0, 0],
        [k / mu, b / mu, -(k + ku) / mu, -b / mu, ku / mu, 0], [0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0],
    ])  # fmt: skip
    # the ground is flat up to the first grid point, 0.025 s from the start; the cubic rounds the corner behind it
    start = np.array([0, 0, 0, 0, 0, 2.0 * slope])
    times = np.arange(60, 200)
    wanted = np.array([a[1] @ (expm(a * (0.005 * row - 0.025)) @ start) for row in times])
    np.testing.assert_allclose(run.accel_sprung[times], wanted, atol=0.02 * float(np.abs(wanted).max()))
    assert float(np.sum(run.accel_sprung) * run.step_s) == pytest.approx(2.0 * slope, rel=0.02)


def test_halving_the_step_changes_nothing_that_matters() -> None:
    car = replace(CAR, friction_n=150.0, cubic_npm3=4e6, stop_m=0.06, stop_npm=3e5)
    terrain = rough().times(1.8)
    coarse = drive_quarter_car(car, terrain, 12.0, 20.0)
    fine = drive_quarter_car(car, terrain, 12.0, 20.0, steps=16)
    assert coarse.off_ground > 0
    for name in ("accel_sprung", "accel_unsprung", "extension"):
        a, b = getattr(coarse, name), getattr(fine, name)
        assert np.sqrt(np.mean((a - b) ** 2)) < 2e-3 * np.std(b), name


def test_the_sprung_equation_closes_on_every_sample() -> None:
    run = drive_quarter_car(CAR, rough(), 8.0, 30.0)
    slope = np.where(run.extension_rate > 0, 3428.0, 10571.0)
    np.testing.assert_allclose(
        803 * run.accel_sprung, -63528 * run.extension - slope * run.extension_rate, atol=1e-8
    )


def test_a_tyre_in_the_air_pushes_nothing() -> None:
    run = drive_quarter_car(CAR, rough().times(3.0), 14.0, 30.0)
    assert run.off_ground > 0.01
    assert run.tyre_force.min() == 0
    np.testing.assert_allclose(np.mean(run.tyre_force == 0), run.off_ground, atol=0.01)


def test_terrain_has_its_spectrum() -> None:
    terrain = off_road_terrain(4000.0, np.random.default_rng(4))
    n, power = welch(terrain.height_m[200:], 1 / terrain.step_m, nperseg=8192)
    wanted = (n**2 + 0.01) ** -1.5 / (1 + n**2)
    for low, high in ((0.1, 0.3), (0.5, 1.0), (2.0, 4.0)):
        inside = (n >= low) & (n < high)
        ratio = np.sum(power[inside]) / np.sum(wanted[inside])
        base = np.sum(power[(n > 0.05) & (n < 1)]) / np.sum(wanted[(n > 0.05) & (n < 1)])
        assert ratio == pytest.approx(base, rel=0.2)


def test_too_short_a_terrain_is_refused() -> None:
    with pytest.raises(ValueError, match="m of terrain"):
        drive_quarter_car(CAR, Terrain(np.zeros(100)), 8.0, 30.0)


def test_model_driven_by_the_hub_gives_the_body() -> None:
    run = drive_quarter_car(CAR, rough(), 8.0, 30.0)
    model = body_response(run.accel_unsprung, 0.005, 803.0, 63528.0, (3428.0, 10571.0))
    assert np.std(model - run.accel_sprung) < 0.003 * np.std(run.accel_sprung)


def test_response_gain_is_the_models_steady_answer() -> None:
    t = np.arange(6000) * 0.005
    for f in (0.7, 1.4, 5.0):
        out = body_response(np.sin(2 * np.pi * f * t), 0.005, 803.0, 63528.0, (7000.0, 7000.0))
        gain = response_gain(np.array([f]), 803.0, 63528.0, 7000.0)[0]
        wanted = np.imag(gain * np.exp(2j * np.pi * f * t))
        np.testing.assert_allclose(out[3000:], wanted[3000:], atol=2e-3 * abs(gain))


def test_model_refuses_nonsense() -> None:
    with pytest.raises(ValueError, match="mass above 0"):
        body_response(np.zeros(10), 0.005, 0.0, 1.0, (1.0, 1.0))
