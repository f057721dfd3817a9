"""Other modes of a density: many climbs at once from far starting points."""

from __future__ import annotations

import numpy as np

from pipelines.joint.sampling.gaussianity import LogDensity, quiet
from pipelines.joint.sampling.guide import slopes
from pipelines.joint.sampling.mixture import Mode, cholesky
from pipelines.results import FloatArray

FRACTIONS = np.array([1.0, 0.5, 0.2, 0.05, 0.01, 1e-3, 1e-4])
"""Of a step, all tried in one call."""

APART = 4.0
"""Standard deviations between modes that count as two."""

STEEP = 1.0
"""Squared standard deviations still to climb, above which a climb has not ended at a mode: cut short, or at a bound."""

BELOW = 12.0
"""A mode with this much less log probability (height and volume) is left out: e^-12 of the best."""


def find_modes(
    log_density: LogDensity, starts: FloatArray, covariance: FloatArray, rounds: int = 40, most: int = 4
) -> list[Mode]:
    """Modes that climbs from the rows of `starts` (s, k) end at, the most probable first, at most `most`.

    Quasi-Newton climbs (Broyden, Fletcher, Goldfarb, Shanno) with slopes by differences, all starts in each call:
    about s (k + 8) rows a round. covariance: (k, k) of a known mode, the first guess of the curvature.
    """
    lower = cholesky(covariance)

    def white(w: FloatArray) -> FloatArray:
        return quiet(log_density, w @ lower.T)

    w, value, slope, inverse = _climb(
        white, np.asarray(np.linalg.solve(lower, starts.T).T, np.float64), rounds
    )
    left = np.einsum("si,sij,sj->s", slope, inverse, slope)
    kept: list[tuple[float, FloatArray, FloatArray]] = []
    for index in np.argsort(-value):
        near = any(_distance(w[index], other, cov) < APART for _, other, cov in kept)
        if near or not np.isfinite(value[index]) or left[index] > STEEP or len(kept) > most:
            continue
        cov: FloatArray = np.asarray(np.linalg.inv(_precision(white, w[index])), np.float64)
        if slope[index] @ cov @ slope[index] > STEEP:
            continue
        kept.append((float(value[index] + 0.5 * np.linalg.slogdet(cov)[1]), w[index], cov))
    kept.sort(key=lambda one: -one[0])
    return [
        (lower @ place, lower @ cov @ lower.T)
        for mass, place, cov in kept[:most]
        if mass > kept[0][0] - BELOW
    ]


def _distance(here: FloatArray, mode: FloatArray, covariance: FloatArray) -> float:
    off = here - mode
    return float(np.sqrt(off @ np.linalg.solve(covariance, off)))


def _climb(
    density: LogDensity, w: FloatArray, rounds: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Climbs from w: ends (s, k), their values (s,), slopes (s, k) and inverse curvatures (s, k, k)."""
    s, k = w.shape
    inverse = np.tile(np.eye(k), (s, 1, 1))
    value = density(w)
    slope = slopes(density, w, value, 1e-4)
    for _ in range(rounds):
        step = np.einsum("sij,sj->si", inverse, slope)
        tried = w[:, None, :] + FRACTIONS[:, None] * step[:, None, :]
        found = density(tried.reshape(-1, k)).reshape(s, -1)
        best = np.argmax(found, axis=1)
        gain = found[np.arange(s), best] - value
        moved = gain > 0
        if not np.any(gain > 1e-3):
            break
        new = np.where(moved[:, None], tried[np.arange(s), best], w)
        value = np.where(moved, found[np.arange(s), best], value)
        after = slopes(density, new, value, 1e-4)
        inverse = _update(inverse, new - w, slope - after, moved)
        w, slope = new, after
    return w, value, slope, inverse


def _update(inverse: FloatArray, step: FloatArray, change: FloatArray, moved: np.ndarray) -> FloatArray:
    """BFGS on each; back to the start's where a climb is stuck or the density bends the wrong way."""
    product = np.einsum("si,si->s", step, change)
    good = moved & (product > 1e-10 * np.einsum("si,si->s", change, change))
    rho = np.where(good, 1 / np.where(good, product, 1.0), 0.0)
    turned = np.einsum("sij,sj->si", inverse, change)
    factor = rho * (1 + rho * np.einsum("si,si->s", change, turned))
    cross = np.einsum("s,si,sj->sij", rho, turned, step)
    new = inverse + np.einsum("s,si,sj->sij", factor, step, step) - cross - cross.transpose(0, 2, 1)
    k = inverse.shape[1]
    return np.where(good[:, None, None], new, np.where(moved[:, None, None], inverse, np.eye(k)))


def _precision(density: LogDensity, w: FloatArray, step: float = 1e-2) -> FloatArray:
    """(k, k) minus the curvature at w by differences, its small or negative directions lifted."""
    k = w.size
    first, second = np.triu_indices(k)
    eye = step * np.eye(k)
    both = eye[first] + eye[second]
    value = density(np.vstack([w, w + eye, w - eye, w + both, w - both]))
    centre, up, down = value[0], value[1 : k + 1], value[k + 1 : 2 * k + 1]
    pairs = value[2 * k + 1 :].reshape(2, -1)
    single = up + down
    with np.errstate(invalid="ignore"):
        entries = (pairs.sum(axis=0) - single[first] - single[second] + 2 * centre) / (2 * step**2)
    matrix = np.zeros((k, k))
    matrix[first, second] = matrix[second, first] = -np.where(np.isfinite(entries), entries, 0.0)
    size, basis = np.linalg.eigh(matrix)
    return np.asarray((basis * np.maximum(size, 0.05)) @ basis.T)
