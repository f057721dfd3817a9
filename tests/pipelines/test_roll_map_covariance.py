"""How far the motion's parameters may be off: long-run covariance by windows, colour of the innovations, chance."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map.spread import coloured_covariance, honest_covariance, long_run_covariance


@pytest.mark.parametrize("lags", [0, 1, 40, 400])
def test_windows_equal_lags(lags: int) -> None:
    rng = np.random.default_rng(3)
    scores = np.cumsum(rng.standard_normal((300, 4)), axis=0)
    centred = scores - scores.mean(axis=0)
    wanted = centred.T @ centred
    for lag in range(1, min(lags, 299) + 1):
        cross = centred[lag:].T @ centred[:-lag]
        wanted += (1 - lag / (lags + 1)) * (cross + cross.T)
    assert long_run_covariance(scores, lags) == pytest.approx(wanted, rel=1e-9, abs=1e-6)


def _sums(colour: float, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Scores' covariance as told by `coloured_covariance`, in the mean, and as it is over many draws of coloured noise."""
    n = 400
    t = np.arange(n) / n
    taught = np.stack([np.sin(2 * np.pi * 3 * t), np.sin(2 * np.pi * 90 * t)])[:, :, None]
    told, sums = np.zeros((2, 2)), []
    for _ in range(count):
        white = rng.standard_normal(n + 50)
        noise = white.copy()
        for k in range(1, len(noise)):
            noise[k] = colour * noise[k - 1] + white[k] * np.sqrt(1 - colour**2)
        nu = noise[50:, None]
        told += coloured_covariance(taught, nu) / count
        sums.append((taught * nu).sum(axis=(1, 2)))
    return told, np.cov(np.array(sums).T)


@pytest.mark.parametrize("colour", [0.0, 0.5])
def test_the_colour_of_the_innovations_counts_where_a_parameter_looks(colour: float) -> None:
    told, real = _sums(colour, 400, np.random.default_rng(1))
    assert np.diag(told) == pytest.approx(np.diag(real), rel=0.2)
    assert bool(told[0, 0] > 1.5 * told[1, 1]) is (colour > 0)


def test_chance_alone_does_not_widen() -> None:
    """White scores of nine parameters over fifteen stretches: within a fifth of Laplace's spread, not twice it."""
    rng = np.random.default_rng(2)
    ratios = []
    for _ in range(40):
        slopes = rng.standard_normal((9, 480, 1))
        nu = rng.standard_normal((480, 1))
        information = slopes[:, :, 0] @ slopes[:, :, 0].T
        white, wide = honest_covariance(
            information,
            np.full(9, 1e-9),
            coloured_covariance(slopes, nu),
            long_run_covariance((slopes * nu)[:, :, 0].T, 31),
            1.5 * 480 / 32,
        )
        ratios.append(np.sqrt(np.diag(wide) / np.diag(white)).mean())
    assert 1.0 <= np.mean(ratios) < 1.2
