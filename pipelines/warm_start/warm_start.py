"""Algorithm 1 of Berntorp et al.: optimise, take the density of what was tried, and start the particles from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray
from pipelines.warm_start.density import Box, Density, Weighting
from pipelines.warm_start.expected_improvement import best_candidate
from pipelines.warm_start.gaussian_process import Hyper, condition, fit
from pipelines.warm_start.weighting import history_density, tempered_density

__all__ = [
    "PUBLISHED",
    "TEMPERED",
    "Box",
    "Cost",
    "History",
    "WarmStart",
    "WarmStartSettings",
    "drawn_particles",
    "grid_particles",
    "minimise",
    "warm_start",
]

Cost = Callable[[FloatArray], float]
"""From a point (d,) of the box to its cost. Not finite: an impossible point."""

Features = Callable[[FloatArray], FloatArray]
"""From points (n, d) to what the surrogate sees of them (n, f): coordinates along which the cost has no narrow askew valley."""


@dataclass(frozen=True)
class History:
    """All that was tried, in order. points: (t, d). costs: (t,). box: where it was looked for."""

    points: FloatArray
    costs: FloatArray
    box: Box

    @property
    def best(self) -> FloatArray:
        """(d,) the point of the lowest cost."""
        at = int(np.argmin(np.where(np.isfinite(self.costs), self.costs, np.inf)))
        return np.asarray(self.points[at])


@dataclass(frozen=True)
class WarmStartSettings:
    """iterations: N_BO after the first points. first: points drawn before the first Gaussian process (1 as published).

    candidates: points at which the expected improvement is searched. matern: Matérn 5/2 instead of the squared
    exponential. logarithm: the process is of log J (J > 0), whose basin is rounder. refit_every: iterations between fits of
    the hyperparameters. weighting: see `weighting`. exact: "tempered" weighs its draws by the cost itself instead of the
    surrogate (about 10 000 more evaluations: for a cheap cost). confidence: β. values: per dimension (20 as published).
    """

    iterations: int = 100
    first: int = 1
    candidates: int = 1000
    matern: bool = False
    logarithm: bool = False
    refit_every: int = 5
    weighting: Weighting = "published"
    exact: bool = False
    confidence: float = 0.95
    values: int = 20


PUBLISHED = WarmStartSettings()
TEMPERED = WarmStartSettings(
    first=10, iterations=60, matern=True, logarithm=True, weighting="tempered", exact=True
)


@dataclass(frozen=True)
class WarmStart:
    """What Algorithm 1 gives. inside: the β-confidence box. kept: its volume's share of the whole box."""

    history: History
    density: Density
    inside: Box

    @property
    def kept(self) -> float:
        """Share of the whole box's volume."""
        return float(np.prod(self.inside.span / self.history.box.span))


def _values(costs: FloatArray, logarithm: bool) -> FloatArray:
    """What the process is of: costs or their logarithms; what is not finite counts as the worst that is."""
    good = np.isfinite(costs)
    values = np.where(good, costs, costs[good].max() if good.any() else 1.0)
    return np.log(np.maximum(values, 1e-300)) if logarithm else values


class _Surrogate:
    """The process over the box scaled to 0..1, seen through the features scaled to about 0..1."""

    def __init__(
        self, box: Box, features: Features | None, settings: WarmStartSettings, rng: np.random.Generator
    ):
        self._box, self._features = box, features
        corners = self._seen(rng.random((1000, len(box.low))), np.zeros(1), np.ones(1))
        self._low, self._span = corners.min(axis=0), np.ptp(corners, axis=0)
        self._hyper = Hyper(np.full(len(self._low), 0.5), 1e-4, settings.matern)
        self._settings, self._rng = settings, rng

    def _seen(self, unit: FloatArray, low: FloatArray, span: FloatArray) -> FloatArray:
        points = unit if self._features is None else self._features(self._box.low + unit * self._box.span)
        return (points - low) / span

    def learn(self, unit: FloatArray, values: FloatArray, tries: int | None) -> None:
        """Condition on values (n,) at unit (n, d). tries: of the search for hyperparameters; None: they stay."""
        seen = self._seen(unit, self._low, self._span)
        if tries is None:
            self._process = condition(seen, values, self._hyper)
        else:
            self._process = fit(seen, values, self._hyper, tries, self._rng)
        self._hyper = self._process.hyper

    def predict(self, unit: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As the process does."""
        return self._process.predict(self._seen(unit, self._low, self._span))

    def means(self, unit: FloatArray) -> FloatArray:
        """As the process does."""
        return self._process.means(self._seen(unit, self._low, self._span))


def minimise(
    cost: Cost,
    box: Box,
    start: FloatArray | None,
    settings: WarmStartSettings,
    rng: np.random.Generator,
    *,
    features: Features | None = None,
) -> History:
    """Lines 1-7: Bayesian optimisation. start: (d,) θ_0 (None: drawn). Raises ValueError where start is outside the box."""
    d, first = len(box.low), settings.first
    if settings.iterations < 0 or first < 1:
        raise ValueError("there is at least one first point, and iterations are not negative")
    unit = (np.argsort(rng.random((first, d)), axis=0) + rng.random((first, d))) / first
    if start is not None:
        if not box.holds(start[None])[0]:
            raise ValueError("the first guess lies outside the box")
        unit[0] = (start - box.low) / box.span
    costs = np.array([cost(box.low + point * box.span) for point in unit])
    surrogate = _Surrogate(box, features, settings, rng)
    for t in range(settings.iterations):
        values = _values(costs, settings.logarithm)
        surrogate.learn(unit, values, 1 if t % settings.refit_every == 0 else None)
        at = int(np.argmin(values))
        point = best_candidate(surrogate, float(values[at]), unit[at], settings.candidates, rng)
        unit = np.vstack((unit, point))
        costs = np.append(costs, cost(box.low + point * box.span))
    return History(box.low + unit * box.span, costs, box)


class NothingFitsError(ValueError):
    """No point of the box has a finite cost: the model runs away, or is not one, wherever it is tried."""


def warm_start(
    cost: Cost,
    box: Box,
    start: FloatArray | None,
    settings: WarmStartSettings,
    rng: np.random.Generator,
    *,
    features: Features | None = None,
    power: Callable[[FloatArray], float] | None = None,
) -> WarmStart:
    """Algorithm 1. features: for the surrogate. power: γ of "tempered" from the best point, e.g. `RollError.independent`.

    Raises NothingFitsError where no point tried has a finite cost, ValueError where "tempered" is not given its power.
    """
    history = minimise(cost, box, start, settings, rng, features=features)
    if not np.isfinite(history.costs).any():
        raise NothingFitsError("no point tried has a finite cost")
    if settings.weighting != "tempered":
        density = history_density(history.points, history.costs, box, settings.weighting)
    else:
        if power is None:
            raise ValueError("a tempered density needs its power: how many independent residuals there are")
        surrogate = _Surrogate(box, features, settings, rng)
        surrogate.learn((history.points - box.low) / box.span, _values(history.costs, True), 2)
        exact = cost if settings.exact else None
        density = tempered_density(surrogate.means, box, power(history.best), exact, rng)
    return WarmStart(history, density, density.confidence_box(settings.confidence))


def grid_particles(started: WarmStart, values: int, rng: np.random.Generator) -> FloatArray:
    """As published: `values` draws a dimension by its own density within the box, all combinations: (values**d, d)."""
    d = len(started.inside.low)
    axes = [started.density.draw_dimension(j, values, started.inside, rng) for j in range(d)]
    return np.column_stack([part.ravel() for part in np.meshgrid(*axes, indexing="ij")])


def drawn_particles(
    started: WarmStart, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Draws (count, d) from the joint density, and the weights (count,) that make them uniform over Θ again.

    With these weights the warm start only says where to look: a drive that was used for it and is then filtered is not
    counted twice. Without them (weights alike) the density is the prior, as published: for archival data of another drive.
    """
    points = started.density.draw(count, rng)
    logs = -started.density.log_density(points)
    weights = np.exp(logs - logs.max())
    return points, weights / weights.sum()
