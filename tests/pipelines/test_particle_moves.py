"""Moves of the particles, the mirror image, and many runs at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.jit import kernel
from pipelines.filters.lanes import LANES, random_state
from pipelines.filters.marginalized_particle.clouds import cloud_of, mirror_height
from pipelines.filters.marginalized_particle.filter import run_particles
from pipelines.filters.marginalized_particle.layout import STATE, WEIGHT, WIDTH5, columns_of, tiled
from pipelines.filters.marginalized_particle.monte_carlo import run_many
from pipelines.filters.marginalized_particle.moves import (
    cloud_root,
    from_coordinates,
    smooth,
    to_coordinates,
)
from pipelines.filters.marginalized_particle.records import BETTER, PUBLISHED, Cloud
from tests.pipelines.test_marginalized_particle import NOISE, STEP, THETA, drive, prior

STATES = 5


@kernel
def _coordinates(table: np.ndarray, out: np.ndarray) -> None:
    for tile in range(table.shape[0]):
        to_coordinates(table[tile], STATES, out[tile])


@kernel
def _back(values: np.ndarray, table: np.ndarray) -> None:
    for tile in range(table.shape[0]):
        from_coordinates(values[tile], STATES, table[tile])


@kernel
def _smooth(state: np.ndarray, table: np.ndarray, mean: np.ndarray, root: np.ndarray, unfolded: bool) -> None:
    work = (np.zeros((6 + STATES) * LANES), np.zeros(6 * LANES))
    for tile in range(table.shape[0]):
        smooth(state, table[tile], (mean, root, unfolded), 0.4, 1, work)


def coordinates(table: np.ndarray) -> np.ndarray:
    """(N, 11) of each particle of a table whose tiles are full."""
    out = np.zeros((len(table), (6 + STATES) * LANES))
    _coordinates(table, out)
    return columns_of(out, len(table) * LANES, 6 + STATES)


def moved(table: np.ndarray, rng: np.random.Generator) -> bool:
    """The smoothed move of all particles, in place, all alike in weight; whether the cloud was unfolded."""
    count = len(table) * LANES
    table[:, WEIGHT : WEIGHT + LANES] = 4 / count
    mean, root, unfolded = cloud_root(table, count, 0.25, 0, STATES, 1)
    _smooth(random_state(rng), table, mean, root, unfolded)
    return unfolded


def cloud_table(height: float, spread: float, rng: np.random.Generator) -> np.ndarray:
    """(19968, 21): particles whose parameters and states hang together."""
    z = rng.standard_normal((312 * LANES, 11))
    table = np.zeros((312 * LANES, 21))
    table[:, 2] = height * np.exp(spread * z[:, 2])
    table[:, 0] = 9e4 * table[:, 2] * np.exp(0.01 * z[:, 0])
    table[:, 1] = 7e3 * table[:, 2] * np.exp(0.02 * z[:, 1] + 0.01 * z[:, 0])
    table[:, 3], table[:, 4], table[:, 5] = 1800 * np.exp(0.05 * z[:, 3]), 500.0, 0.0
    table[:, STATE // LANES :] = 0.01 * z[:, 6:] + 0.02 * z[:, [2]]
    return table


def test_the_smoothed_move_keeps_mean_and_covariance_also_of_the_states() -> None:
    rng = np.random.default_rng(0)
    table = tiled(cloud_table(0.8, 0.05, rng), 312, WIDTH5)
    before = coordinates(table)
    assert not moved(table, rng)
    after = coordinates(table)
    assert np.abs(after - before)[:, :4].min(axis=1).max() > 0.0
    spread = before.std(axis=0) + 1e-12
    np.testing.assert_allclose((after.mean(axis=0) - before.mean(axis=0)) / spread, 0.0, atol=0.02)
    scale = np.outer(spread, spread)
    np.testing.assert_allclose(np.cov(after[:, :6].T) / scale[:6, :6], np.cov(before[:, :6].T) / scale[:6, :6], atol=0.04)  # fmt: skip
    both = np.cov(before.T)[6:, :6] / scale[6:, :6]
    np.testing.assert_allclose(np.cov(after.T)[6:, :6] / scale[6:, :6], both, atol=0.04)
    assert np.abs(both).max() > 0.7
    np.testing.assert_array_equal(after[:, 5], 0.0)
    np.testing.assert_allclose(after[:, 4], np.log(500.0))


def test_a_cloud_on_the_mirror_line_stays_there() -> None:
    """A half normal of log(h / h*) stays one under fifty moves: reflecting alone would push it away."""
    rng = np.random.default_rng(1)
    table = cloud_table(1.0, 0.0, rng)
    table[:, 3] = 1800.0
    line = float(mirror_height(np.array(1800.0), np.array(500.0)))
    distance = np.abs(0.1 * rng.standard_normal(len(table)))
    table[:, :3] *= (line * np.exp(distance))[:, None]
    tiles = tiled(table, 312, WIDTH5)
    for _ in range(50):
        assert moved(tiles, rng)
    left = np.log(columns_of(tiles, len(table), 3)[:, 2] / line)
    assert left.min() >= 0
    assert left.mean() == pytest.approx(distance.mean(), rel=0.06)
    assert left.std() == pytest.approx(distance.std(), rel=0.06)


def test_coordinates_are_what_they_say_and_come_back() -> None:
    columns = cloud_table(0.8, 0.3, np.random.default_rng(2))
    table, back = tiled(columns, 312, WIDTH5), np.zeros((312, WIDTH5))
    values = np.zeros((312, (6 + STATES) * LANES))
    _coordinates(table, values)
    k, d, h, m, i_x, z = columns[:, :6].T
    expected = [np.log(k / h), np.log(d / h), np.log(h / np.sqrt(i_x / m)), np.log(m), np.log(i_x), z]
    np.testing.assert_allclose(columns_of(values, len(columns), 6).T, expected, rtol=1e-13, atol=1e-15)
    _back(values, back)
    found = columns_of(back, len(columns), 21)
    np.testing.assert_allclose(found[:, :6], columns[:, :6], rtol=1e-13)
    np.testing.assert_array_equal(found[:, STATE // LANES :], columns[:, STATE // LANES :])


def test_mirror_image_has_the_same_evidence() -> None:
    """(K, D, h) times I_x / (m h²): the exact mirror solution, also with the input above the roll axis."""
    rng = np.random.default_rng(0)
    y, accel = drive(80, rng)
    theta = THETA.copy()
    theta[5] = 0.2
    image = theta.copy()
    image[:3] *= theta[4] / (theta[3] * theta[2] ** 2)
    settings = replace(BETTER, above_mirror=False)
    evidences = [
        run_particles(y, accel, STEP, Cloud(row[None], np.ones(1)), NOISE, settings, rng).evidence
        for row in (theta, image)
    ]
    assert evidences[0] == pytest.approx(evidences[1], rel=1e-9)
    folded = cloud_of(image[None, :3], mass_kg=1800.0, roll_inertia_kgm2=500.0, rng=rng)
    np.testing.assert_allclose(folded.theta[0, :3], theta[:3])


def test_above_the_mirror_line_and_below() -> None:
    rng = np.random.default_rng(3)
    y, accel = drive(100, rng)
    for settings in (BETTER, replace(PUBLISHED, above_mirror=True)):
        run = run_particles(y, accel, STEP, prior(1500, rng), NOISE, settings, rng)
        theta = run.final.theta
        assert (theta[:, 2] >= 0.999999 * mirror_height(theta[:, 3], theta[:, 4])).all()
    free = prior(3000, rng)
    free.theta[:, 2] = rng.uniform(0.25, 1.2, 3000)
    free.theta[:, :2] = THETA[:2] / THETA[2] * free.theta[:, [2]] * rng.uniform(0.9, 1.1, (3000, 2))
    run = run_particles(y, accel, STEP, free, NOISE, replace(PUBLISHED, walk=(1.0, 1.0, 1e-5)), rng)
    heights = run.final.theta[:, 2]
    assert (heights < 0.45).any()
    assert (heights > 0.65).any()


def test_many_runs_are_the_same_on_one_thread_and_two() -> None:
    def make(workers: int) -> list[np.ndarray]:
        runs = run_many(
            lambda i, rng: drive(40 + i, rng),
            lambda i, rng: prior(100, rng),
            6,
            STEP,
            NOISE,
            replace(PUBLISHED, wanted=50, most=100),
            np.random.default_rng(9),
            workers=workers,
        )
        return [run.mean for run in runs]

    for one, two in zip(make(1), make(2), strict=True):
        np.testing.assert_array_equal(one, two)
