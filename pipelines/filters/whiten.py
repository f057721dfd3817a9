"""Generalised least squares by filtering: columns freed of coloured noise in one compiled pass.

The noise of a column y is d + n: d[k] = phi d[k-1] + w (phi = 1: a random walk), n white with its own variance at each
row (Huber weights make it larger). Filtering y and every regressor with the same Kalman gains turns generalised least
squares into ordinary least squares of the normalised innovations, exactly.
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray


@kernel
def _whiten(
    z: FloatArray,
    starts: FloatArray,
    phi: float,
    q: float,
    r: FloatArray,
    out: FloatArray,
    spread: FloatArray,
) -> None:
    columns = z.shape[1]
    mean = np.zeros(columns)
    p = 0.0
    for k in range(z.shape[0]):
        if starts[k] > 0.5:
            if phi >= 1.0:
                # a random walk starts anywhere: the first row tells its level and nothing else
                for c in range(columns):
                    mean[c] = z[k, c]
                    out[k, c] = 0.0
                p = r[k]
                spread[k] = 1.0
                continue
            for c in range(columns):
                mean[c] = 0.0
            p = q / (1.0 - phi * phi)
        else:
            p = phi * phi * p + q
        total = p + r[k]
        gain = p / total
        scale = 1.0 / np.sqrt(total)
        for c in range(columns):
            ahead = phi * mean[c] if starts[k] < 0.5 else mean[c]
            e = z[k, c] - ahead
            out[k, c] = e * scale
            mean[c] = ahead + gain * e
        spread[k] = total
        p -= gain * p


@kernel
def _deletion(
    e: FloatArray, starts: FloatArray, phi: float, q: float, r: FloatArray, out: FloatArray
) -> None:
    """out (n,): each value less what all others predict for it, over its standard deviation."""
    n = e.shape[0]
    ahead = np.zeros(n)
    sure = np.zeros(n)
    steady = 0.0 if phi >= 1.0 else (1.0 - phi * phi) / q
    m, p = 0.0, 0.0
    for k in range(n):
        if starts[k] > 0.5:
            ahead[k], sure[k] = 0.0, steady
        else:
            p = phi * phi * p + q
            ahead[k], sure[k] = phi * m, 1.0 / p
        precision = sure[k] + 1.0 / r[k]
        m = (sure[k] * ahead[k] + e[k] / r[k]) / precision
        p = 1.0 / precision
    m, p = 0.0, 0.0
    for j in range(n):
        k = n - 1 - j
        last = k == n - 1 or starts[k + 1] > 0.5
        if last:
            back, weight = 0.0, steady
        else:
            p = phi * phi * p + q
            back, weight = phi * m, 1.0 / p
        # the two predictions share the process's own prior, which counts once
        both = sure[k] + weight - steady
        if both > 0:
            predicted = (sure[k] * ahead[k] + weight * back) / both
            out[k] = (e[k] - predicted) / np.sqrt(r[k] + 1.0 / both)
        else:
            out[k] = 0.0
        precision = weight + 1.0 / r[k]
        m = (weight * back + e[k] / r[k]) / precision
        p = 1.0 / precision


def whiten(
    columns: FloatArray, starts: FloatArray, phi: float, process: float, variance: FloatArray
) -> tuple[FloatArray, float]:
    """Normalised innovations of every column, (n, c), and the sum of the logarithms of their variances.

    columns (n, c). starts (n,): 1 where a segment begins. phi: 0..1; process: variance of w; variance (n,): of n.
    With phi = 1 a segment's first row becomes zero (the walk's level is unknown).
    """
    out = np.empty_like(columns)
    spread = np.empty(len(columns))
    _whiten(np.ascontiguousarray(columns), starts, phi, process, variance, out, spread)
    return out, float(np.sum(np.log(spread)))


def deletion_residuals(
    residual: FloatArray, starts: FloatArray, phi: float, process: float, variance: FloatArray
) -> FloatArray:
    """Each residual less its best prediction from all others, in its standard deviations; (n,)."""
    out = np.empty(len(residual))
    _deletion(np.ascontiguousarray(residual), starts, phi, process, variance, out)
    return out
