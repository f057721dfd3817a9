"""A problem of states and constant parameters, shrunk about a point until it is linear, with the gPC filter as its solver.

    prior   p + SMALL (prior mean - p),  SMALL spread     data  y(p) + SMALL (z - y(p)),     R  SMALL² R

On that every model is linear: the square-root filter solves the linearised problem exactly, its mean is p plus SMALL times
the Gauss-Newton step, and its covariance SMALL² times that of the posterior at p.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipelines.chaos.bases import hermite
from pipelines.filters.gpc_filter import (
    GpcSettings,
    StateSpaceModel,
    StateSpaceRun,
    Uncertain,
    estimate_state_space,
)
from pipelines.filters.gpc_update import SQUARE_ROOT
from pipelines.results import FloatArray

SMALL = 1e-5
LARGEST = 300.0
"""Of a logarithm."""


def _plain(kept: float, logarithm: bool) -> float:
    """A value from how it is kept; a step too far stays within what a number can hold, and costs too much there."""
    return math.exp(min(max(kept, -LARGEST), LARGEST)) if logarithm else kept


@dataclass(frozen=True)
class Problem:
    """A record, a model and a prior. mean, std: (n,) of the prior as kept, states at the start, then parameters."""

    model: StateSpaceModel
    inputs: FloatArray
    measured: FloatArray
    step_s: float
    settings: GpcSettings
    outputs: tuple[str, ...]
    prior: tuple[Uncertain, ...]
    mean: FloatArray
    std: FloatArray

    def run(
        self, variables: tuple[Uncertain, ...], measured: FloatArray, settings: GpcSettings
    ) -> StateSpaceRun:
        """The filter with these uncertainties, on data (rows, m)."""
        count = len(self.model.states)
        return estimate_state_space(
            self.model,
            self.inputs,
            measured,
            self.step_s,
            variables[:count],
            variables[count:],
            settings,
            outputs=self.outputs,
            remember_start=True,
        )

    def variables(self, at: FloatArray, spread: FloatArray) -> tuple[Uncertain, ...]:
        """Uncertain about `at`, as kept (logarithms stay logarithms)."""
        return tuple(
            Uncertain(_plain(float(a), one.logarithm), float(s), hermite(), one.logarithm)
            for one, a, s in zip(self.prior, at, spread, strict=True)
        )

    def residual(self, at: FloatArray) -> FloatArray:
        """Measured less the model at `at`, (rows, m)."""
        quiet = self.run(
            self.variables(at, np.zeros(len(at))), self.measured, replace(self.settings, order=1, factor=1.0)
        )
        return quiet.innovation

    def cost(self, at: FloatArray, residual: FloatArray) -> float:
        """Twice the negative logarithm of the posterior at `at`, less a constant; inf where the model ran away."""
        known = self.std > 0
        total = np.sum(((at - self.mean)[known] / self.std[known]) ** 2)
        # a model that ran away has numbers too large for a square
        with np.errstate(over="ignore"):
            fit = np.nansum(residual**2 / np.array(self.settings.noise))
        seen = np.isfinite(self.measured)
        return float(total + fit) if np.isfinite(residual[seen]).all() and np.isfinite(fit) else np.inf

    def shrunk(self, at: FloatArray, residual: FloatArray) -> StateSpaceRun:
        """The filter on the problem shrunk about `at`."""
        middle = at + SMALL * (self.mean - at)
        settings = replace(
            self.settings, order=1, factor=2.0, form=SQUARE_ROOT, state_addition=0.0, keep_every=max(1, len(self.measured) - 1),
            noise=tuple(SMALL**2 * r for r in self.settings.noise),
        )  # fmt: skip
        data = self.measured - residual + SMALL * residual
        return self.run(self.variables(middle, SMALL * self.std), data, settings)


def problem_of(
    model: StateSpaceModel, inputs: FloatArray, measured: FloatArray, step_s: float, prior: tuple[Uncertain, ...],
    settings: GpcSettings, outputs: tuple[str, ...],
) -> Problem:  # fmt: skip
    """The problem with its priors taken as normal, of the mean and deviation that each distribution has."""
    mean, std = np.empty(len(prior)), np.empty(len(prior))
    for i, one in enumerate(prior):
        nodes, weights = one.basis.gauss(2)
        centre = float(weights @ nodes)
        mean[i] = one.centre + one.spread * centre
        std[i] = abs(one.spread) * np.sqrt(float(weights @ (nodes - centre) ** 2))
    return Problem(model, inputs, measured, step_s, settings, outputs, prior, mean, std)


def step_from(
    problem: Problem, at: FloatArray, residual: FloatArray
) -> tuple[FloatArray, FloatArray, StateSpaceRun]:
    """The Gauss-Newton step from `at`, the posterior's covariance there, and the run that gave them."""
    run = problem.shrunk(at, residual)
    rows = constant_rows(problem)
    mean = run.mean[run.done - 1][rows]
    spread = run.coefficients[-1][rows, 1:] / SMALL
    return (mean - at) / SMALL, spread @ spread.T, run


def constant_rows(problem: Problem) -> list[int]:
    """Rows of what is constant over a run, in the order of the problem: states at the start, then parameters."""
    states, parameters = len(problem.model.states), len(problem.model.parameters)
    return [*range(states + parameters, 2 * states + parameters), *range(states, states + parameters)]
