"""From prior and misfit to MAP, densities, moments and evidence, (43)-(47): Gauss-Newton and importance sampling.

Nothing here runs the model: the surrogate is a matrix product, so that tens of thousands of points cost milliseconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from pipelines.bayes.priors import Priors
from pipelines.bayes.surrogate import Surrogate
from pipelines.chaos.collocation import hammersley
from pipelines.results import FloatArray

DRAWS, FEW_DRAWS = 5_000, 1_500
BROAD_SHARE = 0.2
"""Share of the draws that is spread evenly over the whole domain, so that nothing in it is missed."""

TAIL = 6.0
"""Degrees of freedom of the draws about the MAP: broader than the posterior they stand for."""

STEPS = 60
STARTS = 1_000
"""FEW_DRAWS: on the way through the intervals."""


@dataclass(frozen=True)
class Posterior:
    """Weighted draws over the surrogate's domain, and the MAP.

    map_xi (d,), map_value (d,): the densest point, in the domain's and in the parameters' units. xi, values (n, d): draws;
    weights (n,) sum to 1. log_evidence: of the data under the prior, up to the residuals' own scale. effective: how many equally
    weighted draws they are worth. curvature (d, d): of the log posterior at the MAP, over xi.
    """

    priors: Priors
    surrogate: Surrogate
    map_xi: FloatArray
    map_value: FloatArray
    xi: FloatArray
    values: FloatArray
    weights: FloatArray
    log_evidence: float
    effective: float
    curvature: FloatArray

    @cached_property
    def mean(self) -> FloatArray:
        """(d,)"""
        return np.asarray(self.weights @ self.values)

    @cached_property
    def covariance(self) -> FloatArray:
        """(d, d)"""
        off = self.values - self.mean
        return np.asarray((off * self.weights[:, None]).T @ off)

    @property
    def std(self) -> FloatArray:
        """(d,)"""
        return np.sqrt(np.diag(self.covariance))

    def quantiles(self, shares: FloatArray) -> FloatArray:
        """Of each parameter, (len(shares), d)."""
        out = np.empty((len(shares), self.values.shape[1]))
        for j in range(out.shape[1]):
            order = np.argsort(self.values[:, j])
            total = np.cumsum(self.weights[order])
            out[:, j] = np.interp(shares, total - 0.5 * self.weights[order], self.values[order, j])
        return out

    def density(self, parameter: int, points: int = 200) -> tuple[FloatArray, FloatArray]:
        """A parameter's marginal density: values and density, each (points,). Smoothed by a tenth to a fifth of its spread."""
        mean, std = float(self.mean[parameter]), float(self.std[parameter])
        grid = mean + np.linspace(-4.5, 4.5, points) * std
        width = std * 1.06 * max(self.effective, 10.0) ** -0.2
        off = (grid[:, None] - self.values[None, :, parameter]) / width
        density = np.exp(-0.5 * off * off) @ self.weights / (width * math.sqrt(2 * math.pi))
        return grid, np.asarray(density)

    def spread_in_domain(self) -> FloatArray:
        """Covariance (d, d) over xi."""
        mean = self.weights @ self.xi
        off = self.xi - mean
        return np.asarray((off * self.weights[:, None]).T @ off)


def _log_posterior(priors: Priors, found: Surrogate, xi: FloatArray) -> FloatArray:
    """Logarithm of the parameters' density, not normalised, at xi (n, d)."""
    return priors.log_density(found.domain.out(xi)) - 0.5 * found.misfit(xi)


def _prior_slopes(priors: Priors, found: Surrogate, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gradient (d,) and negative curvature (d, d) of the log prior over xi, 0 where it is flat or bounded."""
    d, step = len(xi), 1e-3
    eye = step * np.eye(d)
    points = [xi, *(xi + e for e in eye), *(xi - e for e in eye)]
    log = priors.log_density(found.domain.out(np.array(points)))
    ahead, behind = log[1 : d + 1], log[d + 1 :]
    with np.errstate(invalid="ignore"):
        gradient = (ahead - behind) / (2 * step)
        bent = -(ahead - 2 * log[0] + behind) / step**2
    fine = np.isfinite(gradient) & np.isfinite(bent)
    # priors are independent over the coordinates, but xi may be turned: the diagonal is enough to take steps by
    return np.where(fine, gradient, 0.0), np.diag(np.where(fine, np.maximum(bent, 0.0), 0.0))


def find_map(priors: Priors, found: Surrogate, starts: int = STARTS) -> tuple[FloatArray, FloatArray]:
    """The densest point xi (d,) of the domain, and the curvature (d, d) there: the best of many points, then Gauss-Newton."""
    d = found.domain.axes.shape[0]
    points = np.vstack((np.zeros((1, d)), 2 * hammersley(starts, d) - 1))
    log = _log_posterior(priors, found, points)
    xi, best = points[np.argmax(log)], float(np.max(log))
    damping = 1e-6
    curvature = np.eye(d)
    for _ in range(STEPS):
        e, slopes = found.slopes(xi)
        gradient, bent = _prior_slopes(priors, found, xi)
        curvature = slopes.T @ slopes + bent
        scale = np.diag(np.maximum(np.diag(curvature), 1e-12))
        step = np.linalg.solve(curvature + damping * scale, gradient - slopes.T @ e)
        trial = np.clip(xi + step, -1.0, 1.0)
        value = float(_log_posterior(priors, found, trial[None])[0])
        if value > best:
            moved = float(np.max(np.abs(trial - xi)))
            xi, best, damping = trial, value, max(damping * 0.2, 1e-9)
            if moved < 1e-6:
                break
        else:
            damping *= 10.0
            if damping > 1e6:
                break
    return xi, np.asarray(curvature + 1e-9 * np.eye(d))


def posterior(priors: Priors, found: Surrogate, draws: int = DRAWS) -> Posterior:
    """MAP, weighted draws, evidence. Deterministic: the draws are a fixed, evenly spread set."""
    d = found.domain.axes.shape[0]
    map_xi, curvature = find_map(priors, found, draws // 5)
    sizes, vectors = np.linalg.eigh(curvature)
    # no axis broader than the domain: a flat direction is the even draws' to cover
    axes = vectors / np.sqrt(np.maximum(sizes, 1.0))
    even, spread = _standard_draws(draws, d)
    broad = len(even)
    near = map_xi + spread @ axes.T
    xi = np.vstack((even, near))
    inside = np.all(np.abs(xi) <= 1.0, axis=1)
    xi = xi[inside]
    log = _log_posterior(priors, found, xi) + priors.log_stretch(found.domain.out(xi))
    whitened = (xi - map_xi) @ np.linalg.inv(axes).T
    mixture = _mixture(whitened, axes, d, broad / draws)
    ratio = log - np.log(mixture)
    top = float(np.max(ratio))
    weights = np.exp(ratio - top)
    total = float(weights.sum())
    stretch = float(np.linalg.slogdet(found.domain.axes)[1])
    weights /= total
    coordinates = found.domain.out(xi)
    return Posterior(
        priors=priors,
        surrogate=found,
        map_xi=map_xi,
        map_value=priors.values(found.domain.out(map_xi[None]))[0],
        xi=xi,
        values=priors.values(coordinates),
        weights=weights,
        log_evidence=top + math.log(total / draws) + stretch,
        effective=float(1 / np.sum(weights**2)),
        curvature=curvature,
    )


@cache
def _standard_draws(draws: int, d: int) -> tuple[FloatArray, FloatArray]:
    """Evenly spread points (b, d) of the box, and of Student's distribution about 0 (draws - b, d)."""
    broad = round(BROAD_SHARE * draws)
    return 2 * hammersley(broad, d) - 1, student_draws(draws - broad, (d,))


@cache
def student_draws(draws: int, parts: tuple[int, ...], turn: int = 0) -> FloatArray:
    """(draws, sum of parts) evenly spread draws of Student's distributions about 0, a tail for each part.

    turn: another set, as even, for each.
    """
    from scipy.special import gammaincinv, ndtri

    d = sum(parts)
    cube = hammersley(draws, d + len(parts))
    if turn:
        shift = turn * np.sqrt(np.arange(2, d + len(parts) + 2))
        cube = np.clip((cube + shift) % 1.0, 1e-9, 1 - 1e-9)
    tails = np.sqrt(TAIL / (2 * gammaincinv(TAIL / 2, cube[:, d:])))
    return np.asarray(ndtri(cube[:, :d]) * np.repeat(tails, parts, axis=1))


def _mixture(whitened: FloatArray, axes: FloatArray, d: int, broad: float) -> FloatArray:
    """Density over xi of the draws: even over the domain, and Student's about the MAP."""
    square = np.einsum("ni,ni->n", whitened, whitened)
    log = (
        math.lgamma((TAIL + d) / 2)
        - math.lgamma(TAIL / 2)
        - 0.5 * d * math.log(TAIL * math.pi)
        - float(np.linalg.slogdet(axes)[1])
    )
    student = np.exp(log - 0.5 * (TAIL + d) * np.log1p(square / TAIL))
    return np.asarray(broad / 2.0**d + (1 - broad) * student)
