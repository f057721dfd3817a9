"""Points at which a model is run, and the matrix that turns its values into coefficients (equations 10-16)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.errors import ExpansionError
from pipelines.chaos.space import Space, check_size, total_degree

Kind = Literal["hammersley", "random"]

WORST_CONDITION = 100.0
"""Beyond it, errors of the coefficients are some 10 times what the truncation leaves out, and more."""

DRAWS = 50
FACTORS = (1.0, 1000.0)

_WELL = 50.0
"""Up to this condition its square, times the rounding error, still leaves 12 digits: the quick way is good enough."""


@dataclass(frozen=True)
class Collocation:
    """A set of points for one index set.

    indices: (S, d). points: (Q, d). matrix: (Q, S), each term at each point. inverse: (S, Q), its pseudo-inverse:
    coefficients = inverse @ values. condition: of the matrix, in the 2-norm; 1 is the best.
    """

    space: Space
    indices: IntArray
    points: FloatArray
    matrix: FloatArray
    inverse: FloatArray
    condition: float


def hammersley(count: int, dimensions: int) -> FloatArray:
    """Evenly spread points in the open unit cube, (count, d): equal steps, then radical inverses in prime bases.

    Good for few variables: in a late prime base, few points lie almost on a line.
    """
    out = np.empty((count, dimensions))
    out[:, 0] = (np.arange(count) + 0.5) / count
    for j, prime in enumerate(_primes(dimensions - 1), start=1):
        rest = np.arange(1, count + 1)
        total, step = np.zeros(count), 1.0
        while rest.any():
            step /= prime
            rest, digit = np.divmod(rest, prime)
            total += step * digit
        out[:, j] = total
    return out


def _primes(count: int) -> list[int]:
    found: list[int] = []
    number = 2
    while len(found) < count:
        if all(number % prime for prime in found):
            found.append(number)
        number += 1
    return found


def collocate(
    space: Space,
    order: int,
    *,
    factor: float = 4.0,
    kind: Kind = "hammersley",
    rng: np.random.Generator | None = None,
    worst_condition: float = WORST_CONDITION,
) -> Collocation:
    """Points for all terms up to `order`: factor times as many as terms (1 at least; 3 to 4 for accuracy).

    kind: hammersley (always the same points) or random (independent draws from `rng`; a set whose condition is above
    `worst_condition` is drawn again, up to DRAWS times).
    Raises ExpansionError where no set is good enough or the sizes are out of range, and ValueError for random points
    without a generator.
    """
    if not FACTORS[0] <= factor <= FACTORS[1]:
        raise ExpansionError(
            f"points are {FACTORS[0]:g} to {FACTORS[1]:g} times as many as terms, not {factor:g} times"
        )
    indices = total_degree(space.dimensions, order)
    count = round(factor * len(indices))
    check_size(count, max(len(indices), space.dimensions))
    if kind == "hammersley":
        best = collocate_at(space, indices, space.quantile(hammersley(count, space.dimensions)))
    elif kind != "random" or rng is None:
        raise ValueError("points are hammersley, or random from a generator")
    else:
        best = collocate_at(space, indices, space.sample(rng, count))
        for _ in range(DRAWS - 1):
            if best.condition <= worst_condition:
                break
            drawn = collocate_at(space, indices, space.sample(rng, count))
            best = min(best, drawn, key=lambda each: each.condition)
    if not best.condition <= worst_condition:
        raise ExpansionError(
            f"{count} {kind} points for {len(indices)} terms: the matrix's condition is {best.condition:.3g}, above "
            f"{worst_condition:.3g}",
            hint="use more points a term or a lower order, or allow a worse condition",
        )
    return best


def collocate_at(space: Space, indices: IntArray, points: FloatArray) -> Collocation:
    """The collocation of given points (Q, d) and terms (S, d), whatever its condition is.

    Raises ExpansionError where points are fewer than terms or not finite.
    """
    matrix = space.matrix(points, indices)
    if matrix.shape[0] < matrix.shape[1]:
        raise ExpansionError(f"{matrix.shape[0]} points cannot determine {matrix.shape[1]} coefficients")
    if not np.isfinite(matrix).all():
        raise ExpansionError("collocation points are not finite, or too far out for these polynomials")
    inverse, condition = _pseudo_inverse(matrix)
    return Collocation(space, indices, points, matrix, inverse, condition)


def _pseudo_inverse(matrix: FloatArray) -> tuple[FloatArray, float]:
    """The pseudo-inverse (S, Q) of a matrix (Q, S), and its condition in the 2-norm (inf where it is singular)."""
    gram = matrix.T @ matrix
    sizes = np.linalg.eigvalsh(gram)
    if sizes[0] * _WELL**2 >= sizes[-1]:
        return np.linalg.inv(gram) @ matrix.T, float(np.sqrt(sizes[-1] / sizes[0]))
    left, sizes, right = np.linalg.svd(matrix, full_matrices=False)
    keep = sizes > sizes[0] * max(matrix.shape) * np.finfo(float).eps
    inverse = (right[keep].T / sizes[keep]) @ left[:, keep].T
    return inverse, float(sizes[0] / sizes[-1]) if keep.all() else np.inf
