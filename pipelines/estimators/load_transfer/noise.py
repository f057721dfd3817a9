"""What noise in the horizontal accelerations does to the fit that takes them for what loads the struts.

A column with noise of variance v makes its own coefficient smaller, and shifts all others: in first order by (X'WX)⁻¹ N β,
N with v times the sum of the weights on the column's diagonal. A drive that hardly turns is open to it, one with bends is
not. The size of the noise is not known well enough to take it out: the shift goes into the spread.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.estimators.load_transfer.batch import ACROSS, ALONG, LOOSE, TOGETHER, BatchFit
from pipelines.estimators.load_transfer.data import StrutData
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray

QUICK_SHARE = 0.6
WHOLE = 4.0
"""QUICK_SHARE: of the cutoff, above which a horizontal acceleration is taken for noise: pedals and steering are slower.
WHOLE: variance of white noise below the cutoff over that of its quick part (of the filter's own response: 3.96)."""
MOST = 0.9
"""Share of a coefficient that noise may hide; where it is more, nothing of the column is left."""


def quick_part(values: FloatArray, data: StrutData, above_hz: float) -> FloatArray:
    """A column without what is slower than `above_hz`, run by run."""
    out = np.zeros(len(values))
    begin = np.flatnonzero(data.starts > 0.5)
    for first, past in zip(begin, [*begin[1:], len(values)], strict=True):
        piece = values[first:past]
        out[first:past] = piece - lowpass(piece, data.rate_hz, min(above_hz, 0.4 * data.rate_hz))
    return out


def noise_of(values: FloatArray, data: StrutData, cutoff_hz: float) -> float:
    """Standard deviation of a low-passed column's noise by its quick part's usual size: single jerks do not count."""
    quick = quick_part(values, data, QUICK_SHARE * cutoff_hz)
    return float(np.sqrt(WHOLE) * 1.4826 * np.median(np.abs(quick)))


def with_noise(found: BatchFit, data: StrutData, cutoff_hz: float) -> BatchFit:
    """The fit with what noise in `along` and `across` may have shifted, in its covariance."""
    ridge = np.diag(np.mean(found.weights[:, None] * found.residual**2) * TOGETHER / LOOSE**2)
    inverse = np.linalg.inv(found.products.sum(axis=0) + ridge)
    covariance = found.covariance
    for column, values in ((ALONG, data.along), (ACROSS, data.across)):
        power = noise_of(values, data, cutoff_hz) ** 2 * float(found.weights.sum())
        hidden = min(power * float(inverse[column, column]), MOST)
        shift = power * np.outer(inverse[:, column], found.coefficients[column]) / (1 - hidden)
        covariance = covariance + np.outer(shift.ravel(), shift.ravel())
    return replace(found, covariance=covariance)
