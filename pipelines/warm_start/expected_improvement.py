"""Expected improvement for a minimum (Algorithm 1's acquisition): which point to try next.

The paper prints A_EI = σ (z Φ(z) + φ(z)) with z = (J(θ+) - μ) / σ and takes its smallest value; the improvement is to be as
large as can be, so that the sign has slipped. Here it is maximised.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from pipelines.results import FloatArray


class Predictor(Protocol):
    """What gives mean and standard deviation at points, as `GaussianProcess` does."""

    def predict(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(m,) each, at points (m, d)."""
        ...


def expected_improvement(mean: FloatArray, std: FloatArray, best: float) -> FloatArray:
    """(m,) mean of max(best - J, 0) for J normal with mean and std (m,); where std is zero, the improvement itself."""
    from scipy.special import ndtr

    spread = np.where(std > 0, std, 1.0)
    z = (best - mean) / spread
    density = np.exp(-0.5 * z**2) / math.sqrt(2 * math.pi)
    value = spread * (z * ndtr(z) + density)
    return np.where(std > 0, np.maximum(value, 0.0), np.maximum(best - mean, 0.0))


def best_candidate(
    process: Predictor, lowest: float, around: FloatArray, count: int, rng: np.random.Generator
) -> FloatArray:
    """(d,) the point of the unit box with the largest expected improvement among `count` drawn in it and as many near it.

    around: (d,), the best point so far. Then the search closes in on the best in three rounds.
    """
    d = len(around)
    spread = np.exp(rng.uniform(np.log(1e-3), np.log(0.3), (count // 2, 1)))
    near = np.clip(around + spread * rng.standard_normal((count // 2, d)), 0.0, 1.0)
    points = np.vstack((rng.random((count - count // 2, d)), near))
    point, value = around, -1.0
    for width in (0.05, 0.01, 0.002):
        mean, std = process.predict(points)
        gain = expected_improvement(mean, std, lowest)
        at = int(np.argmax(gain))
        if gain[at] > value:
            point, value = points[at], float(gain[at])
        points = np.clip(point + width * rng.standard_normal((100, d)), 0.0, 1.0)
    return np.asarray(point)
