"""Mixtures of Gaussians: where sampling starts, and the ellipses along which its points move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray

Mode = tuple[FloatArray, FloatArray]
"""(k,) place and (k, k) covariance of a Gaussian approximation."""

LOG_2PI = float(np.log(2 * np.pi))


@dataclass(frozen=True)
class Mixture:
    """weight: (j,), sum 1. mean: (j, d). root: (j, d, d) lower triangular, covariance = root root'. back: its inverse."""

    weight: FloatArray
    mean: FloatArray
    root: FloatArray
    back: FloatArray

    def each(self, x: FloatArray) -> FloatArray:
        """(n, j) log of weight times density of each part at the rows of x (n, d)."""
        parts, d = self.mean.shape
        flat = self.back.transpose(2, 0, 1).reshape(d, parts * d)
        white = (x @ flat).reshape(-1, parts, d) - np.einsum("jab,jb->ja", self.back, self.mean)
        volume = np.sum(np.log(np.diagonal(self.root, axis1=1, axis2=2)), axis=1)
        shift = np.log(self.weight) - volume - 0.5 * LOG_2PI * d
        return np.asarray(shift - 0.5 * np.einsum("njd,njd->nj", white, white))

    def log(self, x: FloatArray) -> FloatArray:
        """(n,) log density."""
        return log_sum(self.each(x))

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """(count, d)."""
        part = rng.choice(self.weight.size, count, p=self.weight)
        return self.mean[part] + self.spread(rng.standard_normal((count, self.mean.shape[1])), part)

    def spread(self, white: FloatArray, part: np.ndarray) -> FloatArray:
        """(n, d) standard normal rows to the covariance of each row's part."""
        return _by_part(white, part, self.root)

    def whiten(self, x: FloatArray, part: np.ndarray) -> FloatArray:
        """(n, d) the reverse, after taking the part's mean off."""
        return _by_part(x - self.mean[part], part, self.back)


def pick(each: FloatArray, rng: np.random.Generator) -> np.ndarray:
    """(n,) a part for each row of `Mixture.each`, drawn by its share of the density there."""
    return np.asarray(np.argmax(each + rng.gumbel(size=each.shape), axis=1))


def _by_part(rows: FloatArray, part: np.ndarray, matrices: FloatArray) -> FloatArray:
    out = np.empty_like(rows)
    for index, matrix in enumerate(matrices):
        mine = part == index
        out[mine] = rows[mine] @ matrix.T
    return np.asarray(out)


def log_sum(each: FloatArray) -> FloatArray:
    """(n,) log of the sum of exp over the columns of (n, j)."""
    top = np.max(each, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        total = np.log(np.sum(np.exp(each - top[:, None]), axis=1))
    return np.asarray(np.where(np.isfinite(top), top + total, top))


def mixture_of(weight: FloatArray, parts: Sequence[Mode]) -> Mixture:
    """From weights (j,), of any sum, and (mean, covariance) pairs."""
    mean = np.array([m for m, _ in parts])
    root = np.array([cholesky(c) for _, c in parts])
    back = np.array([np.linalg.solve(r, np.eye(r.shape[0])) for r in root])
    return Mixture(weight / np.sum(weight), mean, root, back)


def cholesky(covariance: FloatArray) -> FloatArray:
    """Lower root; a covariance that rounding made indefinite is lifted by as little as needed."""
    lift = 0.0
    size = float(np.mean(np.diag(covariance)))
    for _ in range(12):
        try:
            return np.asarray(np.linalg.cholesky(covariance + lift * np.eye(covariance.shape[0])), np.float64)
        except np.linalg.LinAlgError:
            lift = max(10 * lift, 1e-14 * size)
    raise np.linalg.LinAlgError("a covariance is not positive definite")


def tempered(mode: Mode, power: float) -> Mode:
    """What a mode becomes when its likelihood is raised to a power, were the likelihood Gaussian and the prior N(0, I).

    The posterior's precision is I + H with the likelihood's H, and its linear term (I + H) mode; power < 1 leaves
    I + power H and power times the linear term, so that directions that nothing was learned of stay as wide as the prior.
    """
    place, covariance = mode
    eye = np.eye(place.size)
    precision = np.linalg.solve(covariance, eye)
    flat = np.linalg.solve((1 - power) * eye + power * precision, eye)
    return flat @ (power * precision @ place), 0.5 * (flat + flat.T)
