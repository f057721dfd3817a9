"""Fleets that are exactly linear and Gaussian, drawn from the model of `pipelines.hierarchy`, and one dense solution of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipelines.hierarchy.common import common_directions, shared_error
from pipelines.hierarchy.records import DriveTold
from pipelines.hierarchy.shared import own_shares
from pipelines.joint.kept import KeptRelations
from pipelines.results import FloatArray

NAMES = ("spring_front", "empty_h", "load", "stuck_fl", "bump_front", "somebody_else")
MEAN = np.array([30e3, 0.6, 150.0, 0.0, 1500.0, 1.0])
STD = np.array([900.0, 0.03, 170.0, 100.0, 400.0, 0.3])
RELATIONS = (("weight", "vertical", "scales", 3), ("roll", "roll", "springs", 2))


@dataclass(frozen=True)
class Drawn:
    """Drives with what is true in them. truth: (n, k)."""

    kept: tuple[KeptRelations, ...]
    truth: FloatArray


def slopes(rng: np.random.Generator) -> FloatArray:
    """(m, k) whitened slopes by the unknowns in standard deviations."""
    return rng.normal(0.0, 1.5, (sum(r[3] for r in RELATIONS), len(NAMES)))


def labels() -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """relation, kind and source of each row."""
    rows = [(title, kind, source) for title, kind, source, count in RELATIONS for _ in range(count)]
    return tuple(zip(*rows, strict=True))  # type: ignore[return-value]


def kept_of_rows(by_u: FloatArray, observed_u: FloatArray) -> KeptRelations:
    """Relations from slopes by u and what they observed of u = (v - MEAN) / STD."""
    rows = by_u / STD
    relation, kind, source = labels()
    return KeptRelations(
        NAMES, MEAN, STD, MEAN.copy(), rows, observed_u + rows @ MEAN, relation, kind, source, {}, {}, 1.0, True
    )  # fmt: skip


def _groups() -> list[slice]:
    ends = np.cumsum([0, *(r[3] for r in RELATIONS)])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def draw(rng: np.random.Generator, count: int, rho: float, by_u: Sequence[FloatArray] | None = None) -> Drawn:
    """A vehicle with `count` drives: shared unknowns, scatter, and errors of which a share rho is common."""
    f = own_shares(NAMES, MEAN, STD)
    s = rng.standard_normal(len(NAMES))
    seen = [slopes(rng) for _ in range(count)] if by_u is None else list(by_u)
    u = np.sqrt(1 - f) * s + np.sqrt(f) * rng.standard_normal((count, len(NAMES)))
    errors = [np.zeros(len(j)) for j in seen]
    for group in _groups():
        root = common_directions([j[group] for j in seen], rho) if rho else np.zeros((len(NAMES), 1))
        common = rng.standard_normal(root.shape[1])
        for i, j in enumerate(seen):
            bias, left = shared_error(j[group], root, rho)
            errors[i][group] = bias @ common + np.linalg.cholesky(left) @ rng.standard_normal(len(left))
    kept = tuple(kept_of_rows(j, j @ x + e) for j, x, e in zip(seen, u, errors, strict=True))
    return Drawn(kept, MEAN + STD * u)


def dense(kept: Sequence[KeptRelations], rho: float) -> tuple[FloatArray, FloatArray]:
    """Mean (n k,) and covariance (n k, n k) of all drives' unknowns by one Kalman step with full matrices, SI."""
    n, k = len(kept), len(NAMES)
    f = own_shares(NAMES, MEAN, STD)
    prior = np.kron(np.ones((n, n)), np.diag((1 - f) * STD**2)) + np.kron(np.eye(n), np.diag(f * STD**2))
    m = len(kept[0].rows)
    rows = np.zeros((n * m, n * k))
    for i, one in enumerate(kept):
        rows[i * m : (i + 1) * m, i * k : (i + 1) * k] = one.rows
    noise = np.eye(n * m)
    for group in _groups():
        root = common_directions([(one.rows * STD)[group] for one in kept], rho) if rho else np.zeros((k, 1))
        parts = [shared_error((one.rows * STD)[group], root, rho)[0] for one in kept]
        for i, a in enumerate(parts):
            for j, b in enumerate(parts):
                if i != j:
                    at = np.ix_(
                        np.arange(n * m)[i * m : (i + 1) * m][group],
                        np.arange(n * m)[j * m : (j + 1) * m][group],
                    )
                    noise[at] += a @ b.T
    observed = np.concatenate([one.observed for one in kept])
    mean = np.tile(MEAN, n)
    gain = prior @ rows.T @ np.linalg.inv(rows @ prior @ rows.T + noise)
    return mean + gain @ (observed - rows @ mean), prior - gain @ rows @ prior


def told(kept: Sequence[KeptRelations | None]) -> list[DriveTold]:
    """As drives, a day each."""
    return [DriveTold(f"d{i:02d}", f"2024-01-{i + 1:02d}T08:00:00+00:00", {}, k) for i, k in enumerate(kept)]
