"""chaospy's terms matched with ours, and figures of its kept in a file, so that the comparison runs without it too.

Made again, where chaospy is installed, by `python -m tests.pipelines.chaos_peer`.
"""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.chaos.bases import Basis, hermite, jacobi, laguerre, legendre
from pipelines.chaos.collocation import Collocation, collocate
from pipelines.chaos.space import Space

SPACES = {
    "legendre": (Space((legendre(),) * 3), 4),
    "beta": (Space((jacobi(2, 3), jacobi(1, 5), jacobi(0.7, 0.4))), 3),
    "hermite": (Space((hermite(),) * 2), 4),
    "gamma": (Space((laguerre(2.0), laguerre(5.0))), 2),
    "mixed": (Space((legendre(), jacobi(2, 3), hermite(), laguerre(3.0))), 2),
}


def theirs(basis: Basis) -> Any:
    chaospy = importlib.import_module("chaospy")
    match basis.kind:
        case "legendre":
            return chaospy.Uniform(-1, 1)
        case "jacobi":
            return chaospy.Beta(basis.first, basis.second, -1, 1)
        case "hermite":
            return chaospy.Normal(0, 1)
        case "laguerre":
            return chaospy.Gamma(basis.first)


def peer(space: Space, order: int, points: Collocation) -> tuple[Any, Any, list[int]]:
    """Their distribution, their orthonormal polynomials, and which of them each of our terms is.

    The leading power of a product is the term's own row of powers: it is told apart by the highest total degree.
    """
    chaospy = importlib.import_module("chaospy")
    joint = chaospy.J(*[theirs(basis) for basis in space.bases])
    polynomials = chaospy.generate_expansion(order, joint, normed=True)
    leading = []
    for each in polynomials:
        powers = np.atleast_2d(each.exponents)
        top = powers[powers.sum(axis=1) == powers.sum(axis=1).max()]
        padded = np.zeros(space.dimensions, dtype=int)
        for name, power in zip(each.names, top[0], strict=True):
            padded[int(name[1:])] = power
        leading.append(tuple(padded))
    return joint, polynomials, [leading.index(tuple(row)) for row in points.indices.tolist()]


KEPT = Path(__file__).with_name("chaospy_figures.json")
FRESH = 4


def model(points: np.ndarray) -> np.ndarray:
    """A smooth function that no basis holds exactly. points: (n, d); gives (n,)."""
    weights = np.arange(1, points.shape[1] + 1)
    return np.asarray(np.exp(0.1 * points @ weights) + points[:, 0] * points[:, -1])


def fresh_points(space: Space) -> np.ndarray:
    """A few points of the space, the same at every call."""
    return space.sample(np.random.default_rng(5), FRESH)


def figures() -> dict[str, dict[str, Any]]:
    """What chaospy says of every space: its basis at the fresh points and its fit of `model`, in our order of terms."""
    chaospy = importlib.import_module("chaospy")
    told = {}
    for name, (space, order) in SPACES.items():
        points = collocate(space, order)
        joint, polynomials, where = peer(space, order, points)
        fit, found = chaospy.fit_regression(polynomials, points.points.T, model(points.points), retall=1)
        told[name] = {
            "basis": np.asarray(polynomials(*fresh_points(space).T))[where].T.tolist(),
            "coefficients": np.asarray(found)[where].tolist(),
            "variance": float(chaospy.Var(fit, joint)),
            "sobol_first": np.asarray(chaospy.Sens_m(fit, joint)).tolist(),
            "sobol_total": np.asarray(chaospy.Sens_t(fit, joint)).tolist(),
        }
    return told


if __name__ == "__main__":
    KEPT.write_text(json.dumps(figures()) + "\n", encoding="utf-8")
