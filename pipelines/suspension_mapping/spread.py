"""How far a mapped force may be off at an instant: the residual's variance over the state, and how good 95 % is."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.suspension_mapping.data import MapData, rate_of

MOST_FACTOR = 3.0
COVERAGE = 0.95
QUANTILE = 1.959964


def state_of(data: MapData, wheel: str) -> FloatArray:
    """What the residual's variance grows with (n, 5), in the order of `record.SPREAD`; 0 where a signal is missing."""
    c = data.columns
    zero = np.zeros(data.size)
    a_y, a_x = c.get("accel_y", zero), c.get("accel_x", zero)
    deflection = c.get(f"suspension_deflection_{wheel}", zero)
    quick = rate_of(a_y, data.starts, data.rate_hz)
    hop = rate_of(deflection, data.starts, data.rate_hz)
    return np.column_stack((np.ones(data.size), a_y**2, a_x**2, quick**2, hop**2))


def fit_spread(residuals: FloatArray, state: FloatArray) -> tuple[tuple[float, ...], float]:
    """Coefficients (5,) >= 0 of the variance, and the factor that makes 1.96 standard deviations hold 95 %.

    residuals (n, k): held-out residuals of each row, by several ways of leaving out. state (n, 5).
    """
    from scipy.optimize import nnls

    square = np.mean(residuals**2, axis=1)
    typical = max(float(np.mean(square)), 1e-6)
    # a few wild squares must not make the law
    square = np.minimum(square, 16 * typical)
    size = np.sqrt(np.maximum(np.mean(state**2, axis=0), 1e-12))
    found = np.ones(0)
    weight = np.full(len(square), 1 / typical)
    for _ in range(3):
        scaled = state / size * weight[:, None]
        found, _ = nnls(scaled, square * weight)
        # variances: the error of a square grows with it
        weight = 1 / np.maximum(state / size @ found, 0.1 * typical)
    coefficients = found / size
    coefficients[0] = max(coefficients[0], 0.05 * typical)
    std = np.sqrt(state @ coefficients)
    reach = float(np.quantile(np.abs(residuals) / std[:, None], COVERAGE)) / QUANTILE
    return tuple(float(x) for x in coefficients), min(max(reach, 0.8), MOST_FACTOR)
