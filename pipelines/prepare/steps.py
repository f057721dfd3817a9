"""Steps in a series of levels: taken in one after the other, each where it explains most, and all fitted together.

    y_i = c + sum_j b_j x_ij + sum_k s_k [i >= k] + e_i

b are nuisances that are known beforehand within spreads, so that two levels tell a step as well as twenty, if less well. Somebody who
rides along for a part of a drive is two steps, of which neither explains much alone: fitted together by generalized least squares.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.results import FloatArray

SURE, SURE_ALONE = 5.0, 8.0
"""Standard deviations for a step, and for one with a single group before or behind it, which may be odd by itself."""
NEAR = 3
AT_ONCE = 0.4
"""Share of the step that the NEAR levels before and after it have to show."""
MOST_STEPS = 5
"""More are not looked for: a drive of so many loads is told as weakly with five as with ten."""


@dataclass(frozen=True)
class StepFit:
    """One step among others. first: index of its first level; begin, end: from and up to which level no other step comes.

    total, std: of the first column; parts: of each other one. left_in: (n,) residuals of the first with this step left in.
    """

    first: int
    begin: int
    end: int
    total: float
    std: float
    parts: FloatArray
    left_in: FloatArray


@dataclass(frozen=True)
class Levels:
    """What generalized least squares need. values: (n, 1 + k) what is looked at, and its parts; group: (n,) levels of one group share an
    error; slopes: (n, m) nuisances, each in its spread; once: (n,) the weights of a mean; seen: (n, n) the inverse of all covariances, for
    what has no mean; stuck: what a group scatters by; fitted: of how many figures a rule says that the levels tell them."""

    values: FloatArray
    group: NDArray[np.int64]
    slopes: FloatArray
    once: FloatArray
    seen: FloatArray
    stuck: float
    fitted: int

    def powers(self, steps: FloatArray, beside: FloatArray) -> FloatArray:
        """(m,) what each of the steps (n, m) explains beside those that are there (n, k), in chi²."""
        y = self.values[:, 0]
        power = np.einsum("ij,ij->j", steps, self.seen @ steps)
        pull = steps.T @ (self.seen @ y)
        if beside.shape[1]:
            across = steps.T @ self.seen @ beside
            inverse = np.linalg.inv(beside.T @ self.seen @ beside)
            power = power - np.einsum("ij,jk,ik->i", across, inverse, across)
            pull = pull - across @ inverse @ (beside.T @ self.seen @ y)
        # a step that is there already explains nothing more
        return np.where(power > 1e-9 * np.max(np.abs(power)), pull**2 / np.maximum(power, 1e-300), 0.0)

    def scatter(self, left: FloatArray, firsts: Sequence[int]) -> float:
        """Root mean square of what a fit leaves, (n,), group by group: one that a step cuts counts as two, figures fitted as none."""
        level = _ones_after(len(self.group), firsts).sum(axis=1).astype(np.int64)
        _, place = np.unique((len(firsts) + 1) * self.group + level, return_inverse=True)
        means = np.bincount(place, weights=left) / np.bincount(place)
        return math.sqrt(float(means @ means) / max(len(means) - self.fitted - len(firsts) + 1, 1))


def make_levels(
    values: FloatArray,
    group: NDArray[np.int64],
    own: FloatArray,
    slopes: FloatArray,
    stuck: float,
    fitted: int,
) -> Levels:
    """own: (n, n) covariance of the levels' errors, without the nuisances'; the rest as in `Levels`."""
    inverse = np.linalg.inv(own + slopes @ slopes.T)
    once = inverse.sum(axis=1)
    seen = inverse - np.outer(once, once) / once.sum()
    return Levels(values, group, slopes, once, seen, stuck, fitted)


def _ones_after(count: int, firsts: Sequence[int]) -> FloatArray:
    """(n, m) 0 before a step, 1 from it on."""
    return (np.arange(count)[:, None] >= np.asarray(firsts, dtype=np.int64)[None, :]).astype(np.float64)


def fit_steps(levels: Levels, firsts: Sequence[int]) -> tuple[StepFit, ...]:
    """Generalized least squares for steps before the levels `firsts`, in the order of time."""
    n, y = len(levels.values), levels.values[:, 0]
    steps = _ones_after(n, firsts)
    covariance = np.linalg.inv(steps.T @ levels.seen @ steps)
    found = covariance @ (steps.T @ levels.seen @ levels.values)
    without = y - levels.slopes @ (levels.slopes.T @ levels.seen @ (y - steps @ found[:, 0]))
    left = without - steps @ found[:, 0]
    left = left - float(levels.once @ left) / float(levels.once.sum())
    scale = max(1.0, levels.scatter(left, firsts) / levels.stuck)
    bounds = (0, *firsts, n)
    return tuple(
        StepFit(
            first, bounds[m], bounds[m + 2], float(found[m, 0]), scale * math.sqrt(float(covariance[m, m])), found[m, 1:],
            left + steps[:, m] * found[m, 0],
        )
        for m, first in enumerate(firsts)
    )  # fmt: skip


def _surely(levels: Levels, fit: StepFit, least: float) -> bool:
    """Whether the step is large, beyond doubt, and there at once."""
    before, after = levels.group[fit.begin : fit.first], levels.group[fit.first : fit.end]
    single = min(len(np.unique(before)), len(np.unique(after))) < 2
    if abs(fit.total) < max(least, (SURE_ALONE if single else SURE) * fit.std):
        return False
    seen = fit.left_in
    at_once = np.median(seen[fit.first : min(fit.first + NEAR, fit.end)]) - np.median(
        seen[max(fit.first - NEAR, fit.begin) : fit.first]
    )
    return bool(at_once * np.sign(fit.total) > AT_ONCE * abs(fit.total))


def steps_beyond_doubt(
    levels: Levels, least: float, plausible: Callable[[StepFit], bool]
) -> tuple[StepFit, ...]:
    """The most steps that are all beyond doubt, of `least` and more, and plausible; none where there are none."""
    n = len(levels.values)
    every, firsts = np.arange(1, n), list[int]()
    best: tuple[StepFit, ...] = ()
    for _ in range(min(MOST_STEPS, n - 1)):
        explained = levels.powers(_ones_after(n, every.tolist()), _ones_after(n, firsts))
        explained[np.isin(every, firsts)] = 0.0
        if not explained.max() > 0:
            break
        firsts = sorted([*firsts, int(every[int(np.argmax(explained))])])
        fits = fit_steps(levels, firsts)
        if all(_surely(levels, fit, least) and plausible(fit) for fit in fits):
            best = fits
    return best
