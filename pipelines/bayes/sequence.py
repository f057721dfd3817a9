"""Sequential intervals: the posterior of one is the prior of the next (3.3), with a domain that follows the posterior.

Over a fixed domain a posterior soon fills so little of it that a polynomial of any order is useless there. So the domain is laid
anew about the posterior once this fills less than half of it, and wider where the MAP meets its edge; the data so far are
then collocated again, which costs a few runs over all of them and loses nothing: what the intervals say together is what
all of the data at once would say.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipelines.bayes.posterior import DRAWS, FEW_DRAWS, Posterior, posterior
from pipelines.bayes.priors import Priors
from pipelines.bayes.surrogate import (
    HOLD_OUT,
    Domain,
    Residuals,
    box,
    collocation_for,
    gram_of,
    hold_out_error,
    surrogate,
)
from pipelines.results import FloatArray


@dataclass(frozen=True)
class Choice:
    """order: of the expansion over the prior's support; near_order: over a domain laid about a posterior. factor: points a term.
    reach: half the domain's width in posterior standard deviations. follow: False keeps the prior's support throughout,
    as published. good_error: of the log likelihood at hold-out points."""

    order: int = 4
    near_order: int = 3
    factor: float = 3.0
    reach: float = 4.5
    follow: bool = True
    good_error: float = 0.1
    most_refits: int = 8


@dataclass(frozen=True)
class Step:
    """The posterior after an interval: MAP, mean, standard deviation and 95 % interval, each (d,)."""

    interval: int
    map_value: FloatArray
    mean: FloatArray
    std: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class Found:
    """The end of a sequence. steps: after each interval. refits: domains laid. runs: model runs over one interval each.
    error: of the log likelihood at hold-out points. at_edge: parameters whose MAP lies on the bound of their prior."""

    posterior: Posterior
    steps: tuple[Step, ...]
    refits: int
    runs: int
    error: float
    at_edge: tuple[str, ...]


QUANTILES = np.array([0.025, 0.975])
FULL, LEAST_FULL = 0.5, 0.3
EDGE = 0.97
WIDER = 1.6
MOST_BLUR = 3.0
ON_THE_WAY, MOST_CHECKED = 0.5, 3
"""A posterior that fills less than LEAST_FULL of its domain in every direction moves it; where the surrogate is not exact enough
and the posterior fills FULL of it, a higher order is taken; a MAP beyond EDGE of the domain widens it, by WIDER; an inexact
surrogate's posterior is taken up to MOST_BLUR times as wide. Before the last interval an error of ON_THE_WAY will do, told by
MOST_CHECKED intervals."""


class _Walk:
    """The state of a sequence: the domain, and the misfit's matrix of the intervals so far."""

    def __init__(
        self,
        priors: Priors,
        residuals: Residuals,
        choice: Choice,
        rng: np.random.Generator,
        start: Domain | None,
    ):
        self.priors, self.residuals, self.choice, self.rng = priors, residuals, choice, rng
        self._take_order(choice.order if start is None else choice.near_order)
        self.domain = box(*priors.box()) if start is None else start
        self.laid_anew = start is not None
        self.grams: dict[int, FloatArray] = {}
        self.seen: list[int] = []
        self.refits = self.runs = 0

    def add(self, interval: int) -> None:
        """Take in an interval's data."""
        self.seen.append(interval)
        self.grams[interval] = gram_of(self.residuals, interval, self.domain, self.collocation)
        self.runs += len(self.collocation.points)

    def posterior(self, draws: int) -> Posterior:
        """Of all intervals so far."""
        total = np.sum([self.grams[i] for i in self.seen], axis=0)
        return posterior(self.priors, surrogate(total, self.domain, self.collocation), draws)

    def lay(self, domain: Domain) -> None:
        """Move to another domain and collocate the data so far again."""
        self.domain = domain
        if not self.laid_anew:
            self.laid_anew = True
            self._take_order(self.choice.near_order)
        seen, self.seen = self.seen, []
        self.grams = {}
        for interval in seen:
            self.add(interval)
        self.refits += 1

    def sharpen(self) -> bool:
        """Take the next higher order for the domains to come; False where it is the highest already."""
        if self.order >= max(self.choice.order, self.choice.near_order):
            return False
        self._take_order(self.order + 1)
        return True

    def _take_order(self, order: int) -> None:
        self.order = order
        self.collocation = collocation_for(self.priors.dimensions, order, self.choice.factor, self.rng)

    def error(self, found: Posterior, most: int) -> float:
        """Of the log likelihood, at draws spread over the posterior; told by `most` of the intervals."""
        order = np.argsort(found.values[:, 0])
        places = np.searchsorted(np.cumsum(found.weights[order]), (np.arange(HOLD_OUT) + 0.5) / HOLD_OUT)
        xi = found.xi[order[np.minimum(places, len(order) - 1)]]
        some = self.seen
        if len(some) > most:
            some = [some[i] for i in np.linspace(0, len(some) - 1, most).astype(int)]
        self.runs += HOLD_OUT * len(some)
        part = surrogate(np.sum([self.grams[i] for i in some], axis=0), self.domain, self.collocation)
        # errors of intervals over one domain are of one kind: they add up
        return hold_out_error(part, self.residuals, some, xi) * len(self.seen) / len(some)


def _about(found: Posterior, priors: Priors, reach: float, blur: float) -> Domain:
    """A domain about a posterior: along its own axes, or the coordinates' where the model cannot be run there."""
    domain = found.surrogate.domain
    mean = found.weights @ found.xi
    spread = found.spread_in_domain() + 1e-12 * np.eye(len(mean))
    covariance = domain.axes @ spread @ domain.axes.T * blur**2
    centre = domain.out(mean[None])[0]
    low, high = priors.runs()
    half = reach * np.sqrt(np.diag(covariance))
    sizes, vectors = np.linalg.eigh(covariance)
    axes = reach * vectors * np.sqrt(np.maximum(sizes, 1e-14 * sizes[-1]))
    corner = np.abs(axes).sum(axis=1)
    if np.all(centre - corner > low) and np.all(centre + corner < high):
        return Domain(centre, axes)
    low, high = priors.hard()
    return box(np.maximum(centre - half, low), np.minimum(centre + half, high))


def _wider(found: Posterior, priors: Priors) -> Domain | None:
    """A domain further out where the MAP lies on its edge, None where it does not, or the edge is the prior's own bound."""
    domain = found.surrogate.domain
    outside = np.abs(found.map_xi) > EDGE
    if not outside.any():
        return None
    low, high = priors.hard()
    centre = domain.out(np.where(outside, found.map_xi, 0.0)[None])[0]
    half = np.abs(domain.axes) @ np.where(outside, WIDER, 1.2)
    below, above = np.maximum(centre - half, low), np.minimum(centre + half, high)
    here = np.abs(domain.axes).sum(axis=1)
    inside = (below >= domain.centre - here - 1e-12) & (above <= domain.centre + here + 1e-12)
    return None if inside.all() else box(below, above)


def _settle(walk: _Walk, last: bool) -> tuple[Posterior, float]:
    """The posterior of the data so far, with the domain moved until it suits; and the surrogate's error."""
    choice = walk.choice
    good_error = choice.good_error if last else max(choice.good_error, ON_THE_WAY)
    most, draws = (len(walk.seen), DRAWS) if last else (MOST_CHECKED, FEW_DRAWS)
    found = walk.posterior(draws)
    if not choice.follow:
        return found, float("nan")
    error = float("nan")
    for _ in range(choice.most_refits):
        wider = _wider(found, walk.priors)
        if wider is not None:
            walk.lay(wider)
            found = walk.posterior(draws)
            continue
        filled = float(np.max(choice.reach * np.sqrt(np.diag(found.spread_in_domain()))))
        error = walk.error(found, most)
        if error <= good_error and filled >= LEAST_FULL:
            return found, error
        if error > good_error and filled >= FULL and not walk.sharpen():
            # as close as the orders allow
            return found, error
        # an inexact surrogate's posterior may lie beside the true one: look a little further about
        blur = min(max(error, 1.0), MOST_BLUR)
        walk.lay(_about(found, walk.priors, choice.reach, blur))
        found = walk.posterior(draws)
    return found, walk.error(found, most)


def estimate(
    priors: Priors,
    residuals: Residuals,
    intervals: int,
    choice: Choice,
    rng: np.random.Generator,
    *,
    start: Domain | None = None,
    progress: Callable[[int], None] | None = None,
) -> Found:
    """Run through the intervals 0 .. intervals - 1. start: a domain to begin with in place of the prior's support.

    Raises ValueError for no interval, ExpansionError where the orders ask for too many terms, FloatingPointError where the
    model overflows within its priors.
    """
    if intervals < 1:
        raise ValueError("there is no interval")
    walk = _Walk(priors, residuals, choice, rng, start)
    steps: list[Step] = []
    found, error = None, float("nan")
    for interval in range(intervals):
        walk.add(interval)
        found, error = _settle(walk, interval + 1 == intervals)
        low, high = found.quantiles(QUANTILES)
        steps.append(Step(interval, found.map_value, found.mean, found.std, low, high))
        if progress is not None:
            progress(interval)
    assert found is not None
    return Found(found, tuple(steps), walk.refits, walk.runs, error, _edges(found, priors))


def domain_about(found: Posterior, priors: Priors, reach: float = 4.5, blur: float = 1.0) -> Domain:
    """The domain that suits a posterior: for another pass with other weights."""
    return _about(found, priors, reach, blur)


def _edges(found: Posterior, priors: Priors) -> tuple[str, ...]:
    low, high = priors.hard()
    place = priors.coordinates(found.map_value)
    spread = found.surrogate.domain.axes @ found.spread_in_domain() @ found.surrogate.domain.axes.T
    near = 0.05 * np.sqrt(np.diag(spread))
    return tuple(
        n for n, a, b, c in zip(priors.names, place - low, high - place, near, strict=True) if min(a, b) < c
    )
