"""Polynomials of one variable that are orthonormal under its probability density.

    sqrt(b[k+1]) p[k+1](x) = (x - a[k]) p[k](x) - sqrt(b[k]) p[k-1](x),   p[0] = 1

One three-term recurrence serves all families; only a and b differ. Leading coefficients are positive.

family    variable                                     a[k], b[k]
legendre  uniform on [-1, 1]                           0, k² / (4 k² - 1)
jacobi    Beta(a, b) moved from [0, 1] to [-1, 1]      those of Jacobi's polynomials with exponents b - 1 and a - 1
hermite   standard normal                              0, k
laguerre  Gamma(k), scale 1, on [0, inf)               2 k + shape, k (k + shape - 1)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from parsers.channels import FloatArray
from parsers.errors import ExpansionError
from pipelines.chaos.kernels import polynomials

SHAPES = (0.01, 1e4)
"""The range of shape parameters within which recurrences and quantiles keep their digits."""

Kind = Literal["legendre", "jacobi", "hermite", "laguerre"]


@dataclass(frozen=True)
class Basis:
    """A random variable and its orthonormal polynomials; made by `legendre`, `jacobi`, `hermite` and `laguerre`.

    kind: the family. first, second: its shape: a and b of Beta(a, b); k of Gamma(k) and 0; else both 0.
    """

    kind: Kind
    first: float = 0.0
    second: float = 0.0

    def __post_init__(self) -> None:
        """Raise ExpansionError for a shape that no density has."""
        shapes = {"jacobi": (self.first, self.second), "laguerre": (self.first,)}.get(self.kind, ())
        if self.kind not in ("legendre", "jacobi", "hermite", "laguerre"):
            raise ExpansionError(f"{self.kind!r} is no family of polynomials")
        for shape in shapes:
            if not SHAPES[0] <= shape <= SHAPES[1]:
                raise ExpansionError(
                    f"the shape of a {self.kind} basis is {SHAPES[0]:g} to {SHAPES[1]:g}, not {shape:g}"
                )

    @property
    def support(self) -> tuple[float, float]:
        """The interval outside of which the density is 0."""
        if self.kind == "hermite":
            return -math.inf, math.inf
        return (0.0, math.inf) if self.kind == "laguerre" else (-1.0, 1.0)

    def recurrence(self, count: int) -> tuple[FloatArray, FloatArray]:
        """a[0 .. count-1] and sqrt(b[0 .. count-1]), with b[0] = 0, each (count,)."""
        k = np.arange(count, dtype=float)
        if self.kind == "hermite":
            return np.zeros(count), np.sqrt(k)
        if self.kind == "laguerre":
            return 2 * k + self.first, np.sqrt(k * np.maximum(k + self.first - 1, 0.0))
        if self.kind == "legendre":
            return np.zeros(count), k / np.sqrt(np.maximum(4 * k * k - 1, 1.0))
        return _jacobi_recurrence(k, self.first, self.second)

    def evaluate(self, x: FloatArray, order: int) -> FloatArray:
        """p[0] .. p[order] at each x: (n,) -> (n, order + 1). Column 0 is 1."""
        if order < 0:
            raise ExpansionError(f"the order of an expansion is at least 0, not {order}")
        values = np.ascontiguousarray(x, dtype=float)
        if values.ndim != 1:
            raise ValueError("the points of one variable are one column")
        out = np.empty((order + 1, len(values)))
        centre, root = self.recurrence(order + 1)
        polynomials(values, centre, root, out)
        return np.ascontiguousarray(out.T)

    def density(self, x: FloatArray) -> FloatArray:
        """The probability density at each x, as x in shape; 0 outside of the support."""
        x = np.asarray(x, dtype=float)
        if self.kind == "hermite":
            return np.asarray(np.exp(-0.5 * x * x) / math.sqrt(2 * math.pi))
        low, high = self.support
        inside = (x >= low) & (x <= high) & np.isfinite(x)
        if self.kind == "legendre":
            return np.where(inside, 0.5, 0.0)
        from scipy.special import betaln, gammaln, xlog1py, xlogy

        # any value will do where the density is 0
        within = np.where(inside, x, 0.5)
        a, b = self.first, self.second
        if self.kind == "laguerre":
            log = np.asarray(xlogy(a - 1, within) - within - gammaln(a))
        else:
            log = np.asarray(
                xlog1py(a - 1, within) + xlog1py(b - 1, -within) - betaln(a, b) - (a + b - 1) * math.log(2)
            )
        return np.where(inside, np.exp(log), 0.0)

    def quantile(self, u: FloatArray) -> FloatArray:
        """The value below which the variable lies with probability u, as u in shape; u in (0, 1)."""
        u = np.asarray(u, dtype=float)
        if self.kind == "legendre":
            return np.asarray(2 * u - 1)
        from scipy.special import betaincinv, gammaincinv, ndtri

        if self.kind == "hermite":
            return np.asarray(ndtri(u))
        if self.kind == "laguerre":
            return np.asarray(gammaincinv(self.first, u))
        return np.asarray(2 * betaincinv(self.first, self.second, u) - 1)

    def sample(self, rng: np.random.Generator, n: int) -> FloatArray:
        """n independent draws, (n,)."""
        if self.kind == "legendre":
            return rng.uniform(-1.0, 1.0, n)
        if self.kind == "hermite":
            return rng.standard_normal(n)
        if self.kind == "laguerre":
            return rng.standard_gamma(self.first, n)
        return 2 * rng.beta(self.first, self.second, n) - 1

    def gauss(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Nodes and weights, each (count,), exact for polynomials up to degree 2 count - 1 (Golub & Welsch).

        The weights sum to 1. They are taken from the polynomials at the nodes, which keeps small ones exact.
        Raises ExpansionError where so many nodes leave the range of floating point numbers.
        """
        from scipy.linalg import eigh_tridiagonal

        if count < 1:
            raise ExpansionError(f"a Gauss rule has at least one node, not {count}")
        centre, root = self.recurrence(count)
        nodes = np.asarray(eigh_tridiagonal(centre, root[1:], eigvals_only=True), dtype=float)
        with np.errstate(over="ignore", invalid="ignore"):
            total = np.square(self.evaluate(nodes, count - 1)).sum(axis=1)
        if not np.isfinite(total).all():
            raise ExpansionError(
                f"a {self.kind} Gauss rule of {count} nodes is too large", hint="use fewer nodes"
            )
        return nodes, 1 / total


def _jacobi_recurrence(k: FloatArray, a: float, b: float) -> tuple[FloatArray, FloatArray]:
    """a[k] and sqrt(b[k]) for Beta(a, b) on [-1, 1]; k = 0, 1, 2, ..."""
    total = a + b
    twice = 2 * k + total
    centre = np.full(len(k), (a - b) / total)
    centre[1:] = (a - b) * (total - 2) / ((twice[1:] - 2) * twice[1:])
    squares = np.zeros(len(k))
    # the general form is 0 / 0 in the first two for some shapes
    if len(k) > 1:
        squares[1] = 4 * a * b / (total * total * (total + 1))
    n, two = k[2:], twice[2:]
    squares[2:] = (
        4 * n * (n + a - 1) * (n + b - 1) * (n + total - 2) / ((two - 2) ** 2 * (two - 1) * (two - 3))
    )
    return centre, np.sqrt(squares)


def legendre() -> Basis:
    """Uniform on [-1, 1]."""
    return Basis("legendre")


def jacobi(a: float, b: float) -> Basis:
    """Beta(a, b), density proportional to (1 + x)^(a - 1) (1 - x)^(b - 1) on [-1, 1]; a, b > 0."""
    return Basis("jacobi", float(a), float(b))


def hermite() -> Basis:
    """Standard normal; the probabilists' polynomials."""
    return Basis("hermite")


def laguerre(k: float = 1.0) -> Basis:
    """Gamma of shape k and scale 1, density proportional to x^(k - 1) exp(-x); k > 0. k = 1 is exponential."""
    return Basis("laguerre", float(k))
