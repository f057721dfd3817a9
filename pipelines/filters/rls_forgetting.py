"""Recursive least squares with exponential forgetting, several outputs that share their parameters; noise on inputs.

    y_i[k] = phi_i[k]' theta + n_i,   i = 1..m

(81)-(83) of the gPC dissertation, corrected: the gain takes the covariance before the sample, K = P phi / (lambda +
phi'P phi), and the covariance is then (I - K phi') P / lambda; in the printed order (P_k in K_k) numbers leave their
range. The outputs of one sample come one after the other, which for independent noises is the vector form; with
lambda = 1 the result is weighted least squares of all samples, with lambda < 1 that with weights lambda^(age).

**Noise on the regressors** (errors in variables): with phi + u in place of phi, sum phi phi' is too large by the sum of
var u, which pulls theta towards zero. Its known part is taken out again by the same recursion: an observation
"theta_j = 0" of negative weight, minus what the noise put in. The excess waits until the information that is there is
four times as large, so that the covariance keeps its sign at the start.
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray

LARGEST_STEP = 0.25
"""Largest share of the information on a coefficient that is taken out at once."""


@kernel
def _step(
    phi: FloatArray, error: float, variance: float, theta: FloatArray, p: FloatArray, gain: FloatArray
) -> None:
    """One observation, in place. variance < 0 takes information out."""
    count = len(theta)
    total = variance
    for i in range(count):
        gain[i] = 0.0
        for j in range(count):
            gain[i] += p[i, j] * phi[j]
        total += phi[i] * gain[i]
    for i in range(count):
        theta[i] += gain[i] * error / total
        for j in range(i + 1):
            # both halves from one product: P stays symmetric to the last digit
            p[i, j] -= gain[i] * gain[j] / total
            p[j, i] = p[i, j]


@kernel
def _run(
    phi: FloatArray,
    y: FloatArray,
    variance: FloatArray,
    excess: FloatArray,
    keep: float,
    every: int,
    theta: FloatArray,
    p: FloatArray,
    track: FloatArray,
    spread: FloatArray,
) -> None:
    """theta (c,), p (c, c) in place; track, spread (n // every, c). excess (c,): information that noise adds a sample."""
    rows, outputs, count = phi.shape
    gain, unit, waiting = np.zeros(count), np.zeros(count), np.zeros(count)
    row, left = 0, every
    for k in range(rows):
        for i in range(count):
            waiting[i] = keep * waiting[i] + excess[i]
            for j in range(count):
                p[i, j] /= keep
        for i in range(outputs):
            error = y[k, i]
            for j in range(count):
                error -= phi[k, i, j] * theta[j]
            _step(phi[k, i], error, variance[i], theta, p, gain)
        for j in range(count):
            if waiting[j] > 0.0 and p[j, j] * waiting[j] < LARGEST_STEP:
                unit[j] = 1.0
                _step(unit, -theta[j], -1.0 / waiting[j], theta, p, gain)
                unit[j] = 0.0
                waiting[j] = 0.0
        left -= 1
        if left == 0:
            for j in range(count):
                track[row, j] = theta[j]
                spread[row, j] = np.sqrt(max(p[j, j], 0.0))
            row += 1
            left = every


def rls_forgetting(
    phi: FloatArray,
    y: FloatArray,
    theta0: FloatArray,
    p0: FloatArray,
    *,
    variance: FloatArray | None = None,
    forgetting: float = 1.0,
    input_variance: FloatArray | None = None,
    every: int = 1,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Estimates of theta: after every `every`-th sample (n // every, c), their standard deviations likewise, the last
    theta (c,) and P (c, c).

    phi: (n, m, c), m outputs a sample. y: (n, m). theta0: (c,). p0: (c, c) symmetric. variance: (m,) of the outputs'
    noise, 1 by default. forgetting: lambda. input_variance: (m, c) of the noise on phi, taken out; where it is large
    beside the outputs' own, let `variance` hold what it adds to the residual.
    Raises ValueError where they do not fit together, a variance is not one, or forgetting is not within (0, 1].
    """
    if phi.ndim != 3:
        raise ValueError("phi has three axes: sample, output, coefficient")
    rows, outputs, count = phi.shape
    if y.shape != (rows, outputs) or theta0.shape != (count,) or p0.shape != (count, count) or every < 1:
        raise ValueError("the arrays do not fit together")
    weights = np.ones(outputs) if variance is None else np.asarray(variance, dtype=np.float64)
    if weights.shape != (outputs,) or not (weights > 0).all():
        raise ValueError("a variance above 0 for each output")
    if not 0 < forgetting <= 1:
        raise ValueError("forgetting is within (0, 1]")
    excess = np.zeros(count)
    if input_variance is not None:
        if input_variance.shape != (outputs, count) or not (input_variance >= 0).all():
            raise ValueError("an input variance of 0 or more for each output and coefficient")
        excess = np.sum(input_variance / weights[:, None], axis=0)
    theta, p = theta0.astype(np.float64), p0.astype(np.float64)
    track, spread = np.empty((rows // every, count)), np.empty((rows // every, count))
    _run(
        np.ascontiguousarray(phi, dtype=np.float64), np.ascontiguousarray(y, dtype=np.float64), weights, excess,
        float(forgetting), every, theta, p, track, spread,
    )  # fmt: skip
    return track, spread, theta, p
