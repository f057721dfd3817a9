"""The three-state Huber extended Kalman filter with its two-state companion, as one compiled loop (Wu et al.).

First filter, x = (v, h, a): speed, CG height, distance from front axle to CG, equations (5)-(7), gain (15)-(16).
Second filter, x = (v, h) with a from the first: equation (18). Their heights are weighted (section 2.3). An infinite
Huber bound makes the first filter the plain EKF (9)-(13).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray

GRAVITY = 9.80665


@dataclass(frozen=True)
class HekfSettings:
    """What the filter is given.

    start: (v, h, a) at the first row, m/s, m, m. start_variance: their variances. process: variances added a step.
    speed_variance: R in (m/s)². huber: gamma, in standard deviations (inf: the plain EKF). weight: share of the first
    filter's height in the answer. feedback: the weighted height starts both filters' next step.
    """

    start: tuple[float, float, float]
    start_variance: tuple[float, float, float]
    process: tuple[float, float, float]
    speed_variance: float
    huber: float = 1.345
    weight: float = 0.9
    feedback: bool = True


@dataclass(frozen=True)
class HekfTrack:
    """Estimates over time, each (n,). height is the weighted one; height_first and height_second its parts.

    height_std, axle_std: of the first filter's own covariance. innovation: of the speed, NaN where a segment starts.
    """

    speed: FloatArray
    height: FloatArray
    axle: FloatArray
    height_first: FloatArray
    height_second: FloatArray
    height_std: FloatArray
    axle_std: FloatArray
    innovation: FloatArray


_Three = tuple[float, float, float, float, float, float]
_Two = tuple[float, float, float]


@kernel
def _ahead(P: _Three, fh: float, fa: float, q: FloatArray) -> _Three:
    """(10) for F = [[1, fh, fa], [0, 1, 0], [0, 0, 1]]; P: p00, p01, p02, p11, p12, p22."""
    p00, p01, p02, p11, p12, p22 = P
    p00 += 2 * (fh * p01 + fa * p02) + fh * (fh * p11 + 2 * fa * p12) + fa * fa * p22 + q[0]
    return p00, p01 + fh * p11 + fa * p12, p02 + fh * p12 + fa * p22, p11 + q[1], p12, p22 + q[2]


@kernel
def _correct_three(x: _Two, P: _Three, e: float, spread: float) -> tuple[_Two, _Three]:
    """(11)-(13) for H = [1 0 0]; x: v, h, a."""
    p00, p01, p02, p11, p12, p22 = P
    total = 1.0 / (p00 + spread)
    g0, g1, g2 = p00 * total, p01 * total, p02 * total
    state = x[0] + g0 * e, x[1] + g1 * e, x[2] + g2 * e
    return state, (
        p00 - g0 * p00,
        p01 - g0 * p01,
        p02 - g0 * p02,
        p11 - g1 * p01,
        p12 - g1 * p02,
        p22 - g2 * p02,
    )


@kernel
def _hekf_ekf(
    y: FloatArray, F: FloatArray, sin: FloatArray, cos: FloatArray, starts: FloatArray, known: FloatArray,
    x0: FloatArray, p0: FloatArray, q: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (n, 8). F: F_z2 in N; known: dt, m, L, r f, R, gamma, weight, feedback (0 or 1)."""
    dt, m, L, rf, R, gamma, weight = known[0], known[1], known[2], known[3], known[4], known[5], known[6]
    feedback = known[7] > 0.5
    g, deviation, heavy = 9.80665, np.sqrt(known[4]), known[1] * 9.80665
    v, h, a = x0[0], x0[1], x0[2]
    P = (p0[0], 0.0, 0.0, p0[1], 0.0, p0[2])
    w, k = v, h
    s00, s01, s11 = p0[0], 0.0, p0[1]
    for i in range(y.shape[0]):
        if starts[i] < 0.5:
            # (6), and its Jacobian (14): dv/dh = -dt N / (m h^2), dv/da = -dt g cos / h
            moment = (F[i - 1] * L - heavy * (a + rf) * cos[i - 1]) / m
            tilt = g * sin[i - 1]
            inverse = 1.0 / h
            slope = moment * inverse
            v += dt * (slope - tilt)
            P = _ahead(P, -dt * slope * inverse, -dt * g * cos[i - 1] * inverse, q)
            # (18): the same with a given
            other = 1.0 / k
            pull = moment * other
            fk = -dt * pull * other
            w += dt * (pull - tilt)
            s00 += 2 * fk * s01 + fk * fk * s11 + q[0]
            s01 += fk * s11
            s11 += q[1]
        elif i > 0:
            # after a gap the speed starts anew, the constants stay
            v, w = y[i], y[i]
            P = (R, 0.0, 0.0, P[3], P[4], P[5])
            s00, s01 = R, 0.0
        e = y[i] - v
        distance = abs(e) / deviation
        # (15)-(16)
        (v, h, a), P = _correct_three((v, h, a), P, e, R if distance <= gamma else R * distance / gamma)
        error = y[i] - w
        part = 1.0 / (s00 + R)
        c0, c1 = s00 * part, s01 * part
        w += c0 * error
        k += c1 * error
        s11 -= c1 * s01
        s00 -= c0 * s00
        s01 -= c0 * s01
        # the model divides by the height
        h, k = max(h, 0.05), max(k, 0.05)
        both = weight * h + (1.0 - weight) * k
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = v, both, a, h
        out[i, 4], out[i, 5], out[i, 6] = k, P[3], P[5]
        out[i, 7] = e if starts[i] < 0.5 else np.nan
        if feedback:
            h, k = both, both


def hekf_ekf(
    speed: FloatArray,
    load: FloatArray,
    grade: FloatArray,
    dt: float,
    mass: float,
    wheelbase: float,
    rolling_arm: float,
    settings: HekfSettings,
    starts: FloatArray | None = None,
) -> HekfTrack:
    """Wu et al., equations (5)-(16) and (18), over one drive.

    speed (n,) m/s, load (n,) rear axle load in N, grade (n,) rad, finite, at even steps of dt s. mass kg, wheelbase m,
    rolling_arm: r f in m. starts (n,): 1 where a segment begins (the speed then starts anew). Raises ValueError where
    the arrays do not fit or a variance or height is not positive.
    """
    n = len(speed)
    if not (n and len(load) == len(grade) == n):
        raise ValueError("speed, load and grade must have the same, non-zero length")
    if settings.speed_variance <= 0 or settings.start[1] <= 0 or min(mass, wheelbase, dt) <= 0:
        raise ValueError("speed variance, height, mass, wheelbase and step must be positive")
    begin = np.zeros(n) if starts is None else np.array(starts, dtype=np.float64)
    begin[0] = 1.0
    known = np.array(
        [dt, mass, wheelbase, rolling_arm, settings.speed_variance, settings.huber, settings.weight, float(settings.feedback)]
    )  # fmt: skip
    out = np.empty((n, 8))
    columns = [np.ascontiguousarray(c, dtype=np.float64) for c in (speed, load, np.sin(grade), np.cos(grade))]
    _hekf_ekf(
        columns[0], columns[1], columns[2], columns[3], begin, known, np.array(settings.start), np.array(settings.start_variance),
        np.array(settings.process), out,
    )  # fmt: skip
    with np.errstate(invalid="ignore"):
        height_std, axle_std = np.sqrt(out[:, 5]), np.sqrt(out[:, 6])
    parts = (out[:, 0], out[:, 1], out[:, 2], out[:, 3], out[:, 4], height_std, axle_std, out[:, 7])
    return HekfTrack(*parts)


def load_noise_process(wheelbase: float, dt: float, load_std: float, mass: float, height: float) -> float:
    """Variance that the load sensor's noise (N) adds to the speed in one step of (4), in (m/s)²."""
    return (wheelbase * dt * load_std / (mass * height)) ** 2


@kernel
def _random_walk(
    y: FloatArray, q: float, r: float, gamma: float, x: float, p: float, out: FloatArray
) -> None:
    """Scalar Kalman filter of a random walk with the Huber gain (15)-(16); out (n,)."""
    limit = gamma * np.sqrt(r)
    for i in range(y.shape[0]):
        p += q
        e = y[i] - x
        size = abs(e)
        spread = r if size <= limit else r * size / limit
        gain = p / (p + spread)
        x += gain * e
        p -= gain * p
        out[i] = x


def huber_random_walk(
    y: FloatArray, process: float, variance: float, huber: float = math.inf, start: float = 0.0, start_variance: float = 1.0
) -> FloatArray:  # fmt: skip
    """Random walk x[k] = x[k-1] + w seen as y = x + v, filtered; (n,). huber inf: the plain Kalman filter.

    process, variance: of w (a step) and of v. Psi of (16) is min(1, huber / |y - x| * sqrt(variance)), one pass.
    """
    out = np.empty(len(y))
    _random_walk(
        np.ascontiguousarray(y, dtype=np.float64), process, variance, huber, start, start_variance, out
    )
    return out
