"""Draws of a whole drive's posterior, all its relations joined, beside long chains of a plain sampler that agree with each other.

Longer chains, of deflections too: `benchmarks/joint_mcmc.py`.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.joint_mcmc import SHOWN, posterior_of
from pipelines.joint.posterior import log_density, values_at
from pipelines.joint.sampling.sample import sample
from pipelines.joint.vehicle.outputs import outputs_of
from tests.pipelines.long_mcmc import figures_of, run_chains


def test_draws_of_a_slalom_with_a_navigation_unit_are_those_of_long_chains() -> None:
    joint = posterior_of("slalom", "ins", 3)
    density = log_density(joint)
    rng = np.random.default_rng(1)
    drawn = sample(density, [(joint.u, joint.covariance)], rng)
    assert drawn.effective > 500
    starts = np.random.default_rng(2).multivariate_normal(joint.u, 0.5 * joint.covariance, 2000)
    starts = starts[np.isfinite(density(starts))][:64]
    ran = run_chains(density, starts, joint.covariance, rng, 12000, thin=20)
    long = outputs_of(values_at(joint.known, ran.flat()), joint.given)
    short = outputs_of(values_at(joint.known, drawn.draws), joint.given)
    for name in SHOWN:
        chains = figures_of(np.broadcast_to(long[name], len(ran.flat())).reshape(ran.draws.shape[:2]))
        assert chains.r_hat < 1.1
        own = 1 / np.sqrt(drawn.effective)
        x = (short[name] - chains.mean) / chains.std
        error = np.hypot(chains.error_mean / chains.std, own)
        assert x.mean() == pytest.approx(0, abs=4 * error)
        # sampled spreads came out up to 7 % too narrow, and the verdict makes that good
        assert x.std() == pytest.approx(1, abs=0.07 + 4 * np.hypot(chains.error_std / chains.std, 0.7 * own))
        for end, truth, sigma in zip(
            np.quantile(x, (0.025, 0.975)),
            (chains.low, chains.high),
            (chains.error_low, chains.error_high),
            strict=True,
        ):
            wide = 4 * np.hypot(sigma / chains.std, 2.7 * own)
            assert end == pytest.approx((truth - chains.mean) / chains.std, abs=0.1 + wide)
