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
def _take(p: FloatArray, c: FloatArray, r: float, gain: FloatArray, column: FloatArray) -> float:
    """One output into the covariance p (in place): fills its gain, returns its innovation's variance."""
    states = p.shape[0]
    total = r
    for i in range(states):
        column[i] = 0.0
        for j in range(states):
            column[i] += p[i, j] * c[j]
    for i in range(states):
        total += c[i] * column[i]
    for i in range(states):
        gain[i] = column[i] / total
    for i in range(states):
        for j in range(states):
            p[i, j] -= gain[i] * column[j]
    return total


@kernel
def _forward(p: FloatArray, phi: FloatArray, q: FloatArray, half: FloatArray) -> None:
    """The covariance p one row on, in place: phi p phi' + q."""
    states = p.shape[0]
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


@kernel
def _correct(x: FloatArray, c: FloatArray, y: float, spread: float, clip: float, gain: FloatArray) -> float:
    """One output into the state x (in place); returns its innovation."""
    error = y
    for i in range(len(x)):
        error -= c[i] * x[i]
    limit = clip * np.sqrt(spread)
    moved = min(max(error, -limit), limit)
    for i in range(len(x)):
        x[i] += gain[i] * moved
    return error


@kernel
def _onward(x: FloatArray, phi: FloatArray, push: FloatArray, k: int, following: FloatArray) -> None:
    """The states x (columns, s) from row k to the next, in place."""
    pushed, states = push.shape[0] > 0, phi.shape[0]
    for one in range(x.shape[0]):
        for i in range(states):
            following[i] = push[k, i] if pushed else 0.0
            for j in range(states):
                following[i] += phi[i, j] * x[one, j]
        for i in range(states):
            x[one, i] = following[i]


@kernel
def _segment(
    y: FloatArray,
    push: FloatArray,
    feed: FloatArray,
    rows: tuple[int, int],
    model: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    x: FloatArray,
    p: FloatArray,
    clip: float,
    error: FloatArray,
    variance: FloatArray,
) -> None:
    """One segment of all columns from states x (k, s) and covariance p; model: phi, q, c, r. Gains are made once for all columns.

    An output is there where the first column has it. push, feed: of all columns; without rows where there are none.
    """
    phi, q, c, r = model
    outputs, states = c.shape
    fed = feed.shape[0] > 0
    following, column, spread = np.zeros(states), np.zeros(states), np.zeros(outputs)
    before, half, gain = np.zeros(states), np.zeros((states, states)), np.zeros((outputs, states))
    settled = False
    for k in range(rows[0], rows[1]):
        whole = True
        for output in range(outputs):
            if not np.isfinite(y[0, k, output]):
                whole = False
        settled = settled and whole
        if not settled:
            for i in range(states):
                before[i] = p[i, i]
        for output in range(outputs):
            if not np.isfinite(y[0, k, output]):
                for one in range(y.shape[0]):
                    error[one, k, output] = np.nan
                variance[k, output] = np.nan
                continue
            if not settled:
                spread[output] = _take(p, c[output], r[output], gain[output], column)
            variance[k, output] = spread[output]
            for one in range(y.shape[0]):
                value = y[one, k, output]
                if fed:
                    value -= feed[k, output]
                if np.isfinite(value):
                    error[one, k, output] = _correct(
                        x[one], c[output], value, spread[output], clip, gain[output]
                    )
                else:
                    error[one, k, output] = np.nan
        _onward(x, phi, push, k, following)
        if settled:
            continue
        _forward(p, phi, q, half)
        if whole:
            settled = True
            for i in range(states):
                if abs(p[i, i] - before[i]) > SETTLED * before[i]:
                    settled = False


@kernel
def _innovations(
    y: FloatArray,
    push: FloatArray,
    feed: FloatArray,
    starts: IntArray,
    stops: IntArray,
    model: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    x0: FloatArray,
    p0: FloatArray,
    clip: float,
    error: FloatArray,
    variance: FloatArray,
) -> None:
    """Fill `error` (k, n, m) and `variance` (n, m); see `innovations`. x0: (segments, s), of every column."""
    x, p = np.zeros((y.shape[0], x0.shape[1])), np.zeros(p0.shape)
    for segment in range(starts.shape[0]):
        for i in range(x0.shape[1]):
            for one in range(y.shape[0]):
                x[one, i] = x0[segment, i]
            for j in range(x0.shape[1]):
                p[i, j] = p0[i, j]
        rows = (starts[segment], stops[segment])
        _segment(y, push, feed, rows, model, x, p, clip, error, variance)


def innovations(
    y: FloatArray,
    push: FloatArray | None,
    feed: FloatArray | None,
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
    """Innovations (n, m) and their variances (n, m), NaN where there is no output.

    y: (n, m), or (k, n, m) for k columns side by side whose outputs are there together (as the first one's are): innovations (k, n, m)
    then, and the variances (n, m) of them all. feed: (n, m). push: (n, s), what the input adds between row k and k+1; either None where
    there is none. segments: first rows and rows past the last; each starts anew from x0 (one row a segment, (segments, s)) and p0
    (s, s). phi, q: (s, s). c: (m, s). r: (m,). clip: an innovation moves the state by at most `clip` of its standard deviations
    (inf: no limit).
    Raises ValueError where a segment leaves the arrays or a shape does not fit.
    """
    columns = y if y.ndim == 3 else y[None]
    _, n, outputs = columns.shape
    states = phi.shape[0]
    starts, stops = segments
    shapes_fit = (
        (push is None or push.shape == (n, states))
        and (feed is None or feed.shape == (n, outputs))
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
    error = np.full(columns.shape, np.nan)
    variance = np.full((n, outputs), np.nan)
    _innovations(
        np.ascontiguousarray(columns),
        np.zeros((0, states)) if push is None else push,
        np.zeros((0, outputs)) if feed is None else feed,
        starts,
        stops,
        (phi, q, c, r),
        x0,
        p0,
        float(clip),
        error,
        variance,
    )
    return (error if y.ndim == 3 else error[0]), variance
