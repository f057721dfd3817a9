"""The refined posterior: equal to brute force from the prior, free of what the first run did wrong, honest over many drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.filters.marginalized_particle.clouds import uniform_cloud
from pipelines.filters.marginalized_particle.filter import run_particles
from pipelines.filters.marginalized_particle.records import BETTER, Cloud, Noise, Offsets
from pipelines.filters.marginalized_particle.refine import (
    UniformPrior,
    _coordinates,
    _Proposal,
    _theta,
    refine,
)
from tests.pipelines.test_marginalized_particle import NOISE, RANGES, STEP, THETA, drive, prior

STILL = replace(BETTER, threshold=0.0, kernel=0.0, adaptive=False, most=60_000)


@pytest.mark.parametrize("spread", [0.0, 0.05])
def test_refined_is_brute_force(spread: float) -> None:
    """Mean, spread and evidence of 60 000 draws of the prior, weighed by the exact likelihood of a short and noisy drive."""
    rng = np.random.default_rng(0)
    y, accel = drive(40, rng)
    given = UniformPrior(RANGES, (1800.0, 1800.0 * spread), (500.0, 500.0 * spread))
    start = uniform_cloud(
        60_000, RANGES, mass_kg=given.mass_kg, roll_inertia_kgm2=given.roll_inertia_kgm2, rng=rng
    )
    noise = Noise(5 * NOISE.roll_rad, 5 * NOISE.roll_rate_radps, 5 * NOISE.accel_mps2)
    exact = run_particles(y, accel, STEP, start, noise, STILL, rng)
    assert exact.effective[-1] > 300
    thin = Cloud(start.theta[:4000], start.weights[:4000])
    first = run_particles(y, accel, STEP, thin, noise, replace(BETTER, wanted=300), rng)
    found = refine(y, accel, STEP, first.final, given, noise, BETTER, rng, count=4000, rounds=3)
    assert found.effective > 800
    assert found.log_evidence == pytest.approx(exact.evidence, abs=0.25)
    np.testing.assert_allclose((found.run.mean[-1] - exact.mean[-1]) / exact.std[-1], 0.0, atol=0.2)
    np.testing.assert_allclose(found.run.std[-1], exact.std[-1], rtol=0.2)


def test_a_first_run_that_was_wrong_does_no_harm() -> None:
    """A cloud that is far too sharp, and one off by 8 %: after some rounds the same posterior."""
    rng = np.random.default_rng(1)
    y, accel = drive(150, rng)
    given = UniformPrior(RANGES, 1800.0, 500.0)
    good = run_particles(y, accel, STEP, prior(4000, rng), NOISE, BETTER, rng).final
    right = refine(y, accel, STEP, good, given, NOISE, BETTER, rng, count=4000).run
    middle = good.theta.mean(axis=0)
    sharp = Cloud(middle + 0.3 * (good.theta - middle), good.weights)
    shifted = good.theta.copy()
    shifted[:, :3] *= 1.08
    for first in (sharp, Cloud(shifted, good.weights)):
        found = refine(y, accel, STEP, first, given, NOISE, BETTER, rng, count=4000, rounds=4).run
        np.testing.assert_allclose((found.mean[-1] - right.mean[-1]) / right.std[-1], 0.0, atol=0.2)
        np.testing.assert_allclose(found.std[-1], right.std[-1], rtol=0.2)


def test_intervals_hold_the_truth() -> None:
    """100 drives of random vehicles, also close to the mirror line: 95 % intervals hold 88 or more (three deviations of a count)."""
    held = []
    offsets = Offsets(0.006, 0.006, 0.15)
    for seed in range(100):
        rng = np.random.default_rng([9, seed])
        theta = THETA.copy()
        theta[:3] = [rng.uniform(*RANGES[name]) for name in ("K", "D", "h")]
        y, accel = drive(100, rng, theta, offsets=(0.006 * rng.standard_normal(), 0.006 * rng.standard_normal(), 0.15 * rng.standard_normal()))  # fmt: skip
        settings = replace(BETTER, wanted=300, most=1500, offsets=offsets)
        first = run_particles(y, accel, STEP, prior(1500, rng), NOISE, settings, rng).final
        run = refine(
            y, accel, STEP, first, UniformPrior(RANGES, 1800.0, 500.0), NOISE, settings, rng, count=800
        ).run
        low, _, high = run.quantiles[-1].T
        held.append((low <= theta[:3]) & (theta[:3] <= high))
    assert (np.sum(held, axis=0) >= 88).all()


def test_proposal_is_a_density() -> None:
    """Its draws weighed by a uniform density over its own: that density's integral is one, also folded at the mirror line."""
    rng = np.random.default_rng(0)
    cloud = uniform_cloud(
        4000, {"K": (4e4, 6e4), "D": (3e3, 5e3), "h": (0.53, 0.75)},
        mass_kg=1800.0, roll_inertia_kgm2=500.0, above_mirror=True, rng=rng,
    )  # fmt: skip
    given = UniformPrior({"K": (4.5e4, 5.5e4), "D": (3.5e3, 4.5e3), "h": (0.53, 0.7)}, 1800.0, 500.0)
    proposal = _Proposal(cloud, fold=True)
    theta = proposal.draw(200_000, rng)
    weights = np.exp(given.log_density(theta) - proposal.log_density(theta))
    assert weights.mean() == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(_theta(_coordinates(theta)), theta)


def test_refuses_a_first_run_outside_the_prior() -> None:
    rng = np.random.default_rng(0)
    y, accel = drive(20, rng)
    far = UniformPrior({**RANGES, "K": (2e6, 3e6)}, 1800.0, 500.0)
    with pytest.raises(ValueError, match="within the prior"):
        refine(y, accel, STEP, prior(50, rng), far, NOISE, BETTER, rng, count=50)
