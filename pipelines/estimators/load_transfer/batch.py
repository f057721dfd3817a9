"""All four strut forces of a drive on the motion that loads them, at once: robust least squares with honest spread.

MLTM's terms (118)-(121), with what it lumps set free: each strut's static load, the body's own inertias instead of four
point masses, arms for braking and driving of their own, jacking (squares), columns for small delays, and the part of a
horizontal force's moment that goes with the vertical acceleration (all of it in the equations, which write A_z where a
leaning body has it on its lean alone; a fit without it took it for roll acceleration, 2 % of the roll arm). Total, moment
about the front axle and moment about the middle are Newton's and Euler's balances: dry friction and warped springs move
force round the four struts within them, and drop out of mass and CG position.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipelines.estimators.load_transfer.data import StrutData
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray

BLOCK_S = 8.0
HUBER = 2.5
ROUNDS = 4
TOGETHER = 25.0
"""Rows that are taken to err alike where what was known before is weighed against them."""
COLUMNS: tuple[str, ...] = (
    "static", "heave", "roll_acceleration", "pitch_acceleration", "along", "braking", "across", "along_rate", "across_rate",
    "across_square", "yaw_acceleration", "drag", "across_heave", "along_heave",
)  # fmt: skip
STATIC, ALONG, BRAKING, ACROSS, DRAG = (
    COLUMNS.index(n) for n in ("static", "along", "braking", "across", "drag")
)

LOOSE = np.array([1e5, 4e3, 4e3, 4e3, 1e3, 300.0, 2e3, 60.0, 60.0, 40.0, 2e3, 1.0, 200.0, 100.0])
"""Standard deviation of each column's coefficient before the log, in N over the column's unit: only so wide that a column
which the drive does not excite cannot run away."""


@dataclass(frozen=True)
class BatchFit:
    """coefficients (k, 4) of COLUMNS a strut; covariance (4k, 4k), row-major by column then strut; blocks: how many
    independent stretches the spread is from. residual (n, 4) N. sums: (b, k, k) and (b, k, 4) of the blocks for tracks."""

    coefficients: FloatArray
    covariance: FloatArray
    blocks: int
    residual: FloatArray
    fitted: FloatArray
    weights: FloatArray
    products: FloatArray
    targets: FloatArray
    edges: np.ndarray

    def combine(self, lever: FloatArray, column: int) -> tuple[float, float]:
        """Value and standard deviation of sum(lever (4,) x coefficient of one column)."""
        row = np.zeros_like(self.coefficients)
        row[column] = lever
        flat = row.ravel()
        variance = float(flat @ self.covariance @ flat)
        return float(flat @ self.coefficients.ravel()), math.sqrt(max(variance, 0.0))


def _derivative(values: FloatArray, data: StrutData) -> FloatArray:
    out = np.gradient(values) * data.rate_hz if len(values) > 1 else np.zeros(len(values))
    edge = data.starts > 0.5
    out[edge] = 0.0
    out[:-1][edge[1:]] = 0.0
    return np.asarray(out)


def table(data: StrutData) -> FloatArray:
    """(n, k) columns of the regression."""
    speed2 = np.zeros(data.size) if data.speed is None else data.speed**2
    heave = data.vertical - GRAVITY
    return np.column_stack((
        np.ones(data.size), heave, data.roll_acceleration, data.pitch_acceleration, data.along,
        data.along * data.braking, data.across, _derivative(data.along, data), _derivative(data.across, data),
        data.across**2, _derivative(data.yaw_rate, data), speed2, data.across * heave, data.along * heave,
    ))  # fmt: skip


def _weights(residual: FloatArray) -> FloatArray:
    """(n,) Huber weights by the residuals' joint size (median scale a strut)."""
    scale = 1.4826 * np.median(np.abs(residual - np.median(residual, axis=0)), axis=0)
    size = np.sqrt(np.mean((residual / np.maximum(scale, 1e-9)) ** 2, axis=1))
    return np.asarray(np.minimum(1.0, HUBER / np.maximum(size, 1e-9)))


def _blocks(data: StrutData) -> np.ndarray:
    """First rows of stretches of BLOCK_S, cut at the runs' ends as well."""
    step = max(1, round(BLOCK_S * data.rate_hz))
    begin = [*np.flatnonzero(data.starts > 0.5), data.size]
    edges = [np.arange(i, max(i + 1, j - step // 2), step) for i, j in pairwise(begin)]
    return np.concatenate(edges)


def _rows_together(residual: FloatArray) -> float:
    """How many rows err as one: the residuals' correlation summed up to where it is first nought or less; 1 where none."""
    n = len(residual)
    power = np.abs(np.fft.rfft(residual - residual.mean(axis=0), 2 * n, axis=0)) ** 2
    correlation = np.fft.irfft(power.sum(axis=1))[:n]
    ends = np.flatnonzero(correlation <= 0)
    past = int(ends[0]) if len(ends) else n
    return float(1 + 2 * correlation[1:past].sum() / max(correlation[0], 1e-300))


def _no_less(spread: FloatArray, floor: FloatArray) -> FloatArray:
    """The covariance `spread`, raised in every direction in which it is below `floor` (positive definite)."""
    root = np.linalg.cholesky(floor)
    inner = np.linalg.solve(root, np.linalg.solve(root, spread).T)
    values, vectors = np.linalg.eigh(0.5 * (inner + inner.T))
    half = root @ vectors
    return np.asarray(half * np.maximum(values, 1.0) @ half.T)


def _score_spread(
    scores: FloatArray, residual: FloatArray, edges: np.ndarray, before: FloatArray
) -> FloatArray:
    """(4k, 4k) covariance of the scores' sum. scores (n, 4k) by row; before (4k, 4k): of what was known before the log.

    Stretches see what wanders for seconds (friction, a road's bank), but a few of them say nothing of most directions:
    each row for itself, as many as err alike taken as one, says what is there at the least.
    """
    n, columns, blocks = len(scores), scores.shape[1] // 4, len(edges)
    alike = _rows_together(residual)
    left = max(n / alike - columns, 1.0)
    rows = scores.T @ scores * (n / left)
    stretches = np.add.reduceat(scores, edges, axis=0)
    between = stretches.T @ stretches * (blocks / max(blocks - 1, 1))
    return _no_less(between + before, rows + before)


def fit(data: StrutData) -> BatchFit:
    """Least squares of all four forces with Huber weights; covariance from the scatter of rows and of stretches (sandwich)."""
    x, y = table(data), data.forces
    k, edges = x.shape[1], _blocks(data)
    weights = np.ones(data.size)
    noise = 50.0
    beta: FloatArray = np.zeros((k, 4))
    curvature: FloatArray = np.eye(k)
    for _ in range(ROUNDS):
        ridge = np.diag(noise**2 * TOGETHER / LOOSE**2)
        scaled = x * weights[:, None]
        curvature = scaled.T @ x + ridge
        beta = np.asarray(np.linalg.solve(curvature, scaled.T @ y), dtype=np.float64)
        residual = y - x @ beta
        weights = _weights(residual)
        noise = float(np.sqrt(np.mean(weights[:, None] * residual**2)))
    scores = ((weights[:, None] * x)[:, :, None] * residual[:, None, :]).reshape(data.size, 4 * k)
    # of a column that hardly moves, what was known before is what is known
    bread = np.kron(np.linalg.inv(curvature), np.eye(4))
    before = np.asarray(np.kron(ridge * (TOGETHER * noise**2), np.eye(4)), dtype=np.float64)
    covariance = bread @ _score_spread(scores, residual, edges, before) @ bread
    products = np.add.reduceat((weights[:, None] * x)[:, :, None] * x[:, None, :], edges, axis=0)
    targets = np.add.reduceat((weights[:, None] * x)[:, :, None] * y[:, None, :], edges, axis=0)
    return BatchFit(beta, covariance, len(edges), residual, x @ beta, weights, products, targets, edges)
