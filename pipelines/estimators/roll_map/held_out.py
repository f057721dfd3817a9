"""How well a roll model foretells stretches of the drive that it was not fitted to."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from parsers.channels import IntArray
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.likelihood import RAN_OFF, Problem, huber
from pipelines.results import FloatArray

SPAN_S = 3.0
"""Least length of a stretch: longer than what is left over hangs together (road's roll, filters; not the bank, which all models share)."""

FEWEST, MOST = 6, 16
GUARD_S = 0.6
"""What the filter still remembers of a stretch after it: not learned from when that stretch is held out."""

RAN_AWAY = -1e6
"""Log likelihood of a stretch where the rest of the drive leads to a model that does not stand."""

CHANCE = 0.025
"""How often chance alone may call a part of the model better."""


@dataclass(frozen=True)
class Gain:
    """Rise of the held-out log likelihood. t: over what the spread between stretches explains; limit: Student's at CHANCE."""

    total: float
    error: float
    t: float
    limit: float

    @property
    def real(self) -> bool:
        """More than chance explains, and more than a parameter's own price."""
        return self.total > 1.0 and self.t > self.limit

    @property
    def weight(self) -> float:
        """Of the larger model against the smaller: logistic of the gain, softened by how sure the gain is (MacKay's probit rule)."""
        return 1 / (
            1 + math.exp(-max(min(self.total / math.sqrt(1 + math.pi / 8 * self.error**2), 50.0), -50.0))
        )


def spans_of(data: RollData) -> IntArray:
    """(n,) for each row the stretch it belongs to, -1 where it is not compared with the model: equal shares of the motion's energy.

    Empty of meaning (all in one) where the motion is too short for FEWEST of them.
    """
    taken = data.taken[0]
    span = np.full(data.size, -1)
    if len(taken) == 0:
        return span
    accel = data.accel[taken] - np.mean(data.accel[taken])
    energy = np.cumsum(accel * accel)
    count = int(len(taken) * data.every * data.step_s / SPAN_S)
    count = min(count, MOST) if count >= FEWEST else 1
    span[taken] = np.minimum((energy / max(float(energy[-1]), 1e-300) * count).astype(np.int64), count - 1)
    return span


def gain_of(larger: FloatArray, smaller: FloatArray) -> Gain:
    """Of two models' held-out log likelihoods by stretch (k,): paired, so that what all models miss drops out."""
    apart = larger - smaller
    count = len(apart)
    error = float(np.std(apart, ddof=1)) * math.sqrt(count) if count > 1 else math.inf
    total = float(apart.sum())
    t = total / error if error > 1e-12 else (0.0 if abs(total) < 1e-9 else math.copysign(math.inf, total))
    return Gain(total, error, t, float(stdtrit(max(count - 1, 1), 1 - CHANCE)))


def held_out(problem: Problem, x: FloatArray, weights: dict[str, float], spans: IntArray) -> FloatArray:
    """(k,) log likelihood of each stretch with the motion's parameters fitted to all the others.

    x: fitted to all of them; what a stretch taught is taken back by one scoring step from there, and the model is run
    anew. weights: the noises' levels, the same for every model that is compared: a model must explain and not re-weigh.
    """
    slopes = problem.of_motion(x, weights)
    scores = slopes.scores()
    flat = slopes.slope
    block = problem.motion
    prior = problem.weight[block]
    total = scores.sum(axis=0) - prior * (x - problem.mean)[block]
    curvature = slopes.information() + np.diag(prior)
    guard = max(1, round(GUARD_S / problem.data.step_s))
    scored = spans >= 0
    share = 1.0 / max(int(scored.sum()), 1)
    found = np.zeros(int(spans.max()) + 1)
    for k in range(len(found)):
        own = spans == k
        near = own.copy()
        for row in np.flatnonzero(own[:-1] & ~own[1:]):
            near[row : row + guard + 1] = True
        piece = flat[:, near].reshape(len(block), -1)
        matrix = curvature - piece @ piece.T
        scale = np.sqrt(np.diag(curvature))
        step = (
            np.linalg.solve(
                matrix / np.outer(scale, scale) + 1e-9 * np.eye(len(block)),
                (total - scores[near].sum(axis=0)) / scale,
            )
            / scale
        )
        moved = x.copy()
        moved[block] += step
        moved = np.clip(moved, problem.low, problem.high)
        with np.errstate(over="ignore", invalid="ignore"):
            error, variance = problem.innovations(moved, weights)
            carried = float(problem.carried([moved], weights)[0])
            here = float(np.nansum(huber(error[own] ** 2 / variance[own])))
            found[k] = 0.5 * carried * share * int(own.sum()) - here
            # what runs away answers noise without end, which is no gain
            stands = problem.stands(error, variance) and carried < RAN_OFF * problem.rows
        if not (stands and math.isfinite(found[k])):
            found[k] = RAN_AWAY
    return found
