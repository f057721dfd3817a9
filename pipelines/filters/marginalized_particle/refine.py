"""The posterior of a whole drive without the smoothed move's blur: importance sampling from where a first run ended.

θ does not change in a drive, and given θ the Kalman filter's likelihood is exact. So particles drawn once from a broad
distribution around a first run's final cloud, weighed by prior over that distribution and filtered without any resampling,
have the posterior's weights exactly; how many of them are effective says how well the distribution was chosen. Only the first
run's end is used, so that a first run that was too sharp, or smoothed too much, does no harm but to that number.

The distribution is Student's t in the coordinates of `moves`, folded at the mirror line where the prior lies above it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipelines.filters.marginalized_particle.clouds import Given, mirror_height
from pipelines.filters.marginalized_particle.filter import Segments, run_particles
from pipelines.filters.marginalized_particle.moves import SIDE
from pipelines.filters.marginalized_particle.records import (
    PARAMETERS,
    Cloud,
    Noise,
    ParticleRun,
    ParticleSettings,
)
from pipelines.results import FloatArray

FREEDOM = 5.0
"""Degrees of freedom of Student's t: tails heavier than a posterior's."""

BROADER = 1.3
"""Its scale over the cloud's spread."""


@dataclass(frozen=True)
class UniformPrior:
    """What `uniform_cloud` draws from, as a density: K, D, h uniform over ranges, the others normal or known."""

    ranges: Mapping[str, tuple[float, float]]
    mass_kg: Given
    roll_inertia_kgm2: Given
    input_height_m: Given = 0.0
    above_mirror: bool = True

    def log_density(self, theta: FloatArray) -> FloatArray:
        """(N,) log density at theta (N, 6), minus infinity outside; of those columns that have a spread."""
        low, high = (np.array([self.ranges[name][end] for name in PARAMETERS]) for end in (0, 1))
        lows = np.tile(low, (len(theta), 1))
        if self.above_mirror:
            lows[:, 2] = np.maximum(lows[:, 2], mirror_height(theta[:, 3], theta[:, 4]))
        inside = ((theta[:, :3] >= lows) & (theta[:, :3] <= high)).all(axis=1)
        total = -np.log(np.maximum(high - lows, 1e-300)).sum(axis=1)
        for column, given in zip(
            (3, 4, 5), (self.mass_kg, self.roll_inertia_kgm2, self.input_height_m), strict=True
        ):
            if isinstance(given, tuple) and given[1] > 0:
                z = (theta[:, column] - given[0]) / given[1]
                total = total - 0.5 * z**2 - np.log(given[1] * np.sqrt(2 * np.pi))
        return np.where(inside, total, -np.inf)


@dataclass(frozen=True)
class Refined:
    """run: over the drive, without resampling; its `evidence` is of its own weights. log_evidence: of the drive under the prior.

    effective: how many particles carry the posterior at the end.
    """

    run: ParticleRun
    log_evidence: float
    effective: float


def _coordinates(theta: FloatArray) -> FloatArray:
    """(N, 6) of `moves.to_coordinates`, all rows at once."""
    line = mirror_height(theta[:, 3], theta[:, 4])
    first = np.log(theta[:, :2] / theta[:, [2]])
    return np.column_stack(
        (first, np.log(theta[:, 2] / line), np.log(theta[:, 3]), np.log(theta[:, 4]), theta[:, 5])
    )


def _theta(at: FloatArray) -> FloatArray:
    mass, inertia = np.exp(at[:, 3]), np.exp(at[:, 4])
    height = np.exp(at[:, 2]) * mirror_height(mass, inertia)
    return np.column_stack((np.exp(at[:, :2]) * height[:, None], height, mass, inertia, at[:, 5]))


class _Proposal:
    """Student's t around a cloud, in those coordinates that vary."""

    def __init__(self, cloud: Cloud, fold: bool):
        at = _coordinates(cloud.theta)
        weights = cloud.weights / cloud.weights.sum()
        self._mean = weights @ at
        centred = at - self._mean
        covariance = (centred * weights[:, None]).T @ centred
        self._fold = fold
        if fold and self._mean[SIDE] < 3.0 * np.sqrt(covariance[SIDE, SIDE]):
            covariance[SIDE, SIDE] += self._mean[SIDE] ** 2
            covariance[SIDE, np.arange(6) != SIDE] = covariance[np.arange(6) != SIDE, SIDE] = 0.0
            self._mean[SIDE] = 0.0
        varying = np.diag(covariance) > 1e-20
        self._varies = np.flatnonzero(varying)
        inner = covariance[np.ix_(varying, varying)]
        inner = inner + 1e-9 * np.diag(np.diag(inner))
        self._root = BROADER * np.linalg.cholesky(inner)

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """θ (count, 6)."""
        d = len(self._varies)
        scale = np.sqrt(FREEDOM / rng.chisquare(FREEDOM, count))
        at = np.tile(self._mean, (count, 1))
        at[:, self._varies] += scale[:, None] * (rng.standard_normal((count, d)) @ self._root.T)
        if self._fold:
            at[:, SIDE] = np.abs(at[:, SIDE])
        return _theta(at)

    def _log(self, at: FloatArray) -> FloatArray:
        from math import lgamma

        from scipy.linalg import solve_triangular

        d = len(self._varies)
        scaled = solve_triangular(self._root, (at - self._mean)[:, self._varies].T, lower=True)
        constant = lgamma(0.5 * (FREEDOM + d)) - lgamma(0.5 * FREEDOM) - 0.5 * d * np.log(FREEDOM * np.pi)
        tail = -0.5 * (FREEDOM + d) * np.log1p((scaled**2).sum(axis=0) / FREEDOM)
        return np.asarray(constant - np.log(np.diag(self._root)).sum() + tail)

    def log_density(self, theta: FloatArray) -> FloatArray:
        """(N,) of θ, in the units of those of its columns that vary."""
        at = _coordinates(theta)
        total = self._log(at)
        if self._fold:
            image = at.copy()
            image[:, SIDE] = -image[:, SIDE]
            total = np.logaddexp(total, self._log(image))
        logs = [column for column in self._varies if column < 5]
        return np.asarray(total - np.log(theta[:, logs]).sum(axis=1))


def refine(
    y: FloatArray,
    accel: FloatArray,
    step_s: float,
    first: Cloud,
    prior: UniformPrior,
    noise: Noise,
    settings: ParticleSettings,
    rng: np.random.Generator,
    *,
    count: int = 2000,
    rounds: int = 2,
    segments: Segments | None = None,
) -> Refined:
    """Posterior of the whole drive. first: a run's final cloud; each round starts from the one before. count: particles.

    settings: gravity, offsets, hold and quantiles are taken; there is no resampling and no move. Other arguments as
    `run_particles` has them. Raises ValueError where nothing drawn lies within the prior.
    """
    still = replace(
        settings, threshold=0.0, walk=(0.0, 0.0, 0.0), kernel=0.0, adaptive=False, fixed=None, most=count
    )
    cloud = first
    for _ in range(max(rounds, 1)):
        proposal = _Proposal(cloud, prior.above_mirror)
        theta = proposal.draw(count, rng)
        logs = prior.log_density(theta) - proposal.log_density(theta)
        if not (logs > -np.inf).any():
            raise ValueError("no particle drawn around the first run's end lies within the prior")
        weights = np.exp(logs - logs.max())
        run = run_particles(y, accel, step_s, Cloud(theta, weights), noise, still, rng, segments=segments)
        cloud = run.final
    mean_weight = float(logs.max() + np.log(weights.mean()))
    total = float(np.nansum(run.log_likelihood)) + mean_weight
    return Refined(run, total, float(1.0 / (cloud.weights**2).sum()))
