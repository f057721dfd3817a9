"""The long-run covariance by sums over windows equals the one lag by lag."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map.fit import _long_run_covariance


@pytest.mark.parametrize("lags", [0, 1, 40, 400])
def test_windows_equal_lags(lags: int) -> None:
    rng = np.random.default_rng(3)
    scores = np.cumsum(rng.standard_normal((300, 4)), axis=0)
    centred = scores - scores.mean(axis=0)
    wanted = centred.T @ centred
    for lag in range(1, min(lags, 299) + 1):
        cross = centred[lag:].T @ centred[:-lag]
        wanted += (1 - lag / (lags + 1)) * (cross + cross.T)
    assert _long_run_covariance(scores, lags) == pytest.approx(wanted, rel=1e-9, abs=1e-6)
