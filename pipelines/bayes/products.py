"""Matrix products in pieces that the linear algebra library does on one core.

These products take a fraction of a millisecond. On a busy machine the library's threads would wait for each other many times as
long, and several drives are analysed at once anyway: thousands of them made a fit three times as slow.
"""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray

ONE_CORE = 250_000
"""Multiplications of one product up to which OpenBLAS starts no threads (2^18)."""


def product(rows: FloatArray, matrix: FloatArray) -> FloatArray:
    """rows (n, k) times matrix (k, m): (n, m)."""
    n, k = rows.shape
    m = matrix.shape[1]
    size = max(1, ONE_CORE // max(k * m, 1))
    out = np.empty((n, m))
    for first in range(0, n, size):
        np.matmul(rows[first : first + size], matrix, out=out[first : first + size])
    return out


def gram(rows: FloatArray) -> FloatArray:
    """rows (n, s) transposed times itself: (s, s)."""
    n, s = rows.shape
    size = max(1, ONE_CORE // max(s * s, 1))
    out = np.zeros((s, s))
    for first in range(0, n, size):
        piece = rows[first : first + size]
        out += piece.T @ piece
    return out
