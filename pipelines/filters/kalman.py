"""Innovations of a linear time-invariant Kalman filter over segments, as one compiled loop.

    x[k+1] = phi x[k] + push[k] + w,   w ~ N(0, q)
    y[k]   = c x[k] + feed[k] + v,     v ~ N(0, diag(r))

The outputs of one row are taken one after the other (r is diagonal, so that this is exact), and each gives a scalar
innovation and its variance: the likelihood of the data is the product of their normal densities. A NaN output is not
there. Once the covariance has settled, its recursion stops and the gains are kept: a long drive costs a few
multiplications a sample.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel

SETTLED = 1e-10
"""Relative change of the predicted covariance below which the gains are kept."""


@kernel
def _innovations(
    y: FloatArray,
    push: FloatArray,
    feed: FloatArray,
    starts: IntArray,
    stops: IntArray,
    phi: FloatArray,
    q: FloatArray,
    c: FloatArray,
    r: FloatArray,
    x0: FloatArray,
    p0: FloatArray,
    clip: float,
    error: FloatArray,
    variance: FloatArray,
) -> None:
    """Fill `error` and `variance` (both (n, m)); see `innovations`."""
    outputs = y.shape[1]
    states = phi.shape[0]
    x = np.zeros(states)
    following = np.zeros(states)
    p = np.zeros((states, states))
    predicted = np.zeros((states, states))
    half = np.zeros((states, states))
    gain = np.zeros((outputs, states))
    spread = np.zeros(outputs)
    column = np.zeros(states)
    for segment in range(starts.shape[0]):
        for i in range(states):
            x[i] = x0[segment, i]
            for j in range(states):
                p[i, j] = p0[i, j]
        settled = False
        for k in range(starts[segment], stops[segment]):
            whole = True
            for output in range(outputs):
                if not np.isfinite(y[k, output]):
                    whole = False
            if not whole:
                settled = False
            for i in range(states):
                for j in range(states):
                    predicted[i, j] = p[i, j]
            for output in range(outputs):
                if not np.isfinite(y[k, output]):
                    error[k, output] = np.nan
                    variance[k, output] = np.nan
                    continue
                if not settled:
                    total = r[output]
                    for i in range(states):
                        column[i] = 0.0
                        for j in range(states):
                            column[i] += p[i, j] * c[output, j]
                    for i in range(states):
                        total += c[output, i] * column[i]
                    spread[output] = total
                    for i in range(states):
                        gain[output, i] = column[i] / total
                    for i in range(states):
                        for j in range(states):
                            p[i, j] -= gain[output, i] * column[j]
                e = y[k, output] - feed[k, output]
                for i in range(states):
                    e -= c[output, i] * x[i]
                error[k, output] = e
                variance[k, output] = spread[output]
                limit = clip * np.sqrt(spread[output])
                if e > limit:
                    e = limit
                elif e < -limit:
                    e = -limit
                for i in range(states):
                    x[i] += gain[output, i] * e
            for i in range(states):
                following[i] = push[k, i]
                for j in range(states):
                    following[i] += phi[i, j] * x[j]
            for i in range(states):
                x[i] = following[i]
            if settled:
                continue
            for i in range(states):
                for j in range(states):
                    half[i, j] = 0.0
                    for m in range(states):
                        half[i, j] += phi[i, m] * p[m, j]
            for i in range(states):
                for j in range(i + 1):
                    total = q[i, j]
                    for m in range(states):
                        total += half[i, m] * phi[j, m]
                    p[i, j] = total
                    p[j, i] = total
            if whole:
                settled = True
                for i in range(states):
                    if abs(p[i, i] - predicted[i, i]) > SETTLED * predicted[i, i]:
                        settled = False


def innovations(
    y: FloatArray,
    push: FloatArray,
    feed: FloatArray,
    segments: tuple[IntArray, IntArray],
    *,
    phi: FloatArray,
    q: FloatArray,
    c: FloatArray,
    r: FloatArray,
    x0: FloatArray,
    p0: FloatArray,
    clip: float = np.inf,
) -> tuple[FloatArray, FloatArray]:
    """Innovations and their variances, both (n, m), NaN where there is no output.

    y, feed: (n, m). push: (n, s), what the input adds between row k and k+1. segments: first rows and rows past the
    last; each starts anew from x0 (one row a segment, (segments, s)) and p0 (s, s). phi, q: (s, s). c: (m, s).
    r: (m,). clip: an innovation moves the state by at most `clip` of its standard deviations (inf: no limit).
    Raises ValueError where a segment leaves the arrays or a shape does not fit.
    """
    n, outputs = y.shape
    states = phi.shape[0]
    starts, stops = segments
    shapes_fit = (
        push.shape == (n, states)
        and feed.shape == (n, outputs)
        and q.shape == phi.shape == p0.shape == (states, states)
        and c.shape == (outputs, states)
        and r.shape == (outputs,)
        and x0.shape == (len(starts), states)
        and len(starts) == len(stops)
    )
    if not shapes_fit:
        raise ValueError("the filter's arrays do not fit together")
    if len(starts) and (starts.min() < 0 or stops.max() > n):
        raise ValueError("a segment leaves the arrays")
    error = np.full((n, outputs), np.nan)
    variance = np.full((n, outputs), np.nan)
    _innovations(y, push, feed, starts, stops, phi, q, c, r, x0, p0, float(clip), error, variance)
    return error, variance
