"""All samples at once for y_i = sum_j phi_ij c_j(p): non-linear least squares, with noise on the inputs too, and the bound.

Where phi is measured with noise of known variance, its true values are unknowns as well, sample by sample. For models
that are linear in phi they fall out exactly: maximum likelihood is the least of

    sum_i sum_t (y_i - phi_i' c)² / (r_i + sum_j c_j² var(phi_ij)),

total least squares with the ratio of the noises known. The Cramér-Rao bound with the latent inputs as unknowns is that
of the same sum with the true phi.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.models.power_products import PowerProducts
from pipelines.results import FloatArray

MOST_STEPS = 60
SMALL_STEP = 1e-10


@dataclass(frozen=True)
class BatchFit:
    """values (n,) of the parameters; covariance (n, n) of their logarithms, from the scores' own scatter."""

    values: FloatArray
    covariance: FloatArray
    converged: bool

    @property
    def std(self) -> FloatArray:
        """Standard deviations of the parameters, (n,)."""
        return np.asarray(self.values * np.sqrt(np.diag(self.covariance)))


def _variances(c: FloatArray, noise: FloatArray, input_noise: FloatArray) -> FloatArray:
    return np.asarray(noise + input_noise @ (c * c))


def _objective(grams: FloatArray, c: FloatArray, variance: FloatArray) -> float:
    w = np.concatenate(([1.0], -c))
    return float(np.sum(np.einsum("a,mab,b->m", w, grams, w) / variance))


def fit_products(
    model: PowerProducts,
    phi: FloatArray,
    y: FloatArray,
    noise: FloatArray,
    start: FloatArray,
    input_noise: FloatArray | None = None,
) -> BatchFit:
    """Fit all samples. phi: (n, m, C); y: (n, m); noise: (m,) variances; start: (n_p,) above 0; input_noise: (m, C).

    Gauss-Newton in the logarithms of the parameters, which keeps them positive, with halved steps where one does not
    help. The data enter by their second moments, so that a step costs nothing. Raises ValueError where shapes do not fit.
    """
    rows, outputs, terms = phi.shape
    if y.shape != (rows, outputs) or noise.shape != (outputs,) or not (start > 0).all():
        raise ValueError("the arrays do not fit together")
    given = np.zeros((outputs, terms)) if input_noise is None else input_noise
    together = np.concatenate((y[:, :, None], phi), axis=2)
    grams = np.einsum("tma,tmb->mab", together, together)
    p = start.astype(np.float64)
    c = model.coefficients(p)
    best = _objective(grams, c, _variances(c, noise, given))
    converged = False
    for _ in range(MOST_STEPS):
        gradient, information = _slopes(model, p, grams, noise, given, rows)
        step = np.linalg.lstsq(information, -gradient, rcond=1e-14)[0]
        share = 1.0
        while True:
            trial = p * np.exp(np.clip(share * step, -1.0, 1.0))
            c = model.coefficients(trial)
            found = _objective(grams, c, _variances(c, noise, given))
            if found <= best or share < 1e-6:
                break
            share *= 0.5
        improved = found <= best
        if improved:
            p, best = trial, found
        if not improved or np.max(np.abs(share * step)) < SMALL_STEP:
            converged = np.max(np.abs(step)) < 1e-5
            break
    return BatchFit(p, _sandwich(model, p, phi, y, noise, given), bool(converged))


def _slopes(
    model: PowerProducts, p: FloatArray, grams: FloatArray, noise: FloatArray, given: FloatArray, rows: int
) -> tuple[FloatArray, FloatArray]:
    """Half the gradient of the objective and its Gauss-Newton matrix, by ln p."""
    c, slope = model.coefficients(p), model.slopes(p)
    variance = _variances(c, noise, given)
    w = np.concatenate(([1.0], -c))
    along = np.einsum("mab,b->ma", grams, w)
    squares = along @ w
    change = 2 * (given * c) @ slope
    gradient = -(along[:, 1:] @ slope) / variance[:, None] - 0.5 * (squares / variance**2)[:, None] * change
    return gradient.sum(axis=0), _information(slope, grams[:, 1:, 1:], variance, rows * given)


def _information(
    slope: FloatArray, moments: FloatArray, variance: FloatArray, excess: FloatArray
) -> FloatArray:
    """What the samples tell of ln p, (n_p, n_p). excess: (m, C), what noise added to the moments' diagonals."""
    clean = moments - excess[:, :, None] * np.eye(moments.shape[1])
    return np.asarray(np.einsum("ca,mcd,db,m->ab", slope, clean, slope, 1 / variance))


def _sandwich(
    model: PowerProducts, p: FloatArray, phi: FloatArray, y: FloatArray, noise: FloatArray, given: FloatArray
) -> FloatArray:
    """Covariance of ln p from the scatter of each sample's score: right for the noise that is there."""
    c, slope = model.coefficients(p), model.slopes(p)
    variance = _variances(c, noise, given)
    error = y - phi @ c
    change = 2 * (given * c) @ slope
    scores = np.einsum("tm,tma->ta", error / variance, phi @ slope)
    scores += np.einsum("tm,ma->ta", 0.5 * (error / variance) ** 2, change)
    scores -= scores.mean(axis=0)
    moments = np.einsum("tma,tmb->mab", phi, phi)
    inverse = np.linalg.pinv(_information(slope, moments, variance, len(y) * given))
    return np.asarray(inverse @ (scores.T @ scores) @ inverse)


def cramer_rao(
    model: PowerProducts,
    phi: FloatArray,
    values: FloatArray,
    noise: FloatArray,
    input_noise: FloatArray | None = None,
) -> FloatArray:
    """Smallest standard deviations of the parameters that an unbiased estimate can have, (n_p,).

    phi: (n, m, C) without noise; values: the true parameters. input_noise: (m, C); the true inputs then count as
    unknowns.
    """
    given = np.zeros(phi.shape[1:]) if input_noise is None else input_noise
    variance = _variances(model.coefficients(values), noise, given)
    moments = np.einsum("tma,tmb->mab", phi, phi)
    information = _information(model.slopes(values), moments, variance, np.zeros_like(given))
    return np.asarray(values * np.sqrt(np.diag(np.linalg.inv(information))))
