"""The roll fit beside the bound of one manoeuvre: what it claims is what the manoeuvre allows (`benchmarks/roll_limit.py` has a thousand)."""

from __future__ import annotations

import numpy as np

from benchmarks.roll_limit import TRUTH, bound, parameters, recorded, sine_with_dwell
from pipelines.estimators.roll_map.fit import fit_roll

RUNS = 8


def test_what_it_claims_is_near_the_bound_and_holds() -> None:
    push = sine_with_dwell()
    least, _ = bound(push)
    known = parameters()
    claimed, missed = [], []
    for seed in range(RUNS):
        fit = fit_roll(recorded(push, np.random.default_rng([7, seed])), known, np.array([len(push)]))
        assert fit.converged
        claimed.append([fit.std(name) for name in "abc"])
        missed.append([fit.values[name] - getattr(TRUTH, name) for name in "abc"])
    over = np.mean(claimed, axis=0) / least
    assert (over > 0.95).all()
    assert (over < 1.1).all()
    # eight of each: chance alone stays below 4.5 standard deviations
    assert np.abs(np.array(missed) / claimed).max() < 4.5
