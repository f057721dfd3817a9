"""The Kalman update of a polynomial chaos expansion, as compiled helpers (dissertation (20), (37)-(40), (49)).

An expansion is a row of coefficients; column 0 is the mean, and for an orthonormal basis the covariance of two rows is
the sum over the other columns of their products (20). With measured outputs z = y + noise of variances r:

    K = Cxy (Cyy + R)^-1,    x[:, 0] += K (z - y[:, 0])                                                   (39)

Two forms of what follows for the other columns:

form 0, as published (40): x[:, 1:] -= K y[:, 1:]. The covariance becomes (I - K H) M (I - K H)' without K R K': too small
    at each update, so that the filter stops to learn (the dissertation's "paradox").
form 1, square root: x[:, 1:] -= G y[:, 1:] with G = Cxy L'^-1 (L + sqrt(R))^-1 and L L' = Cyy + R. The covariance becomes
    that of the Kalman filter, M - K H M, exactly.

`gpc_update_with` can also add a covariance that no coefficient carries to the one from the coefficients, as (49) does.
An output that is NaN is not there. Nothing here needs a linear algebra library.
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray

PUBLISHED, SQUARE_ROOT = 0, 1
"""The two forms."""

LOST = 1e-13
"""An output whose variance the others explain to this share tells nothing new: it is left out."""


@kernel
def _factor(y: FloatArray, z: FloatArray, r: FloatArray, inner: FloatArray, work: FloatArray) -> None:
    """work (m, m + 4): the Cholesky factor of Cyy + R, z - y[:, 0] in column m, and in m + 1 whether an output counts."""
    m, terms = y.shape
    for i in range(m):
        counts = np.isfinite(z[i])
        for j in range(i + 1):
            total = 0.0
            for s in range(1, terms):
                total += y[i, s] * y[j, s]
            if i == j:
                total += r[i]
            if inner.shape[0] > 0:
                total += inner[i, j]
            whole = total
            for k in range(j):
                total -= work[i, k] * work[j, k]
            if j < i:
                work[i, j] = total / work[j, j] if counts and work[j, m + 1] > 0.5 else 0.0
            else:
                counts = counts and whole > 0.0 and total > LOST * whole
                work[i, i] = np.sqrt(total) if counts else 1.0
        work[i, m] = z[i] - y[i, 0] if counts else 0.0
        work[i, m + 1] = 1.0 if counts else 0.0
        if not counts:
            for j in range(i):
                work[i, j] = 0.0


@kernel
def _below(work: FloatArray, m: int, at: int) -> None:
    """Column `at` of work becomes L^-1 times itself."""
    for i in range(m):
        total = work[i, at]
        for k in range(i):
            total -= work[i, k] * work[k, at]
        work[i, at] = total / work[i, i]


@kernel
def gpc_update_with(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    r: FloatArray,
    form: int,
    cross: FloatArray,
    inner: FloatArray,
    work: FloatArray,
) -> None:
    """`gpc_update` with a covariance of the states beside that of the coefficients (49), without making arrays.

    For states with the added covariance D and outputs H x: cross (n, m) = D H', inner (m, m) = H D H'; both (0, 0) for
    none. work: (m, m + 4), overwritten. In form 1 the spread is that after a measurement of noise R + diag(inner).
    """
    m, terms = y.shape
    _factor(y, z, r, inner, work)
    _below(work, m, m)
    for i in range(x.shape[0]):
        for j in range(m):
            total = 0.0
            if work[j, m + 1] > 0.5:
                for s in range(1, terms):
                    total += x[i, s] * y[j, s]
            work[j, m + 3] = total
            if cross.shape[0] > 0 and work[j, m + 1] > 0.5:
                total += cross[i, j]
            work[j, m + 2] = total
        _below(work, m, m + 2)
        move = 0.0
        for j in range(m):
            move += work[j, m + 2] * work[j, m]
        x[i, 0] += move
        if form == 1 and cross.shape[0] > 0:
            for j in range(m):
                work[j, m + 2] = work[j, m + 3]
            _below(work, m, m + 2)
        # the row's gain from the last output to the first: L' of (40), or (L + sqrt(R))'
        for back in range(m):
            j = m - 1 - back
            total = work[j, m + 2]
            for k in range(j + 1, m):
                total -= work[k, j] * work[k, m + 2]
            pivot = work[j, j]
            if form == 1 and work[j, m + 1] > 0.5:
                noise = r[j]
                if inner.shape[0] > 0:
                    noise += inner[j, j]
                pivot += np.sqrt(noise)
            work[j, m + 2] = total / pivot
        for j in range(m):
            gain = work[j, m + 2]
            if gain != 0.0:
                for s in range(1, terms):
                    x[i, s] -= gain * y[j, s]


@kernel
def gpc_update(x: FloatArray, y: FloatArray, z: FloatArray, r: FloatArray, form: int) -> None:
    """Move x to its posterior, in place.

    x (n, S): coefficients of what is estimated; y (m, S): of the predicted outputs, over the same terms (not changed, and
    not the same memory as rows of x); z (m,): measured, NaN where not; r (m,): variances of their noise, 0 or more;
    form: 0 as published (40), 1 square root. One small work array is made; see `gpc_update_with` for none.
    """
    none = np.empty((0, 0))
    gpc_update_with(x, y, z, r, form, none, none, np.empty((y.shape[0], y.shape[0] + 4)))
