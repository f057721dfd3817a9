"""From the points that were tried to a density: as published, by cost, or by a tempered likelihood of the surrogate.

- published: each point tried counts alike. Bayesian optimisation tries points all over the box, so that most of it is kept.
- cost: each point by exp(-J / median spread above the lowest): shrinks, and can leave the truth outside, for it weighs
  points by where the search happened to go.
- tempered: the surrogate of log J gives a likelihood J^-γ anywhere in the box, drawn by importance sampling in rounds of
  growing γ. For n independent normal residuals of unknown variance γ = n is the likelihood itself; residuals of a model that
  is not quite right hang together, and `independent_residuals` says how many they are worth. A uniform share stays.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipelines.results import FloatArray
from pipelines.warm_start.density import Box, Density, Weighting

DRAWS = 2000
ROUNDS = 12
LEAST = 0.1
UNIFORM = 0.05


def independent_residuals(residuals: FloatArray) -> float:
    """How many independent numbers the residuals (n,) in order of time are worth: n over the autocorrelation time.

    The time is 1 + 2 sum of autocorrelations up to where they first fall below zero.
    """
    n = len(residuals)
    if n < 2:
        return float(n)
    centred = residuals - residuals.mean()
    spectrum = np.fft.rfft(centred, 2 * n)
    covariance = np.fft.irfft(np.abs(spectrum) ** 2, 2 * n)[:n]
    if covariance[0] <= 0:
        return float(n)
    share = covariance / covariance[0]
    below = np.flatnonzero(share <= 0)
    stop = int(below[0]) if len(below) else n
    return float(n / (1 + 2 * share[1:stop].sum()))


def _effective(logs: FloatArray) -> float:
    weights = np.exp(logs - logs.max())
    return float(weights.sum() ** 2 / (weights**2).sum())


def _largest_power(base: FloatArray, costs: FloatArray, most: float, least: float) -> float:
    """The largest power up to `most` at which exp(base - power * costs) leaves `least` effective points."""
    if _effective(base - most * costs) >= least:
        return most
    low, high = 0.0, most
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _effective(base - middle * costs) >= least else (low, middle)
    return low


def tempered_density(
    surrogate: Callable[[FloatArray], FloatArray],
    box: Box,
    power: float,
    exact: Callable[[FloatArray], float] | None,
    rng: np.random.Generator,
) -> Density:
    """Density of J^-power over the box. surrogate: mean of log J (n,) at points (n, d) of the box scaled to 0..1.

    Importance sampling in rounds: each draws from the last one's density and goes up in power as far as a tenth of the
    draws stay effective, so that a narrow ridge is found where a single uniform round would leave one point.
    exact: J at a point of the box itself, instead of the surrogate.
    """
    d = len(box.low)
    unit = Box(np.zeros(d), np.ones(d))
    points, base, reached, last = rng.random((DRAWS, d)), np.zeros(DRAWS), 0.0, False
    for turn in range(ROUNDS):
        last = (reached >= power and turn > 0) or turn == ROUNDS - 1
        if exact is None:
            costs = surrogate(points)
        else:
            costs = np.log([max(exact(box.low + point * box.span), 1e-300) for point in points])
        costs = np.minimum(costs - costs.min(), 1e300)
        step = _largest_power(base, costs, power, LEAST * DRAWS)
        reached = step if last else max(reached, step)
        logs = base - reached * costs
        weights = np.exp(logs - logs.max())
        density = Density(points, weights / weights.sum(), unit, UNIFORM)
        if last:
            break
        points = density.draw(DRAWS, rng)
        base = -density.log_density(points)
    return Density(box.low + density.points * box.span, density.weights, box, UNIFORM)


def history_density(points: FloatArray, costs: FloatArray, box: Box, weighting: Weighting) -> Density:
    """Density over the history itself; points whose cost is not finite count nothing."""
    good = np.isfinite(costs)
    if not good.any():
        raise ValueError("no point of the history has a finite cost")
    points, costs = points[good], costs[good]
    weights = np.ones(len(costs))
    if weighting == "cost":
        above = costs - costs.min()
        weights = np.exp(-above / max(float(np.median(above)), 1e-300))
    return Density(points, weights / weights.sum(), box)
