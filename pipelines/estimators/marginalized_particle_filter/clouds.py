"""An honest spread for a particle filter: what several clouds on the same data say together.

A cloud of finitely many particles that is resampled at every sample loses its outlying ones, and then states too small a
spread around a mean that chance has moved: the published filter's own 95 % interval holds the truth in half to 85 % of runs
on a plant as modelled. Clouds that differ in nothing but their random numbers show both, without the truth. By the law of
total variance, a mixture of them has the spread W + B of the filter without that loss (W the mean of their variances, B the
variance of their means), and the mean of r of them lies a further B / r away from the mixture's.
"""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray


def pooled_spread(means: FloatArray, stds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation (..., k) of r >= 2 clouds (..., r, k) on the same data: W + (1 + 1/r) B.

    Raises ValueError for fewer than two clouds.
    """
    if means.shape != stds.shape or means.ndim < 2 or means.shape[-2] < 2:
        raise ValueError(f"at least two clouds on the same data are needed, not {means.shape}")
    within, between = np.mean(stds**2, axis=-2), np.var(means, axis=-2, ddof=1)
    return np.mean(means, axis=-2), np.asarray(np.sqrt(within + (1 + 1 / means.shape[-2]) * between))
