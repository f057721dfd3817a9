"""The roll model (1)-(2) of a tile of particles over one step, from a series: no logarithm, no branch by the kind of damping.

With X = A step, every power of X is p I + q X, for X² = -beta X - alpha I (Cayley and Hamilton). Of the functions
phi2 = sum X^n / (n + 2)!, phi1 = I + X phi2 and exp = I + X phi1 the first is summed on a step halved until X is small, and
then doubled back: phi2(2X) = (phi1² + 2 phi2) / 4. Eight powers at the halved step's bound leave less than 1e-13 of it. A tile
is halved as often as its stiffest particle needs.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.jit import vector_kernel
from pipelines.filters.lanes import LANES
from pipelines.filters.marginalized_particle.layout import (
    A00,
    A01,
    A10,
    A11,
    AFTER0,
    AFTER1,
    I_X,
    LEVEL0,
    LEVEL1,
    D,
    H,
    K,
    M,
    Z,
)

INVERSES = tuple(1.0 / n for n in range(10, 2, -1))
"""Of the series' denominators, last first: its terms go to the eighth power."""

SMALL = 0.125
"""Largest root of alpha, and largest beta, at which the series is summed."""

MOST_HALVINGS = 40

ALPHA, BETA, P, Q, GAIN = A00, A01, A10, A11, LEVEL0
"""Where a tile keeps them until A and level take their places."""


@vector_kernel
def halvings_of(row: FloatArray) -> int:
    """How often the step is halved until the series is good for every lane."""
    largest = 0.0
    for i in range(LANES):
        size = max(np.sqrt(abs(row[ALPHA + i])), abs(row[BETA + i]))
        # what is no number is no particle
        largest = size if largest < size < np.inf else largest
    halvings = 0
    while largest > SMALL and halvings < MOST_HALVINGS:
        largest, halvings = 0.5 * largest, halvings + 1
    return halvings


@vector_kernel
def _oscillator(row: FloatArray, step: float, gravity: float) -> None:
    """alpha and beta of the whole step, and the input's gain."""
    for i in range(LANES):
        lever = row[M + i] * row[H + i]
        over = step / (row[I_X + i] + lever * (row[H + i] - row[Z + i]))
        row[ALPHA + i] = (row[K + i] - lever * gravity) * over * step
        row[BETA + i] = row[D + i] * over
        row[GAIN + i] = lever * over


@vector_kernel
def _series(row: FloatArray, share: float) -> None:
    """phi2 = p I + q X of a share of the step, and its alpha and beta."""
    for i in range(LANES):
        alpha, beta = share * share * row[ALPHA + i], share * row[BETA + i]
        p, q = 1.0, 0.0
        p, q = 1.0 - INVERSES[0] * alpha * q, INVERSES[0] * (p - beta * q)
        p, q = 1.0 - INVERSES[1] * alpha * q, INVERSES[1] * (p - beta * q)
        p, q = 1.0 - INVERSES[2] * alpha * q, INVERSES[2] * (p - beta * q)
        p, q = 1.0 - INVERSES[3] * alpha * q, INVERSES[3] * (p - beta * q)
        p, q = 1.0 - INVERSES[4] * alpha * q, INVERSES[4] * (p - beta * q)
        p, q = 1.0 - INVERSES[5] * alpha * q, INVERSES[5] * (p - beta * q)
        p, q = 1.0 - INVERSES[6] * alpha * q, INVERSES[6] * (p - beta * q)
        p, q = 1.0 - INVERSES[7] * alpha * q, INVERSES[7] * (p - beta * q)
        row[ALPHA + i], row[BETA + i] = alpha, beta
        row[P + i], row[Q + i] = 0.5 * p, 0.5 * q


@vector_kernel
def _double(row: FloatArray) -> None:
    """Of twice the step."""
    for i in range(LANES):
        alpha, beta, p, q = row[ALPHA + i], row[BETA + i], row[P + i], row[Q + i]
        one, slope = 1.0 - alpha * q, p - beta * q
        square, mixed = one * one - alpha * slope * slope, 2.0 * one * slope - beta * slope * slope
        row[P + i], row[Q + i] = 0.25 * (square + 2.0 * p), 0.125 * (mixed + 2.0 * q)
        row[ALPHA + i], row[BETA + i] = 4.0 * alpha, 2.0 * beta


@vector_kernel
def _fill(row: FloatArray, step: float) -> None:
    """A, level and after from phi2."""
    per_step = 1.0 / step
    for i in range(LANES):
        alpha, beta, p, q, gain = row[ALPHA + i], row[BETA + i], row[P + i], row[Q + i], row[GAIN + i]
        one, slope = 1.0 - alpha * q, p - beta * q
        row[AFTER0 + i], row[AFTER1 + i] = gain * q * step, gain * (p - beta * q)
        row[LEVEL0 + i], row[LEVEL1 + i] = gain * slope * step, gain * (one - beta * slope)
        p, q = 1.0 - alpha * slope, one - beta * slope
        row[A00 + i], row[A01 + i] = p, q * step
        row[A10 + i], row[A11 + i] = -alpha * q * per_step, p - beta * q


@vector_kernel
def discretise(row: FloatArray, step: float, gravity: float) -> None:
    """Fill a tile's A, level and after from its K, D, h, m, I_x, z. x[k+1] = A x[k] + level f[k] + after (f[k+1] - f[k])."""
    _oscillator(row, step, gravity)
    halvings = halvings_of(row)
    share = 1.0
    for _ in range(halvings):
        share *= 0.5
    _series(row, share)
    for _ in range(halvings):
        _double(row)
    _fill(row, step)
