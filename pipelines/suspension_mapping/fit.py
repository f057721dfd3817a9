"""Robust least squares with what is known beforehand, for one wheel and one form, and its errors on what it has not seen.

Plain (not generalised) least squares on purpose: the residual is the model's own error, not noise. Whitening it takes the
slow parts of the drive out of the fit, on which load transfer stands, and made the error on other drives up to four times as
large. The residual's correlation goes where it belongs, into the covariance: rows that hang together count as fewer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.models.suspension_map import GRAVITY
from pipelines.results import FloatArray

HUBER = 2.5
PASSES = 3
BLOCK_S = 5.0
UNSPRUNG_SHARE = 0.09
"""Mass of a wheel over what it carries, where the vehicle file is silent."""
STATIC_SAG_M = 0.15
"""Deflection by which a usual spring carries its load: the scale of spring rates where the vehicle file is silent."""


@dataclass(frozen=True)
class Known:
    """What is known of a wheel before the drive: (value, std) of its mass and of its spring's rate; None = usual ones."""

    unsprung_kg: tuple[float, float] | None = None
    spring_npm: tuple[float, float] | None = None

    def weight_n(self, force_n: float) -> float:
        """Weight of the wheel, N; a usual share of its mean force where nothing is known."""
        return UNSPRUNG_SHARE * force_n if self.unsprung_kg is None else self.unsprung_kg[0] * GRAVITY


def prior_of(
    names: Sequence[str], force_n: float, known: Known, springs: bool
) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation of each coefficient, (p,) each. force_n: mean force of the wheel.

    A strut that is calibrated as "force on the body" has a coefficient of 1: one drive at one load cannot tell it from the
    load transfer, and what it gets wrong there scales another load. What the links carry is less than a third of a wheel's
    part of the load transfer; friction is some per cent of the load.
    """
    usual = (UNSPRUNG_SHARE * force_n / GRAVITY, 0.5 * UNSPRUNG_SHARE * force_n / GRAVITY)
    mass = known.unsprung_kg or usual
    rate = known.spring_npm or (force_n / STATIC_SAG_M, 0.5 * force_n / STATIC_SAG_M)
    weight = mass[0] * GRAVITY
    if springs:
        # the preload carries the empty vehicle
        one, deflection = (force_n, force_n), rate
    else:
        one, deflection = (weight, 0.02 * force_n + mass[1] * GRAVITY), (0.0, 0.05 * rate[0])
    table: dict[str, tuple[float, float]] = {
        "one": one,
        "carried": (1.0, 0.004),
        "hub": (mass[0], max(mass[1], 0.1 * mass[0])),
        "weight": (mass[0], max(mass[1], 0.1 * mass[0])),
        "deflection": deflection,
        "bar": (0.0, 0.5 * rate[0]),
        "stiffening": (0.0, 0.03 * rate[0] / 0.05**2),
        "drag": (0.0, 0.02 * force_n / 900.0),
        "friction_in": (0.0, 0.05 * force_n),
        "friction_out": (0.0, 0.05 * force_n),
        "damping_in": (0.0, (0.5 if springs else 0.1) * force_n / 0.5),
        "damping_out": (0.0, (1.0 if springs else 0.1) * force_n / 0.5),
    }
    both = np.array([table.get(name, (0.0, 0.3)) for name in names])
    return both[:, 0], np.maximum(both[:, 1], 1e-9)


@dataclass(frozen=True)
class Fitted:
    """coefficients (p,), covariance (p, p); residual (n,) = measured - mapped; weights (n,): Huber's; scale2: N² of a row's
    share in the information (variance times the rows that hang together)."""

    coefficients: FloatArray
    covariance: FloatArray
    residual: FloatArray
    weights: FloatArray
    scale2: float


def together(residual: FloatArray, starts: FloatArray, rate_hz: float) -> float:
    """Rows that hang together: mean square of a block's sum over its rows and variance; 1 to a block's rows."""
    rows = max(round(BLOCK_S * rate_hz), 1)
    block = np.cumsum(starts > 0.5) * (len(residual) // rows + 2) + np.arange(len(residual)) // rows
    edges = np.flatnonzero(np.diff(block, prepend=-1))
    sums = np.add.reduceat(residual, edges)
    power = float(residual @ residual)
    return min(max(float(sums @ sums) / power, 1.0), float(rows)) if power > 0 else 1.0


def _solve(
    gram: FloatArray, target: FloatArray, prior: tuple[FloatArray, FloatArray], scale2: float
) -> tuple[FloatArray, FloatArray]:
    """Coefficients and covariance from A'WA and A'W(y - A mean); in units of the prior's standard deviations inside."""
    mean, std = prior
    inner = gram * np.outer(std, std) / scale2 + np.eye(len(mean))
    inverse = np.linalg.inv(inner)
    inverse = 0.5 * (inverse + inverse.T)
    return mean + std * (inverse @ (std * target / scale2)), inverse * np.outer(std, std)


def fit(
    matrix: FloatArray,
    measured: FloatArray,
    prior: tuple[FloatArray, FloatArray],
    starts: FloatArray,
    rate_hz: float,
) -> Fitted:
    """Huber's least squares with a prior. matrix (n, p), measured (n,), starts (n,): 1 where a stretch begins."""
    beyond = measured - matrix @ prior[0]
    weights = np.ones(len(measured))
    scale2 = max(float(np.var(beyond)), 1e-6)
    for _ in range(PASSES):
        weighted = matrix * weights[:, None]
        found, covariance = _solve(weighted.T @ matrix, weighted.T @ beyond, prior, scale2)
        residual = measured - matrix @ found
        spread = max(1.4826 * float(np.median(np.abs(residual))), 1e-3)
        size = np.abs(residual) / spread
        weights = np.where(size > HUBER, HUBER / np.maximum(size, HUBER), 1.0)
        scale2 = spread**2 * together(np.clip(residual, -3 * spread, 3 * spread), starts, rate_hz)
    return Fitted(found, covariance, residual, weights, scale2)


def held_out(
    matrix: FloatArray,
    measured: FloatArray,
    prior: tuple[FloatArray, FloatArray],
    whole: Fitted,
    group: np.ndarray,
) -> FloatArray:
    """Residual of each row by a fit to the rows of all other groups; (n,). group (n,): integers from 0."""
    beyond = measured - matrix @ prior[0]
    weighted = matrix * whole.weights[:, None]
    gram, target = weighted.T @ matrix, weighted.T @ beyond
    out = np.empty(len(measured))
    for number in np.unique(group):
        rows = group == number
        part, values = weighted[rows], matrix[rows]
        found, _ = _solve(gram - part.T @ values, target - part.T @ beyond[rows], prior, whole.scale2)
        out[rows] = measured[rows] - values @ found
    return out


def stack(columns: Mapping[str, FloatArray], names: Sequence[str]) -> FloatArray:
    """The regressors as a matrix (n, p)."""
    return np.column_stack([columns[name] for name in names])
