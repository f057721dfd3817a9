"""Moves of the particles, the mirror image, and many runs at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.filters.marginalized_particle.clouds import cloud_of, mirror_height
from pipelines.filters.marginalized_particle.filter import run_particles
from pipelines.filters.marginalized_particle.layout import WIDTH5
from pipelines.filters.marginalized_particle.monte_carlo import run_many
from pipelines.filters.marginalized_particle.moves import (
    cloud_root,
    from_coordinates,
    smooth,
    to_coordinates,
)
from pipelines.filters.marginalized_particle.records import BETTER, PUBLISHED, Cloud
from tests.pipelines.test_marginalized_particle import NOISE, STEP, THETA, drive, prior


def coordinates(table: np.ndarray) -> np.ndarray:
    """(N, 11) of each row."""
    out = np.zeros((len(table), 11))
    for row, values in zip(table, out, strict=True):
        to_coordinates.py_func(row, values)  # type: ignore[attr-defined]
    return out


def cloud_table(height: float, spread: float, rng: np.random.Generator) -> np.ndarray:
    """(20000, WIDTH5): rows whose parameters and states hang together."""
    z = rng.standard_normal((20_000, 11))
    table = np.zeros((20_000, WIDTH5))
    table[:, 2] = height * np.exp(spread * z[:, 2])
    table[:, 0] = 9e4 * table[:, 2] * np.exp(0.01 * z[:, 0])
    table[:, 1] = 7e3 * table[:, 2] * np.exp(0.02 * z[:, 1] + 0.01 * z[:, 0])
    table[:, 3], table[:, 4], table[:, 5] = 1800 * np.exp(0.05 * z[:, 3]), 500.0, 0.0
    table[:, 14:19] = 0.01 * z[:, 6:] + 0.02 * z[:, [2]]
    return table


def test_the_smoothed_move_keeps_mean_and_covariance_also_of_the_states() -> None:
    rng = np.random.default_rng(0)
    table = cloud_table(0.8, 0.05, rng)
    before = coordinates(table)
    cloud = cloud_root(table, np.full(len(table), 1 / len(table)), len(table), 5, 1)
    assert not cloud[2]
    smooth(rng, table, len(table), cloud, 0.4, 1)
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
    for _ in range(50):
        cloud = cloud_root(table, np.full(len(table), 1 / len(table)), len(table), 5, 1)
        assert cloud[2]
        smooth(rng, table, len(table), cloud, 0.4, 1)
    left = np.log(table[:, 2] / line)
    assert left.min() >= 0
    assert left.mean() == pytest.approx(distance.mean(), rel=0.06)
    assert left.std() == pytest.approx(distance.std(), rel=0.06)


def test_coordinates_come_back() -> None:
    row, out, back = np.arange(1.0, WIDTH5 + 1), np.zeros(11), np.zeros(WIDTH5)
    to_coordinates.py_func(row, out)  # type: ignore[attr-defined]
    from_coordinates.py_func(out, back)  # type: ignore[attr-defined]
    np.testing.assert_allclose(back[:6], row[:6])
    np.testing.assert_array_equal(back[14:19], row[14:19])


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
