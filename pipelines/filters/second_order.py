"""The three filters 1/Λ, s/Λ and s²/Λ with Λ = s² + 2 ζ ω s + ω², by Tustin's rule, as one compiled loop.

Pence, Fathy & Stein, equations (3)-(5). The bilinear (Tustin) rule keeps s²/Λ, s/Λ and 1/Λ to one another as s², s and
1 are, so that the filtered equation of motion stays exact for signals well below half the sampling rate; a zero-order
hold does not (1/Λ then lags the others by half a sample).
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray


@kernel
def _filter(u: FloatArray, c: float, damping: float, frequency: float, out: FloatArray) -> None:
    """Fill out (n, 3): 1/Λ, s/Λ, s²/Λ of u, all with one state. c = 2 / T, s = c (z - 1) / (z + 1)."""
    square, middle = frequency * frequency, 2.0 * damping * frequency * c
    scale = 1.0 / (c * c + middle + square)
    a1, a2 = 2.0 * (square - c * c) * scale, (c * c - middle + square) * scale
    v1 = v2 = 0.0
    for k in range(len(u)):
        v = u[k] * scale - a1 * v1 - a2 * v2
        out[k, 0] = v + 2.0 * v1 + v2
        out[k, 1] = c * (v - v2)
        out[k, 2] = c * c * (v - 2.0 * v1 + v2)
        v2 = v1
        v1 = v


def second_order_filters(
    u: FloatArray, step_s: float, natural_radps: float, damping_ratio: float
) -> FloatArray:
    """1/Λ, s/Λ and s²/Λ of u (n,), from rest: (n, 3). Raises ValueError for a step or a frequency not above 0."""
    if step_s <= 0 or natural_radps <= 0:
        raise ValueError("step and natural frequency are above 0")
    out = np.empty((len(u), 3))
    _filter(np.ascontiguousarray(u), 2.0 / step_s, damping_ratio, natural_radps, out)
    return out
