"""Quantiles without sorting: to the last bit what numpy says, whatever the values are."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.quantiles import at_least, median_step, medians, quantile, spread_at_least

SHARES = (0.0, 0.005, 0.01, 0.02, 0.1, 0.5, 0.9, 0.98, 0.995, 1.0)


def columns() -> list[np.ndarray]:
    rng = np.random.default_rng(5)
    n = 20_001
    rest = np.zeros(n)
    rest[-n // 3 :] = rng.standard_normal(len(rest[-n // 3 :]))
    return [
        rng.standard_normal(n),
        rng.uniform(-1, 1, n + 1),
        np.round(rng.standard_normal(n), 1),
        np.arange(n, dtype=float)[::-1].copy(),
        np.full(n, 3.0),
        rest,
        # what the sample sees is not what there is
        np.where(np.arange(n) % (n // 1009) == 0, 1e9, rng.standard_normal(n)),
        rng.standard_normal(50),
        np.array([1.0]),
    ]


@pytest.mark.parametrize("number", range(len(columns())))
def test_equal_to_numpy(number: int) -> None:
    values = columns()[number]
    for share in SHARES:
        assert quantile(values, share) == np.quantile(values, share)
        assert at_least(values, share) <= np.quantile(values, share)
        assert -at_least(-values, share) >= np.quantile(values, 1 - share) - 1e-12
    wide = np.quantile(values, 0.98) - np.quantile(values, 0.02)
    assert spread_at_least(values, 0.02) <= wide + 1e-12


def test_the_bound_is_usually_near() -> None:
    values = columns()[0]
    assert spread_at_least(values, 0.02) > 0.7 * (np.quantile(values, 0.98) - np.quantile(values, 0.02))
    assert at_least(values[:2], 0.5) == -np.inf


@pytest.mark.parametrize("count", [2, 3, 5000, 5001])
def test_the_median_step(count: int) -> None:
    time_ns = np.cumsum(np.random.default_rng(1).integers(1, 10**7, count)) + 1_700_000_000_000_000_000
    assert median_step(time_ns) == np.median(np.diff(time_ns))


@pytest.mark.parametrize("rows", [1, 2, 3, 4])
def test_medians_of_columns(rows: int) -> None:
    values = np.random.default_rng(rows).standard_normal((rows, 50))
    np.testing.assert_allclose(medians(values), np.median(values, axis=0), rtol=1e-15)
    values[0, 3] = np.nan
    assert np.isnan(medians(values)).tolist() == [k == 3 for k in range(50)]
