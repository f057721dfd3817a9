"""Does each relation go with all others? What one that does not makes of the intervals.

With A the relation's information and S the posterior's covariance, the posterior without it has S₋ = (S⁻¹ - A)⁻¹; there
its whitened residual is r₋ = r + J S₋ J' r with covariance I + J S₋ J', so that chi² = r' (I + J S₋ J') r of m figures
(the residual r taken at the joint mode, to the last step: where the rest leaves a thousand times more open than the relation does,
a hundredth of its noise would count for ten).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.joint.posterior import Joint
from pipelines.results import FloatArray, RelationCheck

UNLIKELY = 0.003
"""Probability of a misfit by chance below which a relation is called in conflict: a false alarm in some 300 checks."""

BEYOND_DOUBT = 1e-6
"""Probability below which something is surely wrong: the file of another vehicle, a channel that is another. Nothing is then identified."""

CONTRADICTED = "the log and what was known contradict each other beyond doubt"
"""How the reasons of a verdict begin that has one."""

LIKELY = 0.05
"""Widened so far that a misfit of this probability is left."""

WIDEST = 1e3
"""No spread is sought beyond this factor: it is the priors that contradict each other then."""


@dataclass(frozen=True)
class Check:
    """A relation against the rest. shift: (k,) what leaving it out moves u by."""

    record: RelationCheck
    shift: FloatArray

    @property
    def in_conflict(self) -> bool:
        """Whether the relation contradicts the rest."""
        return self.record.probability < UNLIKELY

    @property
    def beyond_doubt(self) -> bool:
        """Whether chance is no explanation."""
        return self.record.probability < BEYOND_DOUBT


@dataclass(frozen=True)
class _Cavity:
    """A relation's misfit against the rest along the axes (m,) of what the rest leaves open; spread: variance there, own noise 1."""

    along: FloatArray
    spread: FloatArray

    def chi2(self, rows: NDArray[np.bool_], factor: float = 1.0) -> float:
        """Misfit in some axes with the relation's own covariance times factor²."""
        return float(np.sum(self.along[rows] ** 2 / (factor**2 + self.spread[rows])))


def _cavity(residual: FloatArray, inner: FloatArray) -> _Cavity:
    spread, axes = np.linalg.eigh(0.5 * (inner + inner.T))
    return _Cavity(axes.T @ (residual + inner @ residual), np.maximum(spread, 0.0))


def check(joint: Joint) -> tuple[Check, ...]:
    """Every relation against the posterior of all others and the priors.

    Tested are all figures of a relation, and those axes alone in which what the rest leaves open outweighs the relation's own
    noise: there it speaks of the vehicle, and a dozen quiet axes of fit would hide what one says.
    """
    from scipy.stats import chi2 as law

    found = []
    step = joint.last_step()
    for i, part in enumerate(joint.parts):
        spread = joint.without(i)
        r = part.residual - part.slope @ step
        cavity = _cavity(r, part.slope @ spread @ part.slope.T)
        tests = []
        for rows in (np.ones(len(r), dtype=bool), cavity.spread > 1.0):
            if rows.any():
                misfit = cavity.chi2(rows)
                tests.append((float(law.sf(misfit, int(rows.sum()))), misfit, rows))
        probability, misfit, rows = min(tests, key=lambda test: test[0])
        if len({int(test[2].sum()) for test in tests}) > 1:
            # the worse of two: either may be as unlikely by chance
            probability = 1 - (1 - probability) ** 2
        factor = 1.0
        if probability < UNLIKELY:
            limit = float(law.isf(LIKELY, int(rows.sum())))
            while cavity.chi2(rows, factor) > limit and factor < WIDEST:
                factor *= 1.1
        text = "goes with the rest" if probability >= UNLIKELY else "contradicts the rest"
        e = part.evidence
        record = RelationCheck(e.title, e.source, int(rows.sum()), misfit, probability, factor, text)
        # at the joint mode the gradient vanishes: without the relation the mode moves by what it had pulled
        found.append(Check(record, np.asarray(-spread @ (part.slope.T @ r))))
    return tuple(found)


def held(joint: Joint, checks: Sequence[Check], gradient: FloatArray) -> float:
    """Variance to add to a parameter so that its interval holds what it would be without a relation in conflict."""
    moved = [float(gradient @ c.shift) for c in checks if c.in_conflict]
    return max((m * m for m in moved), default=0.0)
