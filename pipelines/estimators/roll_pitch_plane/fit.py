"""Linear least squares of a whole drive: priors on what is hardly told, noise on regressors taken out, honest covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.results import FloatArray

LEAST_BLOCKS = 5
NOISE_DOUBT = 0.3
MOST_TAKEN = 0.9
"""Largest share of a regressor's own variance that is taken out as noise; NOISE_DOUBT: how far the noise's variance may be
off."""


@dataclass(frozen=True)
class Column:
    """A regressor (n,). mean, std: of its coefficient before the log (std None: free). noise: variance of the noise on it."""

    name: str
    values: FloatArray
    mean: float = 0.0
    std: float | None = None
    noise: float = 0.0


@dataclass(frozen=True)
class LinearFit:
    """values (k,) and covariance (k, k) of the coefficients by `names`; residual (n,); explained: share of the response's
    variance; told: (k,) share of each regressor's variation, the others' taken off, that is not noise; spread: (k,) what is
    left of it, as a standard deviation."""

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    residual: FloatArray
    explained: float
    told: FloatArray
    spread: FloatArray
    blocks: int

    def value(self, name: str) -> float:
        """A coefficient."""
        return float(self.values[self.names.index(name)])

    def std(self, name: str) -> float:
        """Its standard deviation."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]))

    def doubt(self, name: str, moment_std: float) -> float:
        """What errors of the model of `moment_std`, and of the noise's own variance, may do to a coefficient."""
        i = self.names.index(name)
        told = max(float(self.told[i]), 1e-6)
        noise = NOISE_DOUBT * (1 - told) / told * abs(float(self.values[i]))
        return float(np.hypot(noise, moment_std / max(float(self.spread[i]), 1e-12)))


def _correlation_rows(residual: FloatArray, block: IntArray) -> float:
    """How many rows count as one: variance of the blocks' sums over that of independent rows; 1 at least."""
    size = np.bincount(block)
    sums = np.bincount(block, residual)
    white = float(np.mean(residual**2)) * size
    there = size > 0
    return max(1.0, float(np.sum(sums[there] ** 2) / np.sum(white[there]))) if white.sum() > 0 else 1.0


def fit(response: FloatArray, columns: tuple[Column, ...], block: IntArray) -> LinearFit | None:
    """Coefficients of the columns. block: (n,) numbers of the stretches by whose scatter the covariance is told.

    The noise's part of a regressor's square is taken out, so that it pulls nothing towards zero (errors in variables); the
    covariance is that of the blocks' scores, whatever correlation the residual has. None below LEAST_BLOCKS blocks.
    """
    x = np.column_stack([c.values for c in columns])
    _, block = np.unique(block, return_inverse=True)
    blocks = int(block.max()) + 1
    if blocks < LEAST_BLOCKS:
        return None
    gram = x.T @ x
    noise = np.array([len(x) * c.noise for c in columns])
    own = _own(gram)
    told = 1 - np.minimum(noise / own, 1.0)
    spread = np.sqrt(own * told / len(x))
    # the square keeps its sign: what is nearly all noise is left to its prior
    excess = np.minimum(noise, MOST_TAKEN * own)
    clean = gram - np.diag(excess)
    weight = np.array([0.0 if c.std is None else c.std**-2 for c in columns])
    mean = np.array([c.mean for c in columns])
    scale = max(float(np.var(response)), 1e-30)
    values = mean
    for _ in range(3):
        normal = clean / scale + np.diag(weight)
        values = np.linalg.lstsq(normal, x.T @ response / scale + weight * mean, rcond=1e-13)[0]
        residual = response - x @ values
        # a residual that hangs together holds fewer observations than rows, against which the priors stand
        scale = max(float(np.mean(residual**2)) * _correlation_rows(residual, block), 1e-30)
    normal = clean / scale + np.diag(weight)
    scores = np.zeros((blocks, x.shape[1]))
    size = np.bincount(block)
    for i in range(x.shape[1]):
        scores[:, i] = np.bincount(block, x[:, i] * residual) + values[i] * excess[i] / len(x) * size
    scores *= np.sqrt(blocks / (blocks - 1)) / scale
    inverse = np.linalg.pinv(normal)
    covariance = inverse @ (scores.T @ scores + np.diag(weight)) @ inverse
    explained = 1 - float(np.var(residual)) / max(float(np.var(response)), 1e-30)
    return LinearFit(
        tuple(c.name for c in columns), values, covariance, residual, explained, told, spread, blocks
    )


def _own(gram: FloatArray) -> FloatArray:
    """Sum of squares of each regressor beyond what the others explain, (k,)."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    scaled = gram / np.outer(size, size)
    return np.asarray(size**2 / np.maximum(np.diag(np.linalg.pinv(scaled, rcond=1e-12)), 1e-300))
