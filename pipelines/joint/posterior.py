"""The joint posterior over the vehicle's unknowns: its mode, its curvature there, and its density anywhere.

Unknowns u are in prior standard deviations, so that the prior is N(0, I). A relation's whitened residual
r(u) = L⁻¹ (observed - predict(u)), L L' its covariance, adds r'r / 2 to minus the log density (Gauss-Newton, damped).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from pipelines.evidence import Evidence
from pipelines.joint.vehicle.remembered import Remembered
from pipelines.joint.vehicle.unknowns import Known
from pipelines.results import FloatArray

LogDensity = Callable[[FloatArray], FloatArray]
STEP = 1e-3
MOST_STEPS = 60
SETTLED = 1e-3
"""Nats that a full step would still gain, below which the search has ended."""

ENOUGH = 1.0
"""The same while the relations are taken as less sharp than they are: those places are only passed through."""

NEARLY = 5.0
"""The same below which a full step is tried by itself."""

LADDER = np.array([0.01, 0.1, 1.0, 10.0, 100.0])
BLUNT = (30.0, 5.0, 1.0)
"""Factors on the relations' standard deviations, one search after the other."""

FARTHEST = 8.0
"""Prior standard deviations beyond which the density is taken as nought: nothing that is known is that wrong."""


@dataclass(frozen=True)
class Part:
    """A relation at the mode. residual: (m,) whitened; slope: (m, k), derivative of the whitened prediction by u."""

    evidence: Evidence
    whitener: FloatArray
    residual: FloatArray
    slope: FloatArray

    @property
    def information(self) -> FloatArray:
        """(k, k) what the relation adds to the curvature."""
        return np.asarray(self.slope.T @ self.slope)


@dataclass(frozen=True)
class Joint:
    """The posterior. known: the unknowns, those of single relations at the end. u: (k,) mode; covariance: (k, k) of u.

    given: measured figures that outputs need. cost: minus the log density at the mode. converged: whether it settled.
    """

    known: Known
    parts: tuple[Part, ...]
    u: FloatArray
    covariance: FloatArray
    given: Mapping[str, float]
    cost: float
    converged: bool

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """The relations that were counted."""
        return tuple(part.evidence for part in self.parts)

    def last_step(self) -> FloatArray:
        """(k,) from u to where the linear posterior has no slope: what the search, which ends by what it would gain, left undone."""
        pulled = [p.slope.T @ p.residual for p in self.parts]
        return np.asarray(self.covariance @ (np.sum(pulled, axis=0) - self.u)) if pulled else -self.u

    def without(self, left_out: int) -> FloatArray:
        """(k, k) covariance had one relation not been there."""
        rest = [p.information for i, p in enumerate(self.parts) if i != left_out]
        return _inverse(np.eye(len(self.u)) + (np.sum(rest, axis=0) if rest else 0.0))

    def alone(self, kept: int) -> FloatArray:
        """(k, k) covariance had only that relation been there."""
        return _inverse(np.eye(len(self.u)) + self.parts[kept].information)


def _inverse(matrix: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.inv(0.5 * (matrix + matrix.T)))


def values_at(known: Known, u: FloatArray) -> Remembered[FloatArray]:
    """The unknowns in SI by name: u (k,) gives numbers, (n, k) gives (n,) each."""
    return Remembered(zip(known.names, (known.mean + known.std * u).T, strict=True))


def both_ways(u: FloatArray, rows: IntArray | None = None) -> FloatArray:
    """(2 m + 1, k): u (k,), then each of m rows (all) a step up, then each a step down: for `central`."""
    rows = np.arange(len(u)) if rows is None else rows
    count, steps = len(rows), np.arange(len(rows))
    moved = np.tile(u, (2 * count + 1, 1))
    moved[1 + steps, rows] += STEP
    moved[1 + count + steps, rows] -= STEP
    return moved


def central(found: FloatArray) -> FloatArray:
    """(..., m) central differences of what was found (..., 2 m + 1) at `both_ways`."""
    count = found.shape[-1] // 2
    return np.asarray((found[..., 1 : 1 + count] - found[..., 1 + count :]) / (2 * STEP))


def extended(known: Known, evidence: Sequence[Evidence]) -> Known:
    """The unknowns with those that single relations have of their own."""
    own = {unknown.name: unknown for e in evidence for unknown in e.own if unknown.name not in known.names}
    if not own:
        return known
    return replace(
        known,
        names=(*known.names, *own),
        mean=np.append(known.mean, [o.mean for o in own.values()]),
        std=np.append(known.std, [o.std for o in own.values()]),
    )


def whitener_of(covariance: FloatArray) -> FloatArray:
    """(m, m) inverse of the Cholesky factor. Raises LinAlgError where the covariance is none."""
    scale = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance / np.outer(scale, scale))
    return np.asarray(np.linalg.inv(root) / scale)


def parts_at(
    evidence: Sequence[Evidence], known: Known, u: FloatArray, whiteners: Sequence[FloatArray]
) -> tuple[Part, ...]:
    """Relations at u (k,) with their slopes by central differences: all unknowns of all of them in the same vehicles.

    So what several relations ask of a vehicle is reckoned once (`pipelines.joint.vehicle.remembered`).
    """
    at = {name: i for i, name in enumerate(known.names)}
    used = sorted({at[name] for e in evidence for name in e.unknowns})
    columns = np.array(used, dtype=np.int64)
    values = values_at(known, both_ways(u, columns))
    found = []
    for e, whitener in zip(evidence, whiteners, strict=True):
        rows = np.array([at[name] for name in e.unknowns], dtype=np.int64)
        predicted = e.predict(values)
        slope = np.zeros((len(e.observed), len(u)))
        slope[:, rows] = central(predicted)[:, np.searchsorted(columns, rows)]
        found.append(Part(e, whitener, whitener @ (e.observed - predicted[:, 0]), whitener @ slope))
    return tuple(found)


def part_at(evidence: Evidence, known: Known, u: FloatArray, whitener: FloatArray) -> Part:
    """A single relation at u (k,), its slope by central differences, all unknowns in one call."""
    return parts_at((evidence,), known, u, (whitener,))[0]


def _possible(u: FloatArray, cost: FloatArray) -> FloatArray:
    """(n,) cost (n,), infinite where u (n, k) is farther than anything that is known."""
    possible = np.isfinite(cost) & (np.abs(u).max(axis=1) < FARTHEST)
    return np.asarray(np.where(possible, cost, np.inf))


def _cost(
    evidence: Sequence[Evidence], whiteners: Sequence[FloatArray], known: Known, u: FloatArray
) -> FloatArray:
    """(n,) minus the log density of each row of u (n, k)."""
    values = values_at(known, u)
    cost = 0.5 * np.sum(u * u, axis=1)
    for e, whitener in zip(evidence, whiteners, strict=True):
        r = whitener @ (e.observed[:, None] - e.predict(values))
        cost = cost + 0.5 * np.sum(r * r, axis=0)
    return _possible(u, cost)


def log_density(joint: Joint) -> LogDensity:
    """Log of the posterior's density but for a constant: (n, k) -> (n,)."""
    evidence, whiteners = joint.evidence, [p.whitener for p in joint.parts]

    def density(u: FloatArray) -> FloatArray:
        return np.asarray(-_cost(evidence, whiteners, joint.known, u))

    return density


@dataclass(frozen=True)
class _At:
    """A place of the search. u: (k,); damping: of the next step; parts: the relations there, where they were asked."""

    u: FloatArray
    cost: float
    damping: float
    parts: tuple[Part, ...] | None = None


def _step(
    evidence: Sequence[Evidence], whiteners: Sequence[FloatArray], known: Known, at: _At
) -> tuple[_At, float]:
    """One damped Gauss-Newton step: where it leads, and the nats that a full one would gain at most."""
    u, parts = at.u, at.parts or parts_at(evidence, known, at.u, whiteners)
    slope = np.concatenate([np.zeros((0, len(u))), *(p.slope for p in parts)])
    curvature = np.eye(len(u)) + slope.T @ slope
    gradient = u - slope.T @ np.concatenate([np.zeros(0), *(p.residual for p in parts)])
    whole = np.linalg.solve(curvature, -gradient)
    left = -0.5 * float(gradient @ whole)
    if left < NEARLY and at.damping <= 1:
        # a full step will do: asked with its slopes at once, as the next step needs them
        trial = np.clip(u + whole, -FARTHEST + 0.01, FARTHEST - 0.01)
        there = parts_at(evidence, known, trial, whiteners)
        misfit = float(trial @ trial) + sum(float(p.residual @ p.residual) for p in there)
        if 0.5 * misfit < at.cost:
            return _At(trial, 0.5 * misfit, max(0.01 * at.damping, 1e-9), there), left
        if left < SETTLED:
            return replace(at, parts=parts), left
    # several dampings at once: a call for many vehicles costs little more than one for a single one
    ladder = at.damping * LADDER
    damped = curvature + ladder[:, None, None] * np.diag(np.diag(curvature))
    moves = np.linalg.solve(damped, -gradient[:, None])[:, :, 0]
    trials = np.clip(u + moves, -FARTHEST + 0.01, FARTHEST - 0.01)
    costs = _cost(evidence, whiteners, known, trials)
    best = int(np.argmin(costs))
    if not costs[best] < at.cost:
        return _At(u, at.cost, at.damping * 100, parts), left
    return _At(trials[best], float(costs[best]), float(np.clip(ladder[best], 1e-9, 1e3))), left


def _climb(
    evidence: Sequence[Evidence],
    whiteners: Sequence[FloatArray],
    known: Known,
    start: FloatArray,
    blunted: Sequence[float] = BLUNT,
) -> tuple[FloatArray, float, tuple[Part, ...], bool]:
    """Damped Gauss-Newton from `start`: mode, cost, relations there, whether it settled.

    The relations are first taken as less sharp than they are: products of unknowns make a narrow curved valley of them, in
    which straight steps are short. That also takes the search back to what is usual: `blunted` = (1,) stays near the start.
    """
    at, settled = _At(start.copy(), math.inf, 1e-3), False
    for blunt in blunted:
        softer = [w / blunt for w in whiteners]
        at = _At(at.u, float(_cost(evidence, softer, known, at.u[None])[0]), 1e-3)
        settled = False
        for _ in range(MOST_STEPS):
            at, left = _step(evidence, softer, known, at)
            settled = left < (SETTLED if blunt == 1 else ENOUGH)
            if settled or at.damping > 1e8:
                break
    return at.u, at.cost, at.parts or parts_at(evidence, known, at.u, whiteners), settled


def find_mode(
    evidence: Sequence[Evidence],
    known: Known,
    starts: Sequence[FloatArray] | None = None,
    near: Sequence[FloatArray] = (),
) -> Joint:
    """The most probable unknowns. starts: (k,) each, in prior standard deviations; the best end counts. near: more of them, which
    are near a mode of much the same relations.

    Raises LinAlgError where a relation's covariance is none.
    """
    known = extended(known, evidence)
    whiteners = [whitener_of(e.covariance) for e in evidence]
    first = [np.zeros(len(known.names))] if starts is None else [np.asarray(s) for s in starts]
    ends = [_climb(evidence, whiteners, known, s) for s in first]
    ends += [_climb(evidence, whiteners, known, np.asarray(s), BLUNT[-1:]) for s in near]
    u, cost, parts, settled = min(ends, key=lambda end: end[1])
    given: dict[str, float] = {}
    for e in evidence:
        given |= e.given
    curvature = np.eye(len(u)) + sum((p.information for p in parts), np.zeros((len(u), len(u))))
    if not math.isfinite(cost):
        raise np.linalg.LinAlgError("no vehicle that is known of fits the drive's relations")
    return Joint(known, parts, u, _inverse(curvature), given, cost, settled)
