"""Kernel density over weighted points in a box: its figures a dimension (as in the paper's Fig 2) and its joint draws."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from pipelines.results import FloatArray

Weighting = Literal["published", "cost", "tempered"]

GRID = 512
"""Places a dimension at which a density is summed up."""


@dataclass(frozen=True)
class Box:
    """The admissible range Θ. low, high: (d,)."""

    low: FloatArray
    high: FloatArray

    def __post_init__(self) -> None:
        """Refuse an empty box."""
        fits = self.low.ndim == 1 and self.low.shape == self.high.shape and len(self.low) > 0
        if not (fits and np.isfinite([self.low, self.high]).all() and (self.low < self.high).all()):
            raise ValueError("a box has a finite low below a finite high in each dimension")

    @property
    def span(self) -> FloatArray:
        """(d,) its edges."""
        return self.high - self.low

    def holds(self, points: FloatArray) -> np.typing.NDArray[np.bool_]:
        """(n,) whether points (n, d) lie in it."""
        return np.asarray(((points >= self.low) & (points <= self.high)).all(axis=1))


@dataclass(frozen=True)
class Density:
    """Gaussian kernels at points (t, d) with weights (t,) of sum one, cut off at the box, and a uniform share besides.

    uniform: probability of a draw from the whole box instead of the kernels: nothing that was possible becomes impossible.
    """

    points: FloatArray
    weights: FloatArray
    box: Box
    uniform: float = 0.0

    @cached_property
    def effective(self) -> float:
        """How many points carry the weight."""
        return float(1.0 / (self.weights**2).sum())

    @cached_property
    def covariance(self) -> FloatArray:
        """(d, d) of the weighted points; a thousandth of the box's edge at least."""
        centred = self.points - self.weights @ self.points
        floor = np.diag((1e-3 * self.box.span) ** 2)
        return np.asarray((centred * self.weights[:, None]).T @ centred + floor)

    @cached_property
    def factor(self) -> FloatArray:
        """(d, d) lower root of the joint kernels' covariance (Scott's rule on the effective number of points)."""
        width = self.effective ** (-1.0 / (self.points.shape[1] + 4))
        return np.asarray(width * np.linalg.cholesky(self.covariance))

    def marginal(self, dimension: int) -> tuple[FloatArray, FloatArray]:
        """(GRID,) places of the box and the density there, of integral one: Silverman's kernel width for one dimension."""
        low, high = self.box.low[dimension], self.box.high[dimension]
        at = low + (np.arange(GRID) + 0.5) * (high - low) / GRID
        width = np.sqrt(self.covariance[dimension, dimension]) * (4 / (3 * self.effective)) ** 0.2
        gaps = (at[:, None] - self.points[:, dimension]) / width
        value = np.exp(-0.5 * gaps**2) @ self.weights
        share = value / (value.sum() * (high - low) / GRID)
        return at, (1 - self.uniform) * share + self.uniform / (high - low)

    def confidence_box(self, confidence: float) -> Box:
        """Algorithm 1's line 9: what lies between the (1 -+ confidence) / 2 quantiles of each dimension."""
        ends = []
        for dimension in range(self.points.shape[1]):
            at, value = self.marginal(dimension)
            total = np.append(0.0, np.cumsum(value) / value.sum())
            edges = np.append(self.box.low[dimension], at + 0.5 * (at[1] - at[0]))
            ends.append(np.interp([0.5 - confidence / 2, 0.5 + confidence / 2], total, edges))
        low, high = np.array(ends).T
        return Box(low, high)

    def draw_dimension(self, dimension: int, count: int, inside: Box, rng: np.random.Generator) -> FloatArray:
        """(count,) draws of one dimension by its own density within `inside`."""
        at, value = self.marginal(dimension)
        half = 0.5 * (at[1] - at[0])
        value = np.where((at >= inside.low[dimension]) & (at <= inside.high[dimension]), value, 0.0)
        total = np.append(0.0, np.cumsum(value) / value.sum())
        drawn = np.interp(rng.random(count), total, np.append(at - half, at[-1] + half))
        return np.asarray(np.clip(drawn, inside.low[dimension], inside.high[dimension]))

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """(count, d) draws of the joint density; what falls outside the box is drawn again."""
        d = self.points.shape[1]
        drawn, missing = np.empty((count, d)), np.ones(count, dtype=bool)
        for _ in range(200):
            left = int(missing.sum())
            if left == 0:
                return drawn
            chosen = rng.choice(len(self.points), size=left, p=self.weights)
            fresh = self.points[chosen] + rng.standard_normal((left, d)) @ self.factor.T
            flat = rng.random(left) < self.uniform
            fresh[flat] = self.box.low + rng.random((int(flat.sum()), d)) * self.box.span
            drawn[missing] = fresh
            missing = ~self.box.holds(drawn)
        return np.clip(drawn, self.box.low, self.box.high)

    def log_density(self, points: FloatArray) -> FloatArray:
        """(n,) logarithm of what `draw` draws from, at points (n, d) of the box, up to the cut's constant."""
        from scipy.linalg import solve_triangular
        from scipy.special import logsumexp

        d = points.shape[1]
        scaled = solve_triangular(self.factor, points.T, lower=True)
        centres = solve_triangular(self.factor, self.points.T, lower=True)
        squares = (scaled**2).sum(axis=0)[:, None] + (centres**2).sum(axis=0) - 2 * scaled.T @ centres
        constant = -0.5 * d * np.log(2 * np.pi) - np.log(np.diag(self.factor)).sum()
        kernels = logsumexp(-0.5 * np.maximum(squares, 0.0), axis=1, b=self.weights) + constant
        if self.uniform <= 0:
            return np.asarray(kernels)
        flat = np.log(self.uniform) - np.log(self.box.span).sum()
        return np.asarray(np.logaddexp(np.log1p(-self.uniform) + kernels, flat))
