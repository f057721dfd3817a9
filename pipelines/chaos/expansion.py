"""A model's outputs as polynomials of random variables: moments, sensitivities, densities (equations 13 and 15-20)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.errors import ExpansionError
from pipelines.chaos.collocation import Collocation
from pipelines.chaos.densities import Density, estimate_density
from pipelines.chaos.kernels import fill_values
from pipelines.chaos.space import Space

SAMPLES = 100_000
ROUNDING = 1e-12
"""A standard deviation below this share of the largest coefficient is rounding: the output does not vary."""


@dataclass(frozen=True)
class Expansion:
    """m outputs over the same terms. Its arrays are not to be changed: what follows from them is kept.

    indices: (S, d), each term once. coefficients: (S, m).
    """

    space: Space
    indices: IntArray
    coefficients: FloatArray

    def __post_init__(self) -> None:
        """Raise ValueError where coefficients and indices do not fit together."""
        if self.coefficients.ndim != 2 or len(self.coefficients) != len(self.indices):
            raise ValueError("coefficients are one row a term and one column an output")

    @property
    def mean(self) -> FloatArray:
        """(m,): the coefficients of the constant term."""
        return np.asarray(self.coefficients[~self._active.any(axis=1)].sum(axis=0))

    @property
    def covariance(self) -> FloatArray:
        """Between outputs, (m, m): equation (20)."""
        rows = self.coefficients[self._active.any(axis=1)]
        return np.asarray(rows.T @ rows)

    @property
    def variance(self) -> FloatArray:
        """(m,)"""
        return np.asarray(np.square(self.coefficients[self._active.any(axis=1)]).sum(axis=0))

    @property
    def std(self) -> FloatArray:
        """Standard deviations, (m,)."""
        return np.asarray(np.sqrt(self.variance))

    @property
    def correlation(self) -> FloatArray:
        """Between outputs, (m, m); 0 beside the diagonal for an output that does not vary."""
        std = np.where(self._varies, self.std, 0.0)
        scale = np.outer(std, std)
        ratio = np.asarray(np.divide(self.covariance, scale, out=np.zeros_like(scale), where=scale > 0))
        np.fill_diagonal(ratio, 1.0)
        return ratio

    @property
    def sobol_first(self) -> FloatArray:
        """Share of the variance that each variable makes alone, (d, m). 0 where an output does not vary."""
        return self._share(self._active & (self._active.sum(axis=1) == 1)[:, None])

    @property
    def sobol_total(self) -> FloatArray:
        """Share of the variance in which each variable has a part, (d, m). 0 where an output does not vary."""
        return self._share(self._active)

    def evaluate(self, points: FloatArray) -> FloatArray:
        """The outputs at points (Q, d): (Q, m)."""
        points = self.space.points(points)
        out = np.empty((len(points), self.coefficients.shape[1]))
        fill_values(points, *self._tree, out)
        return out

    def sample(self, rng: np.random.Generator, n: int = SAMPLES) -> FloatArray:
        """The outputs at n random points, (n, m)."""
        return self.evaluate(self.space.sample(rng, n))

    def quantile(
        self, probabilities: Sequence[float], rng: np.random.Generator, *, samples: int = SAMPLES
    ) -> FloatArray:
        """Values below which each output lies with the given probabilities, from samples: (k, m)."""
        return np.asarray(np.quantile(self.sample(rng, samples), probabilities, axis=0))

    def density(self, rng: np.random.Generator, *, output: int = 0, samples: int = SAMPLES) -> Density:
        """The probability density of one output, from samples of the expansion.

        Raises ExpansionError where the output does not vary.
        """
        if not 0 <= output < self.coefficients.shape[1]:
            raise ValueError(f"there is no output {output}")
        if not self._varies[output]:
            raise ExpansionError(f"output {output} does not vary, it has no density")
        column = self.coefficients[:, output : output + 1]
        return estimate_density(Expansion(self.space, self.indices, column).sample(rng, samples)[:, 0])

    @cached_property
    def _active(self) -> NDArray[np.bool_]:
        """Which variables each term has, (S, d)."""
        return self.indices > 0

    @cached_property
    def _varies(self) -> NDArray[np.bool_]:
        """Which outputs vary by more than what rounding leaves in the terms of a constant, (m,)."""
        return np.asarray(self.std > ROUNDING * np.abs(self.coefficients).max(axis=0))

    @cached_property
    def _tree(self) -> tuple[FloatArray, FloatArray, IntArray, int, FloatArray]:
        """What `fill_values` takes between the points and the result."""
        tree = self.space.plan(self.indices)
        weights = np.zeros((len(tree.nodes), self.coefficients.shape[1]))
        np.add.at(weights, tree.place, self.coefficients)
        return *self.space.recurrences(tree.degree), tree.nodes, tree.levels, weights

    def _share(self, belongs: NDArray[np.bool_]) -> FloatArray:
        """Variance of the terms in each column of `belongs` (S, d) over the whole, (d, m)."""
        part = belongs.T.astype(float) @ np.square(self.coefficients)
        return np.asarray(np.divide(part, self.variance, out=np.zeros_like(part), where=self._varies))


def expand(collocation: Collocation, values: FloatArray) -> Expansion:
    """The least-squares expansion (15) of a model's values (Q, m) or (Q,) at the collocation's points.

    Raises ExpansionError where the model gave no finite value.
    """
    values = np.asarray(values, dtype=float)
    columns = values[:, None] if values.ndim == 1 else values
    if columns.ndim != 2 or len(columns) != len(collocation.points):
        raise ValueError(f"values are {len(collocation.points)} rows, one a point")
    bad = int(np.count_nonzero(~np.isfinite(columns).all(axis=1)))
    if bad:
        raise ExpansionError(
            f"the model has no finite value at {bad} of {len(columns)} collocation points",
            hint="narrow the ranges of its parameters, or give a positive one through its logarithm",
        )
    return Expansion(collocation.space, collocation.indices, collocation.inverse @ columns)
