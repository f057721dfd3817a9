"""A misfit as a polynomial: model residuals by collocation over an affine box of parameters, (3)-(13), (45)-(48).

Residuals e = (z - h) / sigma at the collocation's points are expanded in orthonormal polynomials, e(xi) = C' psi(xi) with C (S, N);
the data are in there too, because the first polynomial is 1. The sum of squares of (46) is then psi' (C C') psi: a
polynomial of twice the order that is never negative, kept in S x S numbers however long the data. Expanding the likelihood
itself, or its logarithm, to the same order would lose both.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.bayes.products import gram, product
from pipelines.chaos.bases import legendre
from pipelines.chaos.collocation import Collocation, collocate
from pipelines.chaos.space import Space
from pipelines.results import FloatArray

Residuals = Callable[[FloatArray, int], FloatArray]
"""(coordinates (Q, d), number of the interval) -> normalised residuals (Q, N): their sum of squares is -2 log likelihood."""

HOLD_OUT = 6
EVEN_DIMENSIONS = 4
STEP = 1e-4
SMALLEST = 1e-15
"""Directions of the misfit's matrix below this share of its largest are rounding."""


@dataclass(frozen=True)
class Domain:
    """The affine box: coordinates = centre + axes xi with xi in [-1, 1]^d. axes (d, d): one column an axis."""

    centre: FloatArray
    axes: FloatArray

    def out(self, xi: FloatArray) -> FloatArray:
        """(n, d) xi -> coordinates."""
        return np.asarray(self.centre + xi @ self.axes.T)

    def into(self, coordinates: FloatArray) -> FloatArray:
        """(n, d) coordinates -> xi."""
        return np.asarray(np.linalg.solve(self.axes, (coordinates - self.centre).T).T)


def box(low: FloatArray, high: FloatArray) -> Domain:
    """The domain whose axes are the coordinates', from low to high (d,)."""
    return Domain(0.5 * (low + high), np.diag(0.5 * (high - low)))


def collocation_for(dimensions: int, order: int, factor: float, rng: np.random.Generator) -> Collocation:
    """Legendre polynomials to `order` with `factor` points a term. Raises ExpansionError for too large a set.

    Hammersley's points up to EVEN_DIMENSIONS; beyond, their columns of large primes run in step, and random ones are drawn.
    """
    space = Space((legendre(),) * dimensions)
    if dimensions <= EVEN_DIMENSIONS:
        return collocate(space, order, factor=factor)
    return collocate(space, order, factor=factor, kind="random", rng=rng)


@dataclass(frozen=True)
class Surrogate:
    """The misfit of all data so far over one domain. root (r, S): its square root, misfit = |root psi|²."""

    domain: Domain
    collocation: Collocation
    root: FloatArray

    def terms(self, xi: FloatArray) -> FloatArray:
        """psi (n, S) at xi (n, d)."""
        return self.collocation.space.matrix(xi, self.collocation.indices)

    def misfit(self, xi: FloatArray) -> FloatArray:
        """Sum of squares of normalised residuals at xi (n, d), (n,)."""
        reduced = product(self.terms(xi), self.root.T)
        return np.asarray(np.einsum("ns,ns->n", reduced, reduced))

    def slopes(self, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """At one point xi (d,): the residuals in S numbers, and their derivatives (S, d) by central differences."""
        d = len(xi)
        around = np.vstack((xi, xi + STEP * np.eye(d), xi - STEP * np.eye(d)))
        reduced = self.terms(around) @ self.root.T
        return reduced[0], (reduced[1 : d + 1] - reduced[d + 1 :]).T / (2 * STEP)


def gram_of(residuals: Residuals, interval: int, domain: Domain, collocation: Collocation) -> FloatArray:
    """What one interval adds to the misfit's matrix, (S, S). Raises FloatingPointError where the model overflows."""
    values = residuals(domain.out(collocation.points), interval)
    if not np.isfinite(values).all():
        raise FloatingPointError("the model gives no finite prediction somewhere in the prior's range")
    return gram(product(values.T, collocation.inverse.T))


def surrogate(matrix: FloatArray, domain: Domain, collocation: Collocation) -> Surrogate:
    """From the sum of all intervals' matrices."""
    sizes, vectors = np.linalg.eigh(matrix)
    keep = sizes > SMALLEST * sizes[-1]
    root = np.sqrt(sizes[keep])[:, None] * vectors[:, keep].T
    return Surrogate(domain, collocation, root)


def hold_out_error(found: Surrogate, residuals: Residuals, intervals: Sequence[int], xi: FloatArray) -> float:
    """How far the surrogate's log likelihood is from the model's at xi (n, d): the standard deviation of the difference.

    A common shift moves no estimate; 0.1 moves none by a twentieth of its standard deviation.
    """
    true = np.zeros(len(xi))
    for interval in intervals:
        true += np.sum(residuals(found.domain.out(xi), interval) ** 2, axis=1)
    return float(np.std(0.5 * (found.misfit(xi) - true)))
