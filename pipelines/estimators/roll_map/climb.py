"""How the roll fit finds its optimum: damped scoring of the motion's parameters and of the noises' levels, in turn.

A log of ordinary driving tells the first moments of the answer to a push well (its size 1/a, its mean lateness b/a + delay, the square
of that), and hardly how the lateness divides into damping and delay. In a, b, c and the delay that is a bent valley along which steps of
scoring go astray (on half an hour of public road 53 of them, to an end at b's bound from which the next turn began to come back); in the
moments it is straight.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pipelines.estimators.roll_map.likelihood import Problem, named
from pipelines.results import FloatArray

SETTLED, TURNED = 0.01, 0.05
MOST_TURNS = 8
MOST_TRIALS = 12
FREE_DELAY_S = 1e-3
"""Spread of the delay beforehand, up to which it counts as given."""

LEAST_PART, MOST_PART, NEAR_WHOLE = 0.1, 3.0, 0.25
"""Of a step: how short and long it may get along its line, and how near to a whole one it is not tried again."""


REMEMBERED = 6
"""Steps whose curvature is remembered."""

LEAST_BEND, MOST_BEND = 0.02, 1e3
"""How much less and more curvature than was expected is believed of a step."""


class Straight:
    """Coordinates u of a block's parameters x: in place of the delay τ and of c the moments T = β + τ and S = β² + β τ + τ²/2 - c/a, β = b/a.

    The answer e^(-τ s) a/(a + b s + c s²) of the roll angle, times a, is 1 - T s + S s²: with T and S held, b moves nothing up to the
    second order. Where one of the four is not in the block, u is x.
    """

    def __init__(self, names: list[str]) -> None:
        """names: of the block's parameters, in order."""
        four = ("a", "b", "c", "delay")
        self.places = [names.index(name) for name in four] if set(four) <= set(names) else []

    def at(self, x: FloatArray) -> FloatArray:
        """(k,) u of a point."""
        found = np.array(x)
        if self.places:
            ic, it = self.places[2:]
            a, b, c, delay = x[self.places]
            share = b / a
            found[it], found[ic] = share + delay, share**2 + share * delay + 0.5 * delay**2 - c / a
        return found

    def slopes(self, x: FloatArray) -> FloatArray:
        """(k, k) dx/du."""
        found = np.eye(len(x))
        if not self.places:
            return found
        ia, ib, ic, it = self.places
        a, b, c, delay = x[self.places]
        share = b / a
        found[it, ia], found[it, ib] = share / a, -1 / a
        found[ic, [ia, ib, it, ic]] = c / a - share**2, share, a * (share + delay), -a
        return found

    def moved(self, x: FloatArray, step: FloatArray) -> FloatArray:
        """x after a step (k,) in u."""
        found = np.asarray(x + step)
        if not self.places:
            return found
        ia, ib, ic, it = self.places
        a, b, c, delay = x[self.places]
        late = delay + b / a + step[it]
        second = (b / a) ** 2 + b / a * delay + 0.5 * delay**2 - c / a + step[ic]
        share = found[ib] / found[ia]
        delay = found[it] = late - share
        found[ic] = found[ia] * (share**2 + share * delay + 0.5 * delay**2 - second)
        return found


def bounded_step(
    curvature: FloatArray, gradient: FloatArray, low: FloatArray, high: FloatArray, damping: float
) -> FloatArray:
    """(k,) the damped step of scoring with each part of it between `low` and `high`: what would leave goes to its bound, and the others
    take what that leaves them."""
    scale = np.sqrt(np.diag(curvature))
    matrix = curvature / np.outer(scale, scale) + damping * np.eye(len(scale))
    first, least, most = gradient / scale, low * scale, high * scale
    step = np.zeros_like(first)
    free = np.ones(len(first), dtype=bool)
    while free.any():
        rest = first[free] - matrix[np.ix_(free, ~free)] @ step[~free]
        step[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest)
        beyond = free & ((step < least) | (step > most))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, least, most)[beyond]
        free &= ~beyond
    return np.asarray(step / scale)


def bent_by(curvature: FloatArray, seen: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """(k, k) a curvature that agrees with what the last steps saw, each (k,) the step and by how much the gradient fell along it (Broyden,
    Fletcher, Goldfarb, Shanno).

    Expected information takes the input's noise for motion that teaches, and knows nothing of how levels share one residual: scoring by
    it alone gained a third of the rest a step, or swung to and fro.
    """
    found = curvature
    for step, fallen in seen:
        expected = found @ step
        whole, bent = float(step @ expected), float(step @ fallen)
        # beside a bound, or where it bends the other way, a step says nothing that could be built upon
        if whole > 0 and LEAST_BEND * whole < bent < MOST_BEND * whole:
            found = (
                found - np.outer(expected, expected) / whole + np.outer(fallen, fallen) / float(step @ fallen)
            )
    return np.asarray(found)


class _Block:
    """One block of a problem at one point: the step of scoring in straight coordinates, and how far to go along it.

    weights: see `Problem.cost`; None for the levels' block.
    """

    def __init__(self, problem: Problem, weights: Mapping[str, float] | None) -> None:
        self._problem, self._weights = problem, weights
        self._block = problem.levels if weights is None else problem.motion
        known = [problem.known[i] for i in self._block.tolist()]
        # beside a delay that is as good as given there is no valley, and its moment would be all prior
        free = any(k.name == "delay" and k.std > FREE_DELAY_S for k in known)
        self._straight = Straight([k.name for k in known] if free else [])
        self._low, self._high = problem.low[self._block], problem.high[self._block]
        # the moments have no bounds of their own: the delay's and c's cut afterwards
        self._boxed = ~np.isin(np.arange(len(self._block)), self._straight.places[2:])

    def cost(self, x: FloatArray) -> float:
        """Of a point."""
        return self._problem.cost(x, self._weights)

    def slopes(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(k, k) curvature and (k,) gradient uphill, in straight coordinates."""
        problem, block = self._problem, self._block
        slopes = problem.of_levels(x) if self._weights is None else problem.of_motion(x, self._weights)
        turn = self._straight.slopes(x[block])
        pull = problem.weight[block] * (x - problem.mean)[block]
        return (
            np.asarray(turn.T @ (slopes.information() + np.diag(problem.weight[block])) @ turn),
            np.asarray(turn.T @ (slopes.scores().sum(axis=0) - pull)),
        )

    def at(self, x: FloatArray) -> FloatArray:
        """(k,) straight coordinates of a point."""
        return self._straight.at(x[self._block])

    def step(self, x: FloatArray, curvature: FloatArray, gradient: FloatArray, damping: float) -> FloatArray:
        """(k,) damped, as far as the bounds let it."""
        low = np.where(self._boxed, self._low - x[self._block], -np.inf)
        high = np.where(self._boxed, self._high - x[self._block], np.inf)
        return bounded_step(curvature, gradient, low, high, damping)

    def moved(self, x: FloatArray, step: FloatArray) -> FloatArray:
        """The point after a step."""
        found = x.copy()
        found[self._block] = np.clip(self._straight.moved(x[self._block], step), self._low, self._high)
        return found

    def along(
        self, x: FloatArray, cost: float, step: FloatArray, slope: float
    ) -> tuple[FloatArray, float, float]:
        """The better of a whole step and of the one to the foot of the parabola through it: point, cost, and the part gone.

        slope: of the cost at x along the step. What the input's noise adds to the squares bends the cost, and expected information knows
        nothing of it: whole steps swung to and fro about the end.
        """
        whole = self.moved(x, step)
        there = self.cost(whole)
        bend = there - cost - slope
        if not math.isfinite(there) or not slope < 0 or bend <= 0:
            return whole, there, 1.0
        part = min(max(-slope / (2 * bend), LEAST_PART), MOST_PART)
        if abs(part - 1) < NEAR_WHOLE:
            return whole, there, 1.0
        other = self.moved(x, part * step)
        cheaper = self.cost(other)
        return (other, cheaper, part) if cheaper < there else (whole, there, 1.0)


def _climb(
    problem: Problem, x: FloatArray, weights: Mapping[str, float] | None, most: int
) -> tuple[FloatArray, float, int]:
    """Damped scoring of the motion (with weights) or the levels from x: the point, what was gained, and the steps."""
    block = _Block(problem, weights)
    cost = first = block.cost(x)
    damping = 1e-3
    count = 0
    seen: list[tuple[FloatArray, FloatArray]] = []
    last: tuple[FloatArray, FloatArray] | None = None
    for count in range(1, most + 1):  # noqa: B007
        curvature, gradient = block.slopes(x)
        if not (np.isfinite(curvature).all() and np.isfinite(gradient).all()):
            break
        here = block.at(x)
        if last is not None:
            seen = [*seen, (here - last[0], last[1] - gradient)][-REMEMBERED:]
        last = here, gradient
        if weights is not None:
            curvature = bent_by(curvature, seen)
        gained = 0.0
        for _ in range(MOST_TRIALS):
            step = block.step(x, curvature, gradient, damping)
            trial, trial_cost, _ = block.along(x, cost, step, -float(gradient @ step))
            if trial_cost < cost:
                gained = cost - trial_cost
                x, cost = trial, trial_cost
                damping = max(damping / 8, 1e-9)
                break
            damping = max(damping, 1e-6) * 8
        if gained < SETTLED:
            break
    return x, first - cost, count


def level(problem: Problem, x: FloatArray, most: int) -> tuple[FloatArray, float, int]:
    """The noises' levels from x, with the motion held: the point, what was gained, and the steps."""
    return _climb(problem, x, None, most)


def settle(problem: Problem, x: FloatArray, weights: Mapping[str, float], most: int) -> FloatArray:
    """The motion's parameters from x, with the levels held at `weights`."""
    return _climb(problem, x, weights, most)[0]


def climb(
    problem: Problem, x: FloatArray, most: int, turns: int = MOST_TURNS
) -> tuple[FloatArray, int, bool]:
    """The blocks in turn until neither gains anything. Returns the point, the scoring steps and whether it settled."""
    steps = 0
    for _ in range(turns):
        x, motion, taken = _climb(problem, x, named(problem.known, x), most)
        x, levels, more = _climb(problem, x, None, most)
        steps += taken + more
        if motion < TURNED and levels < TURNED:
            return x, steps, True
    return x, steps, False
