"""Recursive least squares, y = θ'φ, as one compiled loop.

    K = P φ / (λ + φ'P φ),   θ += K (y - θ'φ),   P = (P - K φ'P) / λ

With a forgetting factor λ of 1 and P0 -> infinity this is least squares on all samples so far. It is the discrete form
of Pence, Fathy & Stein's (6)-(7): those mix a normalised and an unnormalised form, and Euler's rule on them diverges.
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray


@kernel
def _two(
    phi: FloatArray,
    y: FloatArray,
    keep: float,
    every: int,
    theta: FloatArray,
    p: FloatArray,
    track: FloatArray,
) -> None:
    """Two parameters, in scalars: `theta` (2,) and `p` (2, 2) in place; a row of `track` every `every` samples."""
    t0, t1, p00, p01, p11 = theta[0], theta[1], p[0, 0], p[0, 1], p[1, 1]
    again = 1.0 / keep
    row, left = 0, every
    for k in range(len(y)):
        f0, f1 = phi[k, 0], phi[k, 1]
        g0, g1 = p00 * f0 + p01 * f1, p01 * f0 + p11 * f1
        scale = 1.0 / (keep + f0 * g0 + f1 * g1)
        error = (y[k] - t0 * f0 - t1 * f1) * scale
        t0 += g0 * error
        t1 += g1 * error
        p00 = (p00 - g0 * g0 * scale) * again
        p01 = (p01 - g0 * g1 * scale) * again
        p11 = (p11 - g1 * g1 * scale) * again
        left -= 1
        if left == 0:
            track[row, 0] = t0
            track[row, 1] = t1
            row += 1
            left = every
    theta[0], theta[1] = t0, t1
    p[0, 0], p[0, 1], p[1, 0], p[1, 1] = p00, p01, p01, p11


@kernel
def _many(
    phi: FloatArray,
    y: FloatArray,
    keep: float,
    every: int,
    theta: FloatArray,
    p: FloatArray,
    track: FloatArray,
) -> None:
    """Any number of parameters; arguments as in `_two`."""
    count = len(theta)
    gain = np.zeros(count)
    row, left = 0, every
    for k in range(len(y)):
        total, error = keep, y[k]
        for i in range(count):
            gain[i] = 0.0
            for j in range(count):
                gain[i] += p[i, j] * phi[k, j]
            total += phi[k, i] * gain[i]
            error -= theta[i] * phi[k, i]
        for i in range(count):
            theta[i] += gain[i] * error / total
            for j in range(i + 1):
                # both halves from one product: P stays symmetric to the last digit
                p[i, j] = (p[i, j] - gain[i] * gain[j] / total) / keep
                p[j, i] = p[i, j]
        left -= 1
        if left == 0:
            for i in range(count):
                track[row, i] = theta[i]
            row += 1
            left = every


def recursive_least_squares(
    phi: FloatArray,
    y: FloatArray,
    theta0: FloatArray,
    p0: FloatArray,
    *,
    every: int = 1,
    forgetting: float = 1.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Estimate θ in y = θ'φ. Returns the estimate after every `every`-th sample (n // every, p), the last θ (p,) and P.

    phi: (n, p). y: (n,). theta0: (p,). p0: (p, p) symmetric. Raises ValueError where they do not fit together or
    `forgetting` is not within (0, 1].
    """
    n, count = phi.shape
    if y.shape != (n,) or theta0.shape != (count,) or p0.shape != (count, count) or every < 1:
        raise ValueError("the arrays do not fit together")
    if not 0 < forgetting <= 1:
        raise ValueError("forgetting is within (0, 1]")
    theta, p = theta0.astype(np.float64), p0.astype(np.float64)
    track = np.empty((n // every, count))
    run = _two if count == 2 else _many
    run(np.ascontiguousarray(phi), np.ascontiguousarray(y), float(forgetting), every, theta, p, track)
    return track, theta, p
