"""A guide for the moves, learned from the points themselves: which directions the data inform, and how the points lie."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.joint.sampling.gaussianity import LogDensity
from pipelines.joint.sampling.mixture import Mixture, Mode, mixture_of
from pipelines.joint.sampling.moves import Cloud, Guide
from pipelines.results import FloatArray

STEP = 1e-5
"""Of a difference for a slope, in prior standard deviations: far below what any log can resolve."""

PROBED = 24
"""Points at which the likelihood's slope is taken."""

INFORMED = 0.2
"""Mean square of the likelihood's slope along a direction from which on it counts as informed; 1 would halve its variance.
Below, a mean and a spread of its own are guide enough."""

MOST_INFORMED = 48

SLICES = 4
"""Overlapping slices into which a curved cloud is cut."""


def slopes(density: LogDensity, u: FloatArray, value: FloatArray, step: float = STEP) -> FloatArray:
    """(n, k) slope of the log density by differences, 0 where a step leads out of bounds."""
    n, k = u.shape
    moved = (u[:, None, :] + step * np.eye(k)).reshape(n * k, k)
    with np.errstate(invalid="ignore"):
        slope = (density(moved).reshape(n, k) - value[:, None]) / step
    return np.where(np.isfinite(slope), slope, 0.0)


def informed_basis(
    density: LogDensity, modes: Sequence[Mode], cloud: Cloud, power: float, rng: np.random.Generator
) -> tuple[FloatArray, int]:
    """(k, k) orthonormal directions, the informed first, and how many those are.

    By the likelihood's information at the modes and the squares of its slope at some of the points (Zahm et al. 2022).
    """
    k = cloud.u.shape[1]
    some = rng.choice(cloud.value.size, min(PROBED, cloud.value.size), replace=False)
    slope = power * (slopes(density, cloud.u[some], cloud.value[some]) + cloud.u[some])
    matrix = slope.T @ slope / some.size
    for _, covariance in modes:
        matrix += power * (np.linalg.solve(covariance, np.eye(k)) - np.eye(k)) / len(modes)
    size, basis = np.linalg.eigh(0.5 * (matrix + matrix.T))
    count = int(np.sum(np.abs(size) > INFORMED))
    order = np.argsort(-np.abs(size))
    return basis[:, order], min(max(count, 1), k, MOST_INFORMED)


def fit_guide(basis: FloatArray, informed: int, cloud: Cloud, near: Sequence[Mode]) -> Guide:
    """From the points. near: the modes at the power that these are at."""
    x = cloud.u @ basis
    label = np.argmax(mixture_of(np.ones(len(near)), near).each(cloud.u), axis=1)
    axes = basis[:, :informed]
    shown = [(place @ axes, axes.T @ covariance @ axes) for place, covariance in near]
    rest = x[:, informed:]
    inner = fit_mixture(x[:, :informed], label, shown)
    return Guide(basis, inner, rest.mean(axis=0), rest.std(axis=0) + 1e-9)


def fit_mixture(x: FloatArray, label: np.ndarray, near: Sequence[Mode]) -> Mixture:
    """A Gaussian over each mode's points, and where they lie along a curve, over each of its slices too.

    x: (n, d). label: (n,) each point's mode. near: the modes, for those that have hardly a point. Half of the weights are
    equal: a mode that lost its points by chance must be jumped to, and its share comes from the jumps.
    """
    weights: list[float] = []
    parts: list[Mode] = []
    for number, mode in enumerate(near):
        mine = x[label == number]
        share = 0.5 * mine.shape[0] / x.shape[0] + 0.5 / len(near)
        if mine.shape[0] < max(30, 2 * x.shape[1]):
            weights.append(share)
            parts.append(mode)
            continue
        one = _gaussian(mine, mode[1])
        slices = _slices(mine, one)
        weights.append(share * (0.25 if slices else 1.0))
        weights += [share * 0.75 / SLICES] * len(slices)
        parts += [(one[0], 1.1 * one[1]), *slices]
    return mixture_of(np.array(weights), parts)


def _gaussian(x: FloatArray, fallback: FloatArray) -> Mode:
    """Mean and covariance; the fewer the points, the more of `fallback` (its shape, at this cloud's size)."""
    n, d = x.shape
    mean = x.mean(axis=0)
    off = x - mean
    scale = float(np.median(np.sum(off**2, axis=0) / (n * np.diag(fallback))))
    prior = 0.25 * d
    return mean, (off.T @ off + prior * max(scale, 1e-6) * fallback) / (n + prior)


def _slices(x: FloatArray, one: Mode) -> list[Mode]:
    """Gaussians over overlapping slices across the direction in which the cloud is most curved; none where it is not.

    A curve shows in the third moments: of a coordinate across with the square of the one along.
    """
    n, d = x.shape
    if d < 2 or n < 20 * SLICES:
        return []
    lower = np.linalg.cholesky(one[1])
    white = np.linalg.solve(lower, (x - one[0]).T).T
    thin = white[:: max(1, n * d // 30_000)]
    third = (thin.T @ (thin[:, :, None] * thin[:, None, :]).reshape(-1, d * d)) / thin.shape[0]
    size, direction = np.linalg.eigh(third @ third.T)
    if size[-1] < max(0.1, 2.0 * (d + 2) ** 2 / thin.shape[0]):
        # no more than chance makes of a Gaussian
        return []
    order = np.argsort(white @ direction[:, -1])
    edges = np.linspace(0, n, SLICES + 1).astype(int)
    groups = [x[order[edges[max(s - 1, 0)] : edges[min(s + 2, SLICES)]]] for s in range(SLICES)]
    pooled = sum(np.cov(g.T, bias=True) for g in groups) / SLICES
    return [_gaussian(g, np.asarray(pooled)) for g in groups]
