"""Gauss-Newton with normal priors, and an interval that allows for residuals that hang together in time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.results import FloatArray

Model = Callable[[FloatArray], FloatArray]
"""Parameters (k,) -> predictions (n,)."""

HUBER = 3.0
STEPS = 30
HALVINGS = 8


@dataclass(frozen=True)
class Unknown:
    """One parameter of a fit: where it starts, its prior's standard deviation (inf: none) and mean (None: the start),
    and a step for its numerical derivative."""

    name: str
    start: float
    std: float
    step: float
    mean: float | None = None


@dataclass(frozen=True)
class Samples:
    """What is fitted. y: (n,). group: (n,) from 0, which channel a row is of: each has a noise of its own. block: (n,)
    number of the stretch of time that a row is in: the scores of different stretches are independent, those inside one
    are not. noise: (groups,) first guess. floor: (groups,) least noise."""

    y: FloatArray
    group: IntArray
    block: IntArray
    noise: FloatArray
    floor: FloatArray


@dataclass(frozen=True)
class LeastFit:
    """values (k,), covariance (k, k) with block scatter, white (k, k) without, residual (n,), noise (groups,)."""

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    white: FloatArray
    residual: FloatArray
    noise: FloatArray
    converged: bool

    def value(self, name: str) -> float:
        """A parameter's."""
        return float(self.values[self.names.index(name)])

    def std(self, name: str) -> float:
        """Its standard deviation, with block scatter."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]))


def blocks_of(rows: IntArray, rate_hz: float, shortest_s: float, longest_s: float) -> IntArray:
    """Numbers of the stretches that rows are in: twenty over what is there, within the given lengths."""
    seconds = min(max(len(rows) / rate_hz / 20, shortest_s), longest_s)
    return np.asarray(rows / (seconds * rate_hz), dtype=np.int64)


def jacobian(model: Model, x: FloatArray, steps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Predictions (n,) and their forward differences (k, n)."""
    base = model(x)
    columns = np.empty((len(x), len(base)))
    for i in range(len(x)):
        moved = x.copy()
        moved[i] += steps[i]
        columns[i] = (model(moved) - base) / steps[i]
    return base, columns


def _noises(samples: Samples, residual: FloatArray, weight: FloatArray) -> FloatArray:
    """(groups,) standard deviation of each channel about zero: a mean is an error too."""
    count = len(samples.floor)
    # wild rows count with what Huber's limit leaves of them
    power = np.bincount(samples.group, weights=(weight * residual) ** 2, minlength=count)
    total = np.bincount(samples.group, minlength=count)
    return np.asarray(np.sqrt(power / np.maximum(total, 1.0) + samples.floor**2))


def fit_least(model: Model, samples: Samples, unknowns: tuple[Unknown, ...]) -> LeastFit:
    """Fit model(x) to y with each channel's noise re-estimated, Huber's weights and normal priors."""
    x = np.array([u.start for u in unknowns])
    centre = np.array([u.start if u.mean is None else u.mean for u in unknowns])
    precision = np.array([0.0 if not np.isfinite(u.std) else 1 / max(u.std, 1e-9) ** 2 for u in unknowns])
    steps, root = np.array([u.step for u in unknowns]), np.sqrt(precision)
    noise = samples.noise
    weight = np.ones(len(samples.y))
    converged = False
    for count in range(STEPS):
        base, columns = jacobian(model, x, steps)
        residual = samples.y - base
        if count:
            noise = _noises(samples, residual, weight)
        each = noise[samples.group]
        whitened = residual / each
        if count:
            weight = np.minimum(1.0, HUBER / np.maximum(np.abs(whitened), 1e-12))
        j = columns / each
        weighted = j * weight
        hessian = weighted @ j.T + np.diag(precision)
        pull = weighted @ whitened + precision * (centre - x)
        scale = 1 / np.sqrt(np.maximum(np.diag(hessian), 1e-300))
        move = scale * np.linalg.lstsq(hessian * np.outer(scale, scale), scale * pull, rcond=1e-12)[0]

        def cost(step: FloatArray, at: FloatArray = x, scaled: FloatArray = each) -> float:
            return _size((samples.y - model(at + step)) / scaled, root * (centre - at - step))

        move = _short_enough(move, _size(whitened, root * (centre - x)), cost)
        x = x + move
        if count > 2 and np.all(np.abs(move) < 0.01 * scale):
            converged = True
            break
    covariance = np.outer(scale, scale) * np.linalg.pinv(hessian * np.outer(scale, scale), rcond=1e-12)
    wide = _blocked(covariance, weighted * whitened, samples.block, precision)
    names = tuple(u.name for u in unknowns)
    return LeastFit(names, x, wide, covariance, residual, noise, converged)


def _size(whitened: FloatArray, pull: FloatArray) -> float:
    """Huber's squares of the residuals, and those of what priors are missed by."""
    size = np.abs(whitened)
    return float(np.sum(np.where(size <= HUBER, size * size, HUBER * (2 * size - HUBER)))) + float(
        pull @ pull
    )


def _short_enough(move: FloatArray, here: float, cost: Callable[[FloatArray], float]) -> FloatArray:
    """The step, halved until it gains with the noise as it is: whole ones swing to and fro along valleys, and end anywhere.

    here: the cost without it; cost: of a step.
    """
    for _ in range(HALVINGS):
        if cost(move) < here or not np.isfinite(here):
            break
        move = 0.5 * move
    return move


def _blocked(
    covariance: FloatArray, scores: FloatArray, blocks: IntArray, precision: FloatArray
) -> FloatArray:
    """The covariance with the scores' scatter between blocks in place of white noise; never below the white one."""
    _, number = np.unique(blocks, return_inverse=True)
    count = int(number.max()) + 1
    sums = np.zeros((scores.shape[0], count))
    for i in range(scores.shape[0]):
        sums[i] = np.bincount(number, weights=scores[i], minlength=count)
    # few blocks show too little scatter: Student's spread stands in
    factor = count / max(count - 2.0, 0.5)
    middle = factor * (sums @ sums.T) + np.diag(precision)
    scattered = covariance @ middle @ covariance
    ratio = np.sqrt(np.maximum(np.diag(scattered) / np.maximum(np.diag(covariance), 1e-300), 1.0))
    return np.asarray(covariance * np.outer(ratio, ratio))
