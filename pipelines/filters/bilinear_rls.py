"""Linearised recursive least squares for two parameters that also meet as a product, one forgetting factor for each.

    y[k] = a[k] θ1 + b[k] θ2 + c[k] θ1 θ2 + n[k]

Park & Choi, equations (16)-(20): gain and covariance with a diagonal forgetting matrix Λ. Divided by different
factors row by row, the covariance loses its symmetry and, after some thousand rows, its sign; it is made symmetric
after each row. A direction that the data do not excite grows without end under forgetting (wind-up): no variance is
let above its start.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.jit import kernel
from pipelines.prepare.prepared import BoolArray


@kernel
def _run(
    y: FloatArray,
    terms: FloatArray,
    active: BoolArray,
    start: tuple[float, float, float, float, float],
    forgetting: tuple[float, float],
    limited: bool,
    theta: FloatArray,
    spread: FloatArray,
) -> None:
    """Fill theta (n, 2) and spread (n, 2). start: θ1, θ2, P11, P12, P22."""
    t1, t2, p11, p12, p22 = start
    f1, f2 = forgetting
    for k in range(len(y)):
        if active[k]:
            # F of (20), taken at the estimate before this row
            g1 = terms[k, 0] + terms[k, 2] * t2
            g2 = terms[k, 1] + terms[k, 2] * t1
            error = y[k] - (terms[k, 0] * t1 + terms[k, 1] * t2 + terms[k, 2] * t1 * t2)
            pf1 = p11 * g1 + p12 * g2
            pf2 = p12 * g1 + p22 * g2
            total = g1 * pf1 + g2 * pf2
            l1 = pf1 / (f1 + total)
            l2 = pf2 / (f2 + total)
            t1 += l1 * error
            t2 += l2 * error
            n11 = (p11 - l1 * pf1) / f1
            n12 = 0.5 * ((p12 - l1 * pf2) / f1 + (p12 - l2 * pf1) / f2)
            n22 = (p22 - l2 * pf2) / f2
            if limited:
                # scaling a row and its column keeps the matrix a covariance
                s1 = min(1.0, np.sqrt(start[2] / n11)) if n11 > 0 else 1.0
                s2 = min(1.0, np.sqrt(start[4] / n22)) if n22 > 0 else 1.0
                n11, n12, n22 = n11 * s1 * s1, n12 * s1 * s2, n22 * s2 * s2
            p11, p12, p22 = n11, n12, n22
        theta[k, 0] = t1
        theta[k, 1] = t2
        spread[k, 0] = p11
        spread[k, 1] = p22


def bilinear_rls(
    y: FloatArray,
    terms: FloatArray,
    active: BoolArray,
    *,
    start: tuple[float, float],
    covariance: tuple[float, float],
    forgetting: tuple[float, float],
    limited: bool = True,
) -> tuple[FloatArray, FloatArray]:
    """Estimates θ (n, 2) after each row and the diagonal of P (n, 2).

    y: (n,). terms: (n, 3), the factors a, b, c. active: (n,), rows that count; others hold the estimate. start: θ
    before the first row; covariance: its diagonal P(0). forgetting: the diagonal of Λ, each in (0, 1]. limited: no
    variance above its start.
    Raises ValueError where shapes do not fit or a forgetting factor is out of its range.
    """
    rows = len(y)
    if terms.shape != (rows, 3) or active.shape != (rows,):
        raise ValueError("the filter's arrays do not fit together")
    if not all(0 < factor <= 1 for factor in forgetting):
        raise ValueError("a forgetting factor lies above 0 and up to 1")
    theta = np.empty((rows, 2))
    spread = np.empty((rows, 2))
    first = (float(start[0]), float(start[1]), float(covariance[0]), 0.0, float(covariance[1]))
    factors = (float(forgetting[0]), float(forgetting[1]))
    _run(np.ascontiguousarray(y), np.ascontiguousarray(terms), active, first, factors, limited, theta, spread)
    return theta, spread
