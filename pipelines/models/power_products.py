"""Regression models whose coefficients are products of whole powers of the parameters.

    y_i(t) = sum_j phi_ij(t) c_j(p),    c_j(p) = prod_k p_k ** e_jk

The simple roll-plane model of the gPC dissertation, (71)-(73), is one: its coefficients (85) are 1/m, 1/J_r, 1/J_p,
m h / J_r and m h / J_p. Whatever is told about p is told through c: c free gives linear least squares, c bound to p the
non-linear estimate of fewer unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.results import FloatArray


@dataclass(frozen=True)
class PowerProducts:
    """parameters: their n names; exponents: (C, n) whole numbers, a row a coefficient.

    Raises ValueError where they do not fit.
    """

    parameters: tuple[str, ...]
    exponents: NDArray[np.int64]

    def __post_init__(self) -> None:
        """Refuse what does not fit."""
        if self.exponents.ndim != 2 or self.exponents.shape[1] != len(self.parameters):
            raise ValueError("exponents has one column a parameter")

    def coefficients(self, values: FloatArray) -> FloatArray:
        """c (C,) at parameter values (n,), none of them 0."""
        return np.asarray(np.prod(np.asarray(values)[None, :] ** self.exponents, axis=1))

    def slopes(self, values: FloatArray) -> FloatArray:
        """dc / d ln p, (C, n): in relative changes of the parameters."""
        return np.asarray(self.exponents * self.coefficients(values)[:, None])
