"""The whole record at once: maximum a posteriori by Gauss-Newton, with the gPC filter itself as the solver.

A filter linearises where it happens to be while it learns; what it took for information then stays in its covariance, and in
a direction that the record does not show (one sine: m and k along k - m w²) its interval becomes far too narrow. Here the
problem is linearised about its own answer (`gpc_shrunk`), and it is looked at how that would differ nearby.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipelines.chaos.bases import hermite
from pipelines.chaos.collocation import hammersley
from pipelines.filters.gpc_convergence import LITTLE, MUCH, block_inflation
from pipelines.filters.gpc_filter import GpcSettings, StateSpaceModel, Uncertain
from pipelines.filters.gpc_shrunk import Problem, constant_rows, problem_of, step_from
from pipelines.filters.gpc_update import SQUARE_ROOT
from pipelines.results import FloatArray, Identification

ITERATIONS = 15
HALVINGS = 8
DRAWS = 8
CLEAR = 0.05
"""A posterior narrower than this share of the prior in every direction is taken as it is."""

TOO_LARGE = 1.1
"""A residual this many times the noise told says that the model leaves something out."""

SETTLED = 1e-3
"""A step below this share of a deviation in every direction ends the iteration."""

STUCK = 0.02
"""The same where no part of a step betters the fit: slopes by expansion are not exact, and a fiftieth is of no account."""


@dataclass(frozen=True)
class BatchEstimate:
    """The posterior's mode and covariance, of states at the start and parameters.

    mean (n,), covariance (n, n): of logarithms where `logarithm`. prior_mean, prior_std: (n,). residual: (rows, m), measured
    less the model at the mode; noise_ratio: its RMS over the noise told, (m,). converged: whether the last step was small.
    inflation: (n,), by how much residuals that hang together widen each deviation, 1 or more. allowance: (n,), a deviation for
    what the model leaves out: the change that alone would move the outputs as much as the smooth part of the residual is.
    """

    names: tuple[str, ...]
    logarithm: tuple[bool, ...]
    mean: FloatArray
    covariance: FloatArray
    prior_mean: FloatArray
    prior_std: FloatArray
    inflation: FloatArray
    allowance: FloatArray
    residual: FloatArray
    noise_ratio: FloatArray
    converged: bool

    def value(self, name: str) -> float:
        """The mode (of a logarithm: its exponential)."""
        i = self.names.index(name)
        return float(np.exp(self.mean[i])) if self.logarithm[i] else float(self.mean[i])

    def std(self, name: str) -> float:
        """The widened standard deviation, of the logarithm where there is one."""
        i = self.names.index(name)
        return float(np.hypot(np.sqrt(self.covariance[i, i]) * self.inflation[i], self.allowance[i]))

    def interval(self, name: str, widths: float = 1.96) -> tuple[float, float]:
        """The value's interval, widened; where the record taught little, no part of the prior's is left out."""
        i, half = self.names.index(name), widths * self.std(name)
        low, high = float(self.mean[i] - half), float(self.mean[i] + half)
        if self.left(name) > LITTLE:
            reach = widths * float(self.prior_std[i])
            low, high = (
                min(low, float(self.prior_mean[i]) - reach),
                max(high, float(self.prior_mean[i]) + reach),
            )
        return (float(np.exp(low)), float(np.exp(high))) if self.logarithm[i] else (low, high)

    def judge(self, name: str) -> tuple[Identification, str]:
        """Whether a parameter is known from this record, and why not, in words."""
        left = self.left(name)
        if self.prior_std[self.names.index(name)] == 0:
            return "identified", "it was given, not estimated"
        worst = float(np.max(self.noise_ratio))
        if left > MUCH:
            return (
                "not_identifiable",
                f"the record does not show it: {left:.0%} of what was unknown before still is",
            )
        if left > LITTLE:
            return (
                "weak",
                f"the excitation shows little of it: {left:.0%} of what was unknown before still is",
            )
        if worst > TOO_LARGE:
            return (
                "weak",
                f"the residual is {worst:.2g} times the noise told: the model does not explain the record",
            )
        if not self.converged:
            return "weak", "the search for the best fit did not come to rest"
        return "identified", "the record narrowed it, and the model explains the record"

    def left(self, name: str) -> float:
        """What is left of the prior's spread, before widening; 1: the record taught nothing."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]) / self.prior_std[i]) if self.prior_std[i] > 0 else 0.0


def _allowance(problem: Problem, covariance: FloatArray, residual: FloatArray) -> FloatArray:
    """What a model that leaves something out may have moved each parameter by, (n,).

    White noise has no covariance between neighbouring samples; what the model leaves out is smooth and has. Counted only where
    it is beyond chance (3 deviations).
    """
    known = problem.std > 0
    out = np.zeros(len(known))
    information = np.diag(np.linalg.inv(covariance[np.ix_(known, known)])) - problem.std[known] ** -2
    smooth = 0.0
    for j, variance in enumerate(problem.settings.noise):
        product = residual[1:, j] * residual[:-1, j]
        count = int(np.isfinite(product).sum())
        if count:
            white = float(np.nanmean(residual[:, j] ** 2))
            beyond = float(np.nanmean(product)) - 3.0 * white / np.sqrt(count)
            smooth += count * max(0.0, beyond) / variance
    out[known] = np.sqrt(smooth / np.maximum(information, problem.std[known] ** -2))
    return out


def _widest(problem: Problem, at: FloatArray, covariance: FloatArray) -> FloatArray:
    """The covariance, each row and column widened to the widest found at points that the posterior holds for likely.

    Where a record shows little, what it seems to show may come from states fitted to noise (a free vibration that is not there
    has a frequency too), and is gone a deviation away; so may be the mode itself: where a step from there ends counts as well.
    Where all is narrow, there is nothing to look for. Never wider than the prior.
    """
    known = problem.std > 0
    deviation = np.sqrt(np.diag(covariance))
    if not known.any() or np.max(deviation[known] / problem.std[known]) < CLEAR:
        return covariance
    root = np.linalg.cholesky(covariance[np.ix_(known, known)] + np.diag(1e-12 * problem.std[known] ** 2))
    widest, wander = deviation.copy(), np.zeros(len(at))
    for draw in np.asarray(hermite().quantile(hammersley(DRAWS, int(known.sum())))):
        other = at.copy()
        other[known] += root @ draw
        residual = problem.residual(other)
        if np.isfinite(problem.cost(other, residual)):
            step, there, _ = step_from(problem, other, residual)
            widest = np.maximum(widest, np.sqrt(np.diag(there)))
            wander = np.maximum(wander, np.minimum(np.abs(other + step - at), problem.std))
    widest = np.minimum(np.hypot(widest, wander), np.maximum(problem.std, deviation))
    scale = np.where(deviation > 0, widest / np.where(deviation > 0, deviation, 1.0), 1.0)
    return np.asarray(covariance * scale[:, None] * scale[None, :])


def _search(
    problem: Problem, at: FloatArray, residual: FloatArray, cost: float
) -> tuple[FloatArray, FloatArray, bool]:
    """Gauss-Newton with halved steps from `at`: the mode, its residual, and whether the search came to rest."""
    known = problem.std > 0
    for _ in range(ITERATIONS):
        step, covariance, _ = step_from(problem, at, residual)
        deviation = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        if np.all(np.abs(step[known]) < SETTLED * deviation[known]):
            return at, residual, True
        share = 1.0
        for _ in range(HALVINGS):
            other = problem.residual(at + share * step)
            less = problem.cost(at + share * step, other)
            if less < cost:
                break
            share *= 0.5
        else:
            return at, residual, bool(np.all(np.abs(step[known]) < STUCK * deviation[known]))
        at, residual, cost = at + share * step, other, less
    return at, residual, False


def _begin(problem: Problem, start: FloatArray | None) -> tuple[FloatArray, FloatArray, float]:
    """Where the search starts, with its residual and cost."""
    places = [problem.mean if start is None else np.where(problem.std > 0, start, problem.mean)]
    if start is None:
        how = replace(
            problem.settings,
            order=max(2, problem.settings.order),
            form=SQUARE_ROOT,
            state_addition=0.0,
            keep_every=0,
        )
        filtered = problem.run(problem.variables(problem.mean, problem.std), problem.measured, how)
        if not filtered.diverged:
            places.append(np.where(problem.std > 0, filtered.mean[-1][constant_rows(problem)], problem.mean))
    found = []
    for place in places:
        residual = problem.residual(place)
        found.append((problem.cost(place, residual), place, residual))
    cost, at, residual = min(found, key=lambda one: one[0])
    if not np.isfinite(cost):
        raise ValueError("the model gives no finite numbers where the estimate is to start")
    return at, residual, cost


def estimate_batch(
    model: StateSpaceModel,
    inputs: FloatArray,
    measured: FloatArray,
    step_s: float,
    states: tuple[Uncertain, ...],
    parameters: tuple[Uncertain, ...],
    settings: GpcSettings,
    *,
    outputs: tuple[str, ...] = ("position",),
    start: FloatArray | None = None,
) -> BatchEstimate:
    """The posterior's mode over the whole record, and its covariance there.

    Arguments as `estimate_state_space`; only noise counts of `settings`. Priors are taken as normal with the mean and deviation
    of each Uncertain. start: (n,) where to begin, states at the start and parameters as kept (logarithms stay logarithms);
    None: at the prior's mean. Raises what `estimate_state_space` does, and ValueError where an output was never measured or
    the model gives no finite numbers at the start.
    """
    problem = problem_of(model, inputs, measured, step_s, (*states, *parameters), settings, outputs)
    if not np.isfinite(measured).any(axis=0).all():
        raise ValueError("an output has no measured value at all; leave it out")
    at, residual, cost = _begin(problem, start)
    at, residual, converged = _search(problem, at, residual, cost)
    _, covariance, run = step_from(problem, at, residual)
    allowance = _allowance(problem, covariance, residual)
    covariance = _widest(problem, at, covariance)
    names = (*(f"first {name}" for name in model.states), *model.parameters)
    logs = tuple(one.logarithm for one in problem.prior)
    inflation = np.array(
        [block_inflation(run, name) if s > 0 else 1.0 for name, s in zip(names, problem.std, strict=True)]
    )
    ratio = np.sqrt(np.nanmean(residual**2, axis=0) / np.array(settings.noise))
    return BatchEstimate(
        names,
        logs,
        at,
        covariance,
        problem.mean,
        problem.std,
        inflation,
        allowance,
        residual,
        ratio,
        converged,
    )
