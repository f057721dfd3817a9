"""Expansions to values at the collocation points and back, as compiled helpers (dissertation (13)-(16)).

The inner loops run along memory, so that they become vector instructions.
"""

from __future__ import annotations

from parsers.jit import lean_kernel
from pipelines.results import FloatArray


@lean_kernel
def at_points(x: FloatArray, basis: FloatArray, values: FloatArray) -> None:
    """values (n, Q) of expansions x (n, S) at the points; basis (S, Q)."""
    for i in range(x.shape[0]):
        for q in range(basis.shape[1]):
            values[i, q] = 0.0
        for s in range(x.shape[1]):
            weight = x[i, s]
            if weight != 0.0:
                for q in range(basis.shape[1]):
                    values[i, q] += weight * basis[s, q]


@lean_kernel
def expand_row(values: FloatArray, row: int, inverse: FloatArray, y: FloatArray, into: int) -> None:
    """y[into] (S,) = the coefficients of values[row] (Q,); inverse (Q, S)."""
    for s in range(inverse.shape[1]):
        y[into, s] = 0.0
    for q in range(inverse.shape[0]):
        value = values[row, q]
        for s in range(inverse.shape[1]):
            y[into, s] += value * inverse[q, s]
