"""Maximum a posteriori over all balances at once, from mean products of balances and instruments (Gauss-Newton).

Each balance's mean products have a covariance of their own, from the scatter of blocks of time and from the residual's
variance and autocorrelation, so that slow errors widen the interval. It stays fixed within an iteration: letting it
follow the unknowns would reward whatever makes residuals small.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from pipelines.estimators.load_balance.relations import IntArray, Relation
from pipelines.evidence import Evidence
from pipelines.joint.posterior import both_ways, central, values_at
from pipelines.joint.vehicle.unknowns import Known
from pipelines.results import FloatArray

HUBER = 2.5
ROUNDS = 4
STEPS = 6
MISFIT = 4.0
"""Share of the noise up to which what instruments explain of a residual is taken for noise too: right files gave up to 3.6 on 400 drives of the plant."""

LEAST_SHARE = 2e-3
"""Smallest standard deviation of a product, as a share of what it is without any model: nothing is known better."""


@dataclass(frozen=True)
class Reduced:
    """One balance as sums. blocks: (b, z, k) weighted products of instruments and columns; total: (z, k).

    covariance: (z, z) of total @ coefficients. residual: (n,) of the last fit. chi2: misfit in standard deviations².
    """

    relation: Relation
    blocks: FloatArray
    total: FloatArray
    covariance: FloatArray
    residual: FloatArray
    correlation_rows: float
    chi2: float


@dataclass(frozen=True)
class Fit:
    """The fit. u: (k,) unknowns in prior standard deviations; covariance: (k, k) of u. information: of each balance.

    inflation: factor on all standard deviations for balances that contradict each other or the vehicle file; `covariance` is without
    it, as doubts are weighed by it: what widens priors too would say that the log knows less than nothing.
    """

    known: Known
    u: FloatArray
    covariance: FloatArray
    reduced: tuple[Reduced, ...]
    information: tuple[FloatArray, ...]
    inflation: float

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """None: the balances have no unknowns beside `known` (see `pipelines.joint.doubts.weighed.Place`)."""
        return ()

    def values(self) -> dict[str, float]:
        """Unknowns, SI."""
        return self.known.at(self.u)


def jacobian(relation: Relation, known: Known, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Coefficients (k,) at u, and their derivative (k, unknowns) by u: central differences, all unknowns in one call."""
    rows = np.array(relation.unknowns, dtype=np.int64)
    values = cast("Mapping[str, float]", values_at(known, both_ways(u, rows)))
    theta = relation.vector(values).reshape(len(relation.columns), -1)
    out = np.zeros((len(theta), len(u)))
    out[:, rows] = central(theta)
    return theta[:, 0], out


def _starts(relation: Relation) -> IntArray:
    """(b,) first row of each block."""
    return np.flatnonzero(np.diff(relation.block, prepend=relation.block[0] - 1)).astype(np.int64)


def noise_of(instruments: FloatArray, residual: FloatArray, weight: FloatArray | None = None) -> FloatArray:
    """(n,) the residual, with no more of what the instruments explain of it than MISFIT times what they do not.

    A little misfit is the model's own and widens its balance as noise does. Beyond that it is a wrong figure's, and would silence the
    very balance that contradicts a file that is wrong by a factor.
    """
    z = instruments if weight is None else instruments * weight[:, None]
    gain, *_ = np.linalg.lstsq(z.T @ instruments, z.T @ residual, rcond=1e-10)
    explained = instruments @ gain
    rest = residual - explained
    most = MISFIT * float(np.sqrt(np.mean(rest * rest)))
    size = float(np.sqrt(np.mean(explained * explained)))
    return residual if size <= most else np.asarray(rest + most / size * explained)


def _sums(relation: Relation, weight: FloatArray) -> FloatArray:
    """(b, z, k) products of instruments and columns, block by block."""
    edges = _starts(relation)
    ends = np.append(edges[1:], len(relation.block))
    z = relation.instruments * weight[:, None]
    return np.array([z[i:j].T @ relation.table[i:j] for i, j in zip(edges, ends, strict=True)])


def _correlation_rows(residual: FloatArray, most: int) -> float:
    """Integrated autocorrelation of a residual in rows, at least 1; the sum ends at the first small value."""
    e = residual - residual.mean()
    n = len(e)
    spectrum = np.fft.rfft(e, 2 * n)
    auto = np.fft.irfft(spectrum * spectrum.conj())[: min(most, n)]
    if auto[0] <= 0:
        return 1.0
    rho = auto / auto[0]
    small = np.flatnonzero(rho < 0.05)
    stop = int(small[0]) if len(small) else len(rho)
    return float(max(1.0, 1 + 2 * rho[1:stop].sum()))


def _reduce(relation: Relation, known: Known, u: FloatArray, first: bool) -> Reduced:
    """Sums, weights and covariance at u."""
    theta = relation.vector(known.at(u))
    residual = relation.table @ theta
    noise = noise_of(relation.instruments, residual)
    scale = 1.4826 * float(np.median(np.abs(noise - np.median(noise)))) + 1e-12
    middle = 0.0 if not first else float(np.median(noise))
    weight = np.minimum(1.0, HUBER * scale / np.maximum(np.abs(noise - middle), 1e-12))
    if first:
        # the first guess is wrong by more than noise: only wild rows lose weight
        weight = np.minimum(1.0, 4 * weight)
    blocks = _sums(relation, weight)
    total = blocks.sum(axis=0)
    b = len(blocks)
    z = relation.instruments * weight[:, None]
    noise = noise_of(relation.instruments, residual, weight)
    # row by row: residuals are small where little road passes, and instruments may count those rows above all
    score = z * noise[:, None]
    scores = np.add.reduceat(score, _starts(relation))
    scattered = (scores - scores.mean(axis=0)).T @ (scores - scores.mean(axis=0)) * b / max(b - 1, 1)
    rows = _correlation_rows(weight * noise, max(10, len(residual) // max(b, 1)))
    even = rows * (score.T @ score)
    share = b / (b + 2.0 * z.shape[1])
    covariance = share * scattered + (1 - share) * even
    gross = np.abs(relation.table * theta).max(axis=1)
    floor = (LEAST_SHARE * (np.abs(z) * gross[:, None]).sum(axis=0)) ** 2
    covariance = covariance + np.diag(floor)
    inverse = np.linalg.inv(covariance)
    g = total @ theta
    return Reduced(relation, blocks, total, covariance, residual, rows, float(g @ inverse @ g))


def _step(
    reduced: Sequence[Reduced], known: Known, u: FloatArray, inverses: Sequence[FloatArray]
) -> tuple[FloatArray, list[FloatArray], float]:
    """One Gauss-Newton step: the new u, each balance's information (k, k), and the cost before it."""
    size = len(u)
    curvature, gradient = np.eye(size), u.copy()
    cost = 0.5 * float(u @ u)
    information = []
    for r, inverse in zip(reduced, inverses, strict=True):
        theta, derivative = jacobian(r.relation, known, u)
        g, j = r.total @ theta, r.total @ derivative
        info = j.T @ inverse @ j
        information.append(info)
        curvature += info
        gradient += j.T @ (inverse @ g)
        cost += 0.5 * float(g @ inverse @ g)
    return u - np.linalg.solve(curvature, gradient), information, cost


def _inverses(reduced: Sequence[Reduced]) -> list[FloatArray]:
    return [np.asarray(np.linalg.inv(r.covariance), dtype=np.float64) for r in reduced]


def solve(relations: Sequence[Relation], known: Known) -> Fit:
    """The most probable unknowns, and their covariance (Laplace)."""
    u = np.zeros(len(known.names))
    reduced: tuple[Reduced, ...] = ()
    information: list[FloatArray] = []
    for turn in range(ROUNDS):
        reduced = tuple(_reduce(r, known, u, turn == 0) for r in relations)
        inverses = _inverses(reduced)
        for _ in range(STEPS):
            new, information, _ = _step(reduced, known, u, inverses)
            moved = float(np.abs(new - u).max())
            u = u + np.clip(new - u, -3.0, 3.0)
            if moved < 1e-3:
                break
    reduced = tuple(_reduce(r, known, u, False) for r in relations)
    inverses = _inverses(reduced)
    _, information, _ = _step(reduced, known, u, inverses)
    covariance = np.linalg.inv(np.eye(len(u)) + np.sum(information, axis=0))
    misfit = sum(r.chi2 for r in reduced) + float(u @ u)
    products = sum(r.total.shape[0] for r in reduced)
    inflation = float(np.sqrt(max(1.0, misfit / max(products, 1))))
    return Fit(known, u, covariance, reduced, tuple(information), inflation)


def without(fit: Fit, left_out: int) -> FloatArray:
    """(k, k) covariance of u had one balance not been there, before anything widens it."""
    rest = [info for i, info in enumerate(fit.information) if i != left_out]
    total = np.eye(len(fit.u)) + (np.sum(rest, axis=0) if rest else 0.0)
    return np.asarray(np.linalg.inv(total))
