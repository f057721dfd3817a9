"""Gaussian process regression: one length scale a dimension, hyperparameters where the marginal likelihood is largest.

Rasmussen & Williams, Gaussian Processes for Machine Learning, (2.25)-(2.26), (2.30), (5.9), with a constant mean and the
signal's variance at their best values for given length scales (they are known in closed form).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray

JITTER = 1e-8
"""Least noise, as a share of the signal's variance: keeps the covariance's root sound."""

SCALES = (0.02, 20.0)
NOISES = (JITTER, 1.0)
"""Where length scales (of inputs on about 0..1) and the noise's share are looked for."""


@dataclass(frozen=True)
class Hyper:
    """scales: (d,) length scales. noise: variance as a share of the signal's. matern: 5/2 instead of squared exponential."""

    scales: FloatArray
    noise: float
    matern: bool = False


@dataclass(frozen=True)
class GaussianProcess:
    """A process given data. points: (n, d). root: (n, n) lower root of the correlation with noise. solved: (n,) its inverse
    times the centred values. mean, variance: of the process. log_likelihood: of the values."""

    points: FloatArray
    hyper: Hyper
    root: FloatArray
    solved: FloatArray
    mean: float
    variance: float
    log_likelihood: float

    def predict(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation (m,) of the noise-free function at points (m, d)."""
        from scipy.linalg import solve_triangular

        across, _ = correlation(points, self.points, self.hyper)
        half = solve_triangular(self.root, across.T, lower=True)
        left = np.maximum(1.0 - (half**2).sum(axis=0), 0.0)
        return self.mean + across @ self.solved, np.sqrt(self.variance * left)

    def means(self, points: FloatArray) -> FloatArray:
        """The mean alone, (m,): much cheaper."""
        return np.asarray(self.mean + correlation(points, self.points, self.hyper)[0] @ self.solved)


def correlation(a: FloatArray, b: FloatArray, hyper: Hyper) -> tuple[FloatArray, FloatArray]:
    """Correlation (m, n) of points a (m, d) and b (n, d), and its derivative by the logarithm of a length scale divided by
    that dimension's scaled squared distance."""
    scaled_a, scaled_b = a / hyper.scales, b / hyper.scales
    squares = (scaled_a**2).sum(axis=1)[:, None] + (scaled_b**2).sum(axis=1) - 2 * scaled_a @ scaled_b.T
    squares = np.maximum(squares, 0.0)
    if not hyper.matern:
        value = np.exp(-0.5 * squares)
        return value, value
    distance = np.sqrt(5 * squares)
    fall = np.exp(-distance)
    return (1 + distance + 5 / 3 * squares) * fall, 5 / 3 * (1 + distance) * fall


def condition(points: FloatArray, values: FloatArray, hyper: Hyper) -> GaussianProcess:
    """The process with these hyperparameters given values (n,) at points (n, d). Raises numpy's LinAlgError where singular."""
    from scipy.linalg import cho_solve

    n = len(values)
    matrix = correlation(points, points, hyper)[0] + max(hyper.noise, JITTER) * np.eye(n)
    root = np.asarray(np.linalg.cholesky(matrix), dtype=np.float64)
    both = cho_solve((root, True), np.column_stack((values, np.ones(n))))
    mean = float(both[:, 0].sum() / both[:, 1].sum())
    solved = both[:, 0] - mean * both[:, 1]
    variance = max(float((values - mean) @ solved) / n, 1e-12 * max(1.0, float(np.abs(values).max()) ** 2))
    log_likelihood = -0.5 * n * (np.log(2 * np.pi * variance) + 1.0) - float(np.log(np.diag(root)).sum())
    return GaussianProcess(points, hyper, root, solved, mean, variance, log_likelihood)


def _slope(process: GaussianProcess) -> FloatArray:
    """(d + 1,) derivative of the log likelihood by the logarithms of length scales and noise."""
    from scipy.linalg import cho_solve

    n = len(process.solved)
    inverse = cho_solve((process.root, True), np.eye(n))
    weight = np.outer(process.solved, process.solved) / process.variance - inverse
    _, change = correlation(process.points, process.points, process.hyper)
    inner = weight * change
    slopes = []
    for j, scale in enumerate(process.hyper.scales):
        column = process.points[:, j] / scale
        slopes.append(0.5 * float((inner * (column[:, None] - column) ** 2).sum()))
    slopes.append(0.5 * process.hyper.noise * float(np.trace(weight)))
    return np.array(slopes)


def fit(
    points: FloatArray, values: FloatArray, first: Hyper, tries: int, rng: np.random.Generator
) -> GaussianProcess:
    """The process with hyperparameters of the largest marginal likelihood, looked for from `first` and `tries` draws.

    points: (n, d), scaled to about 0..1. With fewer than four points the hyperparameters stay `first`.
    """
    best = condition(points, values, first)
    if len(values) < 4:
        return best
    from scipy.optimize import minimize

    d = points.shape[1]
    low, high = np.log(np.array([SCALES] * d + [NOISES])).T
    bounds = list(zip(low.tolist(), high.tolist(), strict=True))

    def cost(z: FloatArray) -> tuple[float, FloatArray]:
        process = condition(points, values, Hyper(np.exp(z[:d]), float(np.exp(z[d])), first.matern))
        return -process.log_likelihood, -_slope(process)

    starts = [np.log(np.append(first.scales, max(first.noise, JITTER)))]
    starts += [
        np.append(rng.uniform(np.log(0.1), np.log(2.0), d), rng.uniform(np.log(1e-6), np.log(0.1)))
        for _ in range(tries)
    ]
    for start in starts:
        found = minimize(
            cost,
            np.asarray(np.clip(start, low, high), dtype=np.float64),
            jac=True,
            bounds=bounds,
            method="L-BFGS-B",
            options={"maxiter": 40},
        )
        process = condition(
            points, values, Hyper(np.exp(found.x[:d]), float(np.exp(found.x[d])), first.matern)
        )
        if process.log_likelihood > best.log_likelihood:
            best = process
    return best
