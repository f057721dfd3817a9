"""The roll model (1)-(2) of one particle over one step, from a series: no logarithm, no branch by the kind of damping.

With X = A step, every power of X is p I + q X, for X² = -beta X - alpha I (Cayley and Hamilton). Of the functions
phi2 = sum X^n / (n + 2)!, phi1 = I + X phi2 and exp = I + X phi1 the first is summed on a step halved until X is small, and
then doubled back: phi2(2X) = (phi1² + 2 phi2) / 4. Eight powers at the halved step's bound leave less than 1e-13 of it.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.jit import lean_kernel
from pipelines.filters.marginalized_particle.layout import (
    A00,
    A01,
    A10,
    A11,
    AFTER0,
    AFTER1,
    LEVEL0,
    LEVEL1,
)

INVERSES = tuple(1.0 / n for n in range(10, 2, -1))
"""Of the series' denominators, last first: its terms go to the eighth power."""

SMALL = 0.125
"""Largest root of alpha, and largest beta, at which the series is summed."""


@lean_kernel
def discretise(row: FloatArray, step: float, gravity: float) -> None:
    """Fill a particle's A, level and after from its K, D, h, m, I_x, z. x[k+1] = A x[k] + level f[k] + after (f[k+1] - f[k])."""
    stiffness, damping, height, mass, inertia, above = row[0], row[1], row[2], row[3], row[4], row[5]
    lever = mass * height
    total = inertia + lever * (height - above)
    alpha = (stiffness - lever * gravity) / total * step * step
    beta = damping / total * step
    size, halvings = max(np.sqrt(abs(alpha)), abs(beta)), 0
    while size > SMALL and halvings < 40:
        size, alpha, beta = 0.5 * size, 0.25 * alpha, 0.5 * beta
        halvings += 1
    p, q = 1.0, 0.0
    for inverse in INVERSES:
        p, q = 1.0 - inverse * alpha * q, inverse * (p - beta * q)
    p, q = 0.5 * p, 0.5 * q
    for _ in range(halvings):
        one, slope = 1.0 - alpha * q, p - beta * q
        square, mixed = one * one - alpha * slope * slope, 2.0 * one * slope - beta * slope * slope
        p, q = 0.25 * (square + 2.0 * p), 0.125 * (mixed + 2.0 * q)
        alpha, beta = 4.0 * alpha, 2.0 * beta
    one, slope = 1.0 - alpha * q, p - beta * q
    gain = lever / total * step
    row[AFTER0], row[AFTER1] = gain * q * step, gain * (p - beta * q)
    row[LEVEL0], row[LEVEL1] = gain * slope * step, gain * (one - beta * slope)
    p, q = 1.0 - alpha * slope, one - beta * slope
    row[A00], row[A01] = p, q * step
    row[A10], row[A11] = -alpha * q / step, p - beta * q
