"""Generalised least squares with Huber weights and coloured residuals: the engine of the companion to Wu et al.

Two forms of the same balance y = L F_r (or its counterpart with the front axle), all slow parts of it known to be
M_h f + M_c g with f the specific force along the road, M_h = m h and M_c = m a (both with small known parts):

- against the speed: v + g sum(sin) dt = (1/M_h) sum(y) dt - (M_c/M_h) g sum(cos) dt, residual random walk plus white;
- against the accelerometer: y = M_h f + M_c g, residual first-order autoregression plus white.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from pipelines.filters.whiten import deletion_residuals, whiten
from pipelines.results import FloatArray

PASSES = 12
SETTLED = 1e-6
MOST_HUBER = 3.0
MOST_RATIO = 1e8
TAKEN = 4
"""Figures that the rows themselves have to tell: two moments, and the residual's colour."""


@dataclass(frozen=True)
class Colour:
    """Noise of the residual: d[k] = phi d[k-1] + w plus white n, var(w) = ratio var(n). scale2: variance of n.

    Where scale2 is 1 and `given` is true, `ratio` and the white variance are known beforehand (`white`).
    """

    phi: float
    ratio: float
    white: float = 1.0
    given: bool = False


@dataclass(frozen=True)
class Fit:
    """beta (p,), covariance (p, p) as the noise model says it; wide_covariance: as the scores' own correlation says it.

    residual (n,): y - X beta. weights (n,): Huber weights. innovations (n,): normalised. inflation: root of the mean
    ratio of the two covariances. lag_one: correlation of neighbouring innovations.
    """

    beta: FloatArray
    covariance: FloatArray
    wide_covariance: FloatArray
    colour: Colour
    scale: float
    residual: FloatArray
    weights: FloatArray
    innovations: FloatArray
    lag_one: float


def few_rows(rows: int) -> float:
    """Factor on a variance that was found from the residual of so many rows: Student's law has that much wider a 95 % interval."""
    return float(stdtrit(max(rows - TAKEN, 1), 0.975) / 1.959964) ** 2


def _solve(
    white: FloatArray, prior_mean: FloatArray, prior_precision: FloatArray, scale2: float
) -> tuple[FloatArray, FloatArray]:
    """beta and the information matrix (in units of 1/scale2) of whitened [y, X]."""
    y, x = white[:, 0], white[:, 1:]
    information = x.T @ x + np.diag(prior_precision) * scale2
    target = x.T @ y + prior_precision * scale2 * prior_mean
    # columns differ by orders of magnitude
    size = np.sqrt(np.diag(information))
    size[size == 0] = 1.0
    beta = np.linalg.solve(information / np.outer(size, size), target / size) / size
    return np.asarray(beta), np.asarray(information)


def _inverse(information: FloatArray) -> FloatArray:
    size = np.sqrt(np.diag(information))
    size = np.where(size > 0, size, 1.0)
    return np.asarray(np.linalg.inv(information / np.outer(size, size)) / np.outer(size, size))


def _one(
    columns: FloatArray, starts: FloatArray, colour: Colour, weights: FloatArray,
    prior: tuple[FloatArray, FloatArray], scale2: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:  # fmt: skip
    """Whiten and solve: beta, information, whitened columns, innovations, log-determinant."""
    variance = colour.white / weights
    white, logdet = whiten(columns, starts, colour.phi, colour.ratio * colour.white, variance)
    beta, information = _solve(white, prior[0], prior[1], scale2)
    innovation = white[:, 0] - white[:, 1:] @ beta
    return beta, information, white, innovation, logdet


def _likelihood(
    columns: FloatArray, starts: FloatArray, colour: Colour, weights: FloatArray,
    prior: tuple[FloatArray, FloatArray], scale2: float,
) -> float:  # fmt: skip
    """Minus twice the profile log-likelihood (the white variance profiled out)."""
    *_, innovation, logdet = _one(columns, starts, colour, weights, prior, scale2)
    dof = max(len(innovation) - columns.shape[1] + 1, 1)
    return float(dof * math.log(max(float(innovation @ innovation) / dof, 1e-300)) + logdet)


def _choose_colour(
    columns: FloatArray, starts: FloatArray, colour: Colour, weights: FloatArray,
    prior: tuple[FloatArray, FloatArray], scale2: float,
) -> Colour:  # fmt: skip
    """The colour of highest likelihood: the ratio, and phi too where it is below one. Coarse, then fine."""
    best, lowest = colour, math.inf
    phis = (1.0,) if colour.phi >= 1.0 else (0.5, 0.8, 0.9, 0.95, 0.98, 0.99)
    for phi in phis:
        for power in np.arange(-10.0, 5.0, 2.0):
            trial = replace(colour, phi=phi, ratio=10.0**power)
            value = _likelihood(columns, starts, trial, weights, prior, scale2)
            if value < lowest:
                best, lowest = trial, value
    for step in (1.0, 0.5, 0.25):
        for factor in (10**-step, 10**step):
            for odds in (1.0,) if colour.phi >= 1.0 else (0.7, 1.0, 1.4):
                phi = 1.0 if colour.phi >= 1.0 else min(1 - (1 - best.phi) * odds, 0.998)
                trial = replace(colour, phi=phi, ratio=best.ratio * factor)
                value = _likelihood(columns, starts, trial, weights, prior, scale2)
                if value < lowest:
                    best, lowest = trial, value
    return best


def _scores_covariance(
    white: FloatArray, innovation: FloatArray, inverse: FloatArray, lag: int
) -> FloatArray:
    """Covariance of beta from the scores' scatter, with correlation up to `lag` rows (Bartlett weights)."""
    scores = white[:, 1:] * innovation[:, None]
    n = len(scores)
    meat = scores.T @ scores
    if lag > 0:
        # Bartlett's sum equals the mean square of moving sums over lag + 1 rows
        ahead = np.vstack((np.zeros((1, scores.shape[1])), np.cumsum(scores, axis=0)))
        width = min(lag + 1, n)
        padded = np.vstack((np.repeat(ahead[:1], width - 1, 0), ahead, np.repeat(ahead[-1:], width - 1, 0)))
        moving = padded[width:] - padded[:-width]
        meat = moving.T @ moving / width
    return np.asarray(inverse @ meat @ inverse)


def fit(
    columns: FloatArray, starts: FloatArray, colour: Colour, *, huber: float, lag_rows: int,
    prior_mean: FloatArray, prior_precision: FloatArray, least_process: float = 0.0,
) -> Fit:  # fmt: skip
    """Fit [y, X] (n, 1 + p) with Huber weights on each row's deletion residual.

    huber: gamma in standard deviations (inf: plain generalised least squares). prior_mean, prior_precision (p,): of
    beta, precision 0 = nothing known. lag_rows: rows over which innovations may hang together. colour.given: the
    noise is known, else its ratio (and phi below one) is found by likelihood, twice. least_process: variance of w that
    is known to be there (the load sensor's own noise): few data may hide it from the likelihood.
    """
    n = len(columns)
    weights = np.ones(n)
    prior = (prior_mean, prior_precision)
    scale2 = 1.0
    chosen = colour
    beta = np.zeros(columns.shape[1] - 1)
    for number in range(PASSES):
        if not colour.given and number in (0, 2):
            chosen = _choose_colour(columns, starts, chosen, weights, prior, scale2)
        before = beta
        if least_process > 0 and number > 0 and not colour.given:
            chosen = replace(
                chosen, ratio=min(max(chosen.ratio, least_process / max(scale2, 1e-300)), MOST_RATIO)
            )
        beta, information, white, innovation, _ = _one(columns, starts, chosen, weights, prior, scale2)
        residual = columns[:, 0] - columns[:, 1:] @ beta
        outlying = deletion_residuals(
            residual, starts, chosen.phi, chosen.ratio * chosen.white, np.full(n, chosen.white)
        )
        spread = 1.0 if colour.given else _robust(outlying)
        scale2 = 1.0 if colour.given else spread**2
        if math.isinf(huber):
            if not colour.given:
                scale2 = float(innovation @ innovation) / max(n - len(beta), 1)
        else:
            size = np.abs(outlying) / max(spread, 1e-300)
            weights = np.where(size > huber, huber / np.maximum(size, huber), 1.0)
        moved = np.max(
            np.abs(beta - before) / np.maximum(np.sqrt(np.diag(_inverse(information)) * scale2), 1e-300)
        )
        if number > 2 and moved < SETTLED * 1e3:
            break
    grow = 1.0 if math.isinf(huber) else _huber_growth(outlying / max(spread, 1e-300), weights)
    return _finish(white, innovation, information, chosen, beta, residual, weights, lag_rows, grow)


def _huber_growth(size: FloatArray, weights: FloatArray) -> float:
    """How much more Huber's estimate varies than its weights say: sqrt(E psi²) / E psi' over sqrt(E w u² / E w)."""
    whole = max(float(np.mean(weights >= 1.0)), 0.1)
    says = math.sqrt(float(np.mean(weights * size**2)) / float(np.mean(weights)))
    varies = math.sqrt(float(np.mean((weights * size) ** 2))) / whole
    return min(max(varies / says, 1.0), MOST_HUBER) if says > 0 else 1.0


def _robust(values: FloatArray) -> float:
    """Standard deviation by the median absolute deviation."""
    found = float(np.median(np.abs(values - np.median(values)))) * 1.4826
    return found if found > 0 else float(np.std(values)) or 1.0


def _finish(
    white: FloatArray, innovation: FloatArray, information: FloatArray, colour: Colour, beta: FloatArray,
    residual: FloatArray, weights: FloatArray, lag_rows: int, huber_growth: float,
) -> Fit:  # fmt: skip
    inverse = _inverse(information)
    dof = max(len(innovation) - len(beta), 1)
    scale2 = float(innovation @ innovation) / dof
    wide = _scores_covariance(white, innovation, inverse, lag_rows)
    short = _scores_covariance(white, innovation, inverse, 0)
    covariance = inverse * scale2
    # the scores' scatter is itself uncertain: what chance alone adds to it is taken off before it widens
    chance = math.sqrt(4 / 3 * (lag_rows + 1) / len(innovation))
    ratio = np.maximum(np.diag(wide), np.diag(short)) / np.diag(covariance)
    grow = np.sqrt(np.maximum(ratio - min(chance, 0.5), 1.0)) * huber_growth
    a, b = innovation[1:], innovation[:-1]
    product = math.sqrt(float(a @ a) * float(b @ b))
    lag_one = float(a @ b) / product if product > 0 else 0.0
    return Fit(
        beta, covariance, covariance * np.outer(grow, grow), colour, math.sqrt(scale2), residual, weights,
        innovation, lag_one,
    )  # fmt: skip
