"""Several independent random variables, and products of their polynomials (dissertation, equations 4-6)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.errors import ExpansionError
from pipelines.chaos.bases import Basis
from pipelines.chaos.kernels import fill_matrix, fill_total_degree, grow_tree

MOST_TERMS = 200_000
MOST_ENTRIES = 100_000_000
"""Above so many terms, or numbers in one matrix, a settings file asks for more than a machine has."""


def term_count(dimensions: int, order: int) -> int:
    """S of equation (5): the number of terms of total degree up to `order` in so many variables."""
    return math.comb(dimensions + order, order)


def total_degree(dimensions: int, order: int) -> IntArray:
    """The powers of each term, (S, d): row 0 zeros, rows 1 .. d the first powers of variable 1 .. d, then by degree.

    Within a degree the earlier variables' powers come first: (2, 0), (1, 1), (0, 2).
    Raises ExpansionError for fewer than one variable, an order below 0, or a set beyond MOST_TERMS.
    """
    if dimensions < 1 or order < 0:
        raise ExpansionError(
            f"{dimensions} variables to order {order}: at least 1 variable and order 0 are needed"
        )
    terms = term_count(dimensions, order)
    if terms > MOST_TERMS or terms * dimensions > MOST_ENTRIES:
        raise ExpansionError(
            f"{dimensions} variables to order {order} make {terms} terms",
            hint="lower the order of the expansion",
        )
    out = np.empty((terms, dimensions), dtype=np.int64)
    fill_total_degree(order, out)
    return out


def check_size(points: int, terms: int) -> None:
    """Raise ExpansionError where a matrix of so many points and terms is beyond MOST_ENTRIES."""
    if points * terms > MOST_ENTRIES:
        raise ExpansionError(
            f"a matrix of {points} points and {terms} terms is too large",
            hint="lower the order of the expansion, or use fewer points",
        )


@dataclass(frozen=True)
class Plan:
    """An index set as a tree of products (kernels.py). nodes: (T, 3); place: (S,); levels; degree: the highest power."""

    nodes: IntArray
    place: IntArray
    levels: int
    degree: int


def plan(indices: IntArray) -> Plan:
    """The tree of an index set (S, d). Any set will do: products that only others need become nodes too."""
    indices = np.ascontiguousarray(indices, dtype=np.int64)
    if indices.ndim != 2 or not indices.size or indices.min() < 0:
        raise ValueError("indices are rows of powers that are at least 0, one column a variable")
    rows, dimensions = indices.shape
    order = np.lexsort(indices.T[::-1])
    nodes = np.empty((np.count_nonzero(indices) + 1, 3), dtype=np.int64)
    place = np.empty(rows, dtype=np.int64)
    count = grow_tree(indices, order, nodes, place, np.empty(dimensions, dtype=np.int64))
    nodes = nodes[:count].copy()
    return Plan(nodes, place, int(nodes[:, 0].max()), int(nodes[:, 2].max()))


@dataclass(frozen=True)
class Space:
    """Independent random variables, one basis each."""

    bases: tuple[Basis, ...]

    def __post_init__(self) -> None:
        """Raise ExpansionError where there is no variable."""
        if not self.bases:
            raise ExpansionError("an expansion needs at least one variable")

    @property
    def dimensions(self) -> int:
        """d, the number of variables."""
        return len(self.bases)

    def points(self, points: FloatArray) -> FloatArray:
        """`points` as the kernels take them: (Q, d), contiguous. ValueError for another shape."""
        points = np.ascontiguousarray(points, dtype=float)
        if points.ndim != 2 or points.shape[1] != self.dimensions:
            raise ValueError(f"points are rows of {self.dimensions} values")
        return points

    def recurrences(self, order: int) -> tuple[FloatArray, FloatArray]:
        """The recurrences of all variables up to `order`, each (d, order + 1)."""
        pairs = [basis.recurrence(order + 1) for basis in self.bases]
        return np.array([centre for centre, _ in pairs]), np.array([root for _, root in pairs])

    def matrix(self, points: FloatArray, indices: IntArray) -> FloatArray:
        """Each term at each point, (Q, S): equation (12). points: (Q, d). indices: (S, d)."""
        points = self.points(points)
        check_size(len(points), len(indices))
        tree = self.plan(indices)
        centre, root = self.recurrences(tree.degree)
        out = np.empty((len(points), len(tree.place)))
        fill_matrix(points, centre, root, tree.nodes, tree.place, tree.levels, out)
        return out

    def plan(self, indices: IntArray) -> Plan:
        """The tree of an index set of this space. ValueError where its columns are not the variables."""
        if indices.ndim != 2 or indices.shape[1] != self.dimensions:
            raise ValueError(f"indices are rows of {self.dimensions} powers")
        return plan(indices)

    def quantile(self, u: FloatArray) -> FloatArray:
        """Points of the space from points of the unit cube, (Q, d) -> (Q, d)."""
        return np.column_stack([basis.quantile(u[:, j]) for j, basis in enumerate(self.bases)])

    def sample(self, rng: np.random.Generator, n: int) -> FloatArray:
        """n independent draws, (n, d)."""
        return np.column_stack([basis.sample(rng, n) for basis in self.bases])

    def density(self, points: FloatArray) -> FloatArray:
        """The joint density at points (Q, d): (Q,)."""
        points = self.points(points)
        out = np.ones(len(points))
        for j, basis in enumerate(self.bases):
            out *= basis.density(points[:, j])
        return out
