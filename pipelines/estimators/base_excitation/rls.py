"""Pence, Fathy & Stein, equations (3)-(7), on one corner, and their sum over four corners.

One corner: y = -k/Λ (a_s - a_u) = [m b] [s²/Λ a_s; s/Λ (a_s - a_u)] by recursive least squares.

Four corners of a rigid body: a corner's equation is not that of its static load (pitch and roll inertia couple the
corners), but their sum is heave, in which no inertia appears: sum F_i = M a_G. The acceleration of the CG is that of
the axles' middles, weighted by its place, a_G = (1 - x/L) a_front + (x/L) a_rear, so that

    -sum k_i/Λ (a_s - a_u)_i = [m_f m_r b_f b_r] [s²/Λ a_front; s²/Λ a_rear; s/Λ (sum d_f); s/Λ (sum d_r)]

with m_f = M (1 - x/L) and m_r = M x/L: the static sprung loads of the axles. Anti-roll bars, whose forces sum to zero,
drop out.

How far off it may be: noise in the regressors pulls the estimate low. Regressing in the direction of another column
gives the other end (Frisch: with errors in all variables the truth lies between), and blocks give the scatter.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.base_excitation.data import AXLES, RideData
from pipelines.filters.least_squares import recursive_least_squares
from pipelines.filters.second_order import second_order_filters
from pipelines.results import FloatArray

INITIAL_COVARIANCE = 1000.0
"""P(0) of Table I, on the diagonal."""

BLOCK_S = 10.0
TRACK_S = 1.0


@dataclass(frozen=True)
class Regression:
    """Rows that went into the estimator: phi (n, p), y (n,) with its parts by axle or wheel (n, a), and each row's
    number in the drive's grid (n,)."""

    names: tuple[str, ...]
    phi: FloatArray
    y: FloatArray
    parts: FloatArray
    rows: np.ndarray


@dataclass(frozen=True)
class RlsFit:
    """theta: (p,) last estimate. track: (t, p) on the way, at rows `track_rows` of the grid.

    scatter: (p,) standard deviation by the blocks' scatter (noise is correlated: P itself promises too much).
    other_end: (p,) largest distance to the estimates of the other directions of regression. residual: (n,).
    """

    regression: Regression
    theta: FloatArray
    track: FloatArray
    track_rows: np.ndarray
    scatter: FloatArray
    other_end: FloatArray
    residual: FloatArray


@dataclass(frozen=True)
class FilterChoice:
    """Λ's natural frequency in rad/s and damping ratio (Table II: 6 and 0.1)."""

    natural_radps: float = 6.0
    damping_ratio: float = 0.1


def settling_s(choice: FilterChoice) -> float:
    """How long a filter that starts in the middle of a motion is wrong: two of its time constants, 20 s at most."""
    return min(2 / (choice.damping_ratio * choice.natural_radps), 20.0)


def _filtered(
    columns: Mapping[str, FloatArray], data: RideData, choice: FilterChoice
) -> tuple[Mapping[str, FloatArray], np.ndarray]:
    """Each column through the three filters (n, 3), afresh in every stretch; and the rows that may be used."""
    settle = round(settling_s(choice) * data.rate_hz)
    usable = np.zeros(len(data.lively), dtype=bool)
    out = {name: np.zeros((len(column), 3)) for name, column in columns.items()}
    for start, stop in data.stretches:
        usable[start + settle : stop] = data.lively[start + settle : stop]
        for name, column in columns.items():
            out[name][start:stop] = second_order_filters(
                column[start:stop], 1 / data.rate_hz, choice.natural_radps, choice.damping_ratio
            )
    return out, np.flatnonzero(usable)


def corner_regression(data: RideData, wheel: str, choice: FilterChoice) -> Regression:
    """Equation (4) of one corner."""
    sprung, apart = data.sprung[wheel], data.sprung[wheel] - data.unsprung[wheel]
    filtered, rows = _filtered({"sprung": sprung, "apart": apart}, data, choice)
    s, d = filtered["sprung"][rows], filtered["apart"][rows]
    y = np.asarray(-data.springs[wheel].value * d[:, 0])
    return Regression(("mass", "damping"), np.column_stack((s[:, 2], d[:, 1])), y, y[:, None], rows)


def heave_regression(data: RideData, choice: FilterChoice) -> Regression:
    """The sum of equation (4) over four corners. Needs all four."""
    columns: dict[str, FloatArray] = {}
    for axle, (left, right) in AXLES.items():
        columns[f"mean_{axle}"] = (data.sprung[left] + data.sprung[right]) / 2
        columns[f"apart_{axle}"] = 2 * columns[f"mean_{axle}"] - data.unsprung[left] - data.unsprung[right]
    filtered, rows = _filtered(columns, data, choice)
    phi = np.column_stack([
        *(filtered[f"mean_{axle}"][rows, 2] for axle in AXLES),
        *(filtered[f"apart_{axle}"][rows, 1] for axle in AXLES),
    ])  # fmt: skip
    parts = np.column_stack([
        -data.springs[pair[0]].value * filtered[f"apart_{axle}"][rows, 0] for axle, pair in AXLES.items()
    ])  # fmt: skip
    names = ("mass_front", "mass_rear", "damping_front", "damping_rear")
    return Regression(names, phi, np.asarray(parts.sum(axis=1)), parts, rows)


def other_directions(phi: FloatArray, y: FloatArray) -> FloatArray:
    """Estimates (p, p) of θ when column j, and not y, is taken as the one with the error: row j is that direction's.

    Rows that are no estimate (a coefficient near zero, or of the other sign than least squares gives) are NaN.
    """
    count = phi.shape[1]
    square, direct = phi.T @ phi, np.linalg.lstsq(phi, y, rcond=None)[0]
    moment, power = phi.T @ y, float(y @ y)
    out = np.full((count, count), np.nan)
    for j in range(count):
        rest = [i for i in range(count) if i != j]
        # column j = (y - sum of the others) / θ_j, by least squares on y and the others
        left = np.block(
            [
                [np.array([[power]]), moment[rest][None, :]],
                [moment[rest][:, None], square[np.ix_(rest, rest)]],
            ]
        )
        right = np.concatenate(([moment[j]], square[rest, j]))
        try:
            c = np.linalg.solve(left, right)
        except np.linalg.LinAlgError:
            continue
        if c[0] * direct[j] <= 0:
            continue
        theta = np.empty(count)
        theta[j] = 1 / c[0]
        theta[rest] = -c[1:] / c[0]
        out[j] = theta
    return out


def _scatter(regression: Regression, residual: FloatArray, rate_hz: float) -> FloatArray:
    """Standard deviation of θ by the scatter of the blocks' scores, with Student's allowance for few blocks."""
    phi = regression.phi
    rows = max(1, round(BLOCK_S * rate_hz))
    count = max(len(phi) // rows, 1)
    edges = np.linspace(0, len(phi), count + 1).round().astype(int)[:-1]
    score = np.add.reduceat(phi * residual[:, None], edges, axis=0)
    inverse = np.linalg.pinv(phi.T @ phi)
    factor = count / (count - 1) if count > 1 else 10.0
    covariance = inverse @ (score.T @ score) @ inverse * factor
    white = np.diag(inverse) * float(np.mean(residual**2))
    few = 1 + 4 / max(count, 1)
    return np.asarray(few * np.sqrt(np.maximum(np.diag(covariance), white)))


def run_rls(regression: Regression, rate_hz: float) -> RlsFit | None:
    """Recursive least squares from θ(0) = 0 and P(0) = 1000 I (Table I). None with fewer rows than BLOCK_S."""
    if len(regression.y) < BLOCK_S * rate_hz:
        return None
    count = len(regression.names)
    every = max(1, round(TRACK_S * rate_hz))
    track, theta, _ = recursive_least_squares(
        regression.phi, regression.y, np.zeros(count), INITIAL_COVARIANCE * np.eye(count), every=every
    )
    residual = regression.y - regression.phi @ theta
    others = other_directions(regression.phi, regression.y)
    apart = np.nan_to_num(np.nanmax(np.abs(others - theta), axis=0, initial=0.0))
    rows = regression.rows[every - 1 :: every][: len(track)]
    scatter = _scatter(regression, residual, rate_hz)
    return RlsFit(regression, theta, track, rows, scatter, apart, residual)


def combined_std(fit: RlsFit, weights: Sequence[float], model_error: float) -> tuple[float, float]:
    """Value and standard deviation of sum(weights θ): scatter, the way to the other end, and the model's own error.

    model_error: as a share of the value.
    """
    w = np.asarray(weights, dtype=float)
    value = float(w @ fit.theta)
    chance = math.sqrt(float(np.sum((w * fit.scatter) ** 2)))
    # a uniform law between this end and the other one
    tilt = float(np.sum(np.abs(w) * fit.other_end)) / math.sqrt(3)
    return value, math.sqrt(chance**2 + tilt**2 + (model_error * value) ** 2)
