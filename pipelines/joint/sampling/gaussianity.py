"""How far a posterior is from the Gaussian at its mode, where it matters for the outputs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipelines.results import FloatArray

LogDensity = Callable[[FloatArray], FloatArray]
"""(n, k) unknowns in prior standard deviations -> (n,) log of prior N(0, I) times likelihood, up to a constant; -inf
beyond a bound. Vectorised over rows."""

STEPS = np.array([-2.0, -1.0, 1.0, 2.0])
"""Where it is probed, in standard deviations along each direction."""


def quiet(log_density: LogDensity, rows: FloatArray) -> FloatArray:
    """(n,) of (n, k), with what is not a number (a root of a negative figure, far out) taken as impossible: -inf."""
    with np.errstate(all="ignore"):
        value = np.asarray(log_density(rows), dtype=np.float64)
    return np.where(np.isnan(value), -np.inf, value)


def not_gaussian(
    log_density: LogDensity, mode: FloatArray, covariance: FloatArray, directions: FloatArray
) -> float:
    """Worst difference of the log density from the mode's quadratic, at 1 and 2 standard deviations to either side.

    mode: (k,). covariance: (k, k). directions: (d, k); along an output with gradient g it is C g / sqrt(g' C g), one
    standard deviation long. 0: Gaussian there; inf: a bound lies within two standard deviations. One call of log_density.
    """
    directions = np.atleast_2d(directions)
    probes = (mode + STEPS[:, None, None] * directions).reshape(-1, mode.size)
    value = quiet(log_density, np.vstack([mode, probes]))
    length = np.einsum("dk,kd->d", directions, np.linalg.solve(covariance, directions.T))
    quadratic = -0.5 * STEPS[:, None] ** 2 * length
    gap = (value[1:] - value[0]).reshape(quadratic.shape) - quadratic
    return float(np.max(np.abs(gap), initial=0.0))
