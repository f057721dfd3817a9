"""The block solution of a vehicle's drives against one dense one, and against what is known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.hierarchy.parts import Source, make_parts
from pipelines.hierarchy.posterior import Extra, VehiclePosterior, solve
from pipelines.joint.kept import KeptRelations
from pipelines.results import FloatArray
from tests.pipelines.hierarchy.linear_fleet import MEAN, NAMES, STD, dense, draw, kept_of_rows, slopes


def sources_of(kept: tuple[KeptRelations, ...]) -> list[Source]:
    return [Source(f"d{i}", one) for i, one in enumerate(kept)]


def joint(kept: tuple[KeptRelations, ...], rho: float) -> VehiclePosterior:
    return solve(*make_parts(sources_of(kept), rho))


def whole(posterior: VehiclePosterior, count: int) -> tuple[FloatArray, FloatArray]:
    mean = np.concatenate([posterior.mean(i) for i in range(count)])
    blocks = [[posterior.cross(i, j) for j in range(count)] for i in range(count)]
    return mean, np.block(blocks)


def whitened(kept: KeptRelations) -> tuple[FloatArray, FloatArray]:
    """One drive's own posterior, by information."""
    covariance = np.linalg.inv(np.diag(1 / kept.std**2) + kept.rows.T @ kept.rows)
    return covariance @ (kept.mean / kept.std**2 + kept.rows.T @ kept.observed), covariance


@pytest.mark.parametrize("rho", [0.0, 0.4, 0.9])
def test_block_solution_is_the_dense_one(rho: float) -> None:
    drawn = draw(np.random.default_rng(1), 4, rho)
    mean, covariance = whole(joint(drawn.kept, rho), 4)
    expected, spread = dense(drawn.kept, rho)
    unit = np.tile(STD, 4)
    np.testing.assert_allclose((mean - expected) / unit, 0.0, atol=1e-9)
    np.testing.assert_allclose((covariance - spread) / np.outer(unit, unit), 0.0, atol=1e-9)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_one_drive_alone_is_its_own_posterior(rho: float) -> None:
    kept = draw(np.random.default_rng(2), 1, 0.0).kept
    posterior = joint(kept, rho)
    mean, covariance = whitened(kept[0])
    np.testing.assert_allclose((posterior.mean(0) - mean) / STD, 0.0, atol=1e-10)
    np.testing.assert_allclose((posterior.covariance(0) - covariance) / np.outer(STD, STD), 0.0, atol=1e-10)


def only_spring(size: float) -> KeptRelations:
    """Five figures of which one sees the front springs and nothing else."""
    by_u = np.zeros((5, len(NAMES)))
    by_u[0, 0] = size
    return kept_of_rows(by_u, np.zeros(5))


@pytest.mark.parametrize("count", [1, 2, 5, 20])
def test_shared_unknown_shrinks_with_drives_whose_errors_are_their_own(count: int) -> None:
    posterior = joint((only_spring(1.5),) * count, 0.0)
    expected = STD[0] ** 2 / (1 + count * 1.5**2)
    assert posterior.covariance(0)[0, 0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("count", [1, 2, 5, 20])
def test_common_error_is_a_floor(count: int) -> None:
    rho, size = 0.8, 1.5
    posterior = joint((only_spring(size),) * count, rho)
    # the mean of the figures has variance rho + (1 - rho) / n
    information = size**2 / (rho + (1 - rho) / count)
    assert posterior.covariance(0)[0, 0] == pytest.approx(STD[0] ** 2 / (1 + information), rel=1e-9)


def test_linear_functionals_have_the_dense_mean_and_covariance() -> None:
    rng = np.random.default_rng(3)
    drawn = draw(rng, 3, 0.5)
    posterior = joint(drawn.kept, 0.5)
    weights = rng.standard_normal((2, 3, len(NAMES))) / STD
    value, covariance = posterior.functional({i: weights[:, i] for i in range(3)})
    expected, spread = dense(drawn.kept, 0.5)
    flat = weights.reshape(2, -1)
    np.testing.assert_allclose(value, flat @ expected, rtol=1e-8)
    np.testing.assert_allclose(covariance, flat @ spread @ flat.T, rtol=1e-8)


def test_what_drives_share_cancels_in_their_difference() -> None:
    posterior = joint((only_spring(0.1), only_spring(0.1)), 0.0)
    spring = np.zeros(len(NAMES))
    spring[0] = 1.0
    _, alone = posterior.functional({0: spring})
    _, between = posterior.functional({0: -spring, 1: spring})
    assert alone[0, 0] > 0.9 * STD[0] ** 2
    assert between[0, 0] == pytest.approx(0.0, abs=1e-6)


def test_vehicle_file_counts_once() -> None:
    kept = only_spring(2.0)
    stated = replace(kept, source=("vehicle file",) * 5)
    one, many = joint((stated,), 0.8), joint((stated,) * 10, 0.8)
    assert many.covariance(3)[0, 0] == pytest.approx(one.covariance(0)[0, 0], rel=1e-9)
    assert joint((kept,) * 10, 0.0).covariance(3)[0, 0] < 0.3 * one.covariance(0)[0, 0]


def test_trend_is_found_as_an_extra_unknown() -> None:
    rng = np.random.default_rng(4)
    truth, kept = 400.0, []
    for year in range(8):
        by_u = np.zeros((5, len(NAMES)))
        by_u[0, 0] = 30.0
        moved = np.zeros(len(NAMES))
        moved[0] = truth * year / STD[0]
        kept.append(kept_of_rows(by_u, by_u @ moved + rng.standard_normal(5)))
    extra = Extra("trend", 2000.0, {f"d{i}": {"spring_front": float(i)} for i in range(8)})
    parts, names = make_parts(sources_of(tuple(kept)), 0.0, [extra])
    value, std = solve(parts, names, [extra]).extra("trend")
    assert std == pytest.approx(30.0 / np.sqrt(np.sum((np.arange(8) - 3.5) ** 2)), rel=0.02)
    assert abs(value - truth) < 4 * std
    with pytest.raises(ValueError, match="no extra unknown"):
        solve(parts, names, [extra]).extra("another")


def test_joined_intervals_hold_the_truth() -> None:
    rng = np.random.default_rng(5)
    z, narrower = [], []
    for _ in range(60):
        drawn = draw(rng, 6, 0.6)
        posterior = joint(drawn.kept, 0.6)
        alone = whitened(drawn.kept[2])[1]
        spread = np.sqrt(np.diag(posterior.covariance(2)))
        z.append((posterior.mean(2) - drawn.truth[2]) / spread)
        narrower.append(spread / np.sqrt(np.diag(alone)))
    held = np.mean(np.abs(np.array(z)) < 1.96)
    assert 0.91 < held < 0.985
    assert np.sqrt(np.mean(np.square(z))) == pytest.approx(1.0, abs=0.12)
    shared, own = (float(np.mean(np.array(narrower)[:, i])) for i in (1, 2))
    assert shared < 0.75
    assert own <= 1.0


def test_what_most_drives_knew_before_counts() -> None:
    rng = np.random.default_rng(6)
    kept = list(draw(rng, 3, 0.0, [slopes(rng)] * 3).kept)
    other = MEAN.copy()
    other[0] += 5 * STD[0]
    other[2] += 100.0
    kept[1] = replace(kept[1], mean=other)
    parts, _ = make_parts(sources_of(tuple(kept)), 0.0)
    assert parts[1].mean[0] == MEAN[0]
    # a load that is stated for one drive is no habit of the vehicle's
    assert parts[1].mean[2] == other[2]
    assert parts[1].own[2] == 1.0
    assert parts[0].own[2] < 1.0
