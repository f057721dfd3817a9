"""Compiled filters of the sensors: a second-order low-pass, and a slowly wandering offset."""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray

_HIGHEST = 0.45
"""A cut-off above this share of the rate is no filter: the samples hold nothing there."""


@kernel
def biquad(values: FloatArray, b: FloatArray, a: FloatArray) -> FloatArray:
    """Second-order section b (3,) over a (3,), a[0] = 1, in transposed direct form II; begins settled at values[0]."""
    out = np.empty(len(values))
    gain = (b[0] + b[1] + b[2]) / (a[0] + a[1] + a[2])
    first = values[0] if len(values) else 0.0
    # the states that hold a constant input at a constant output
    s2 = b[2] * first - a[2] * gain * first
    s1 = b[1] * first - a[1] * gain * first + s2
    for i in range(len(values)):
        x = values[i]
        y = b[0] * x + s1
        s1 = b[1] * x - a[1] * y + s2
        s2 = b[2] * x - a[2] * y
        out[i] = y
    return out


@kernel
def first_order(drive: FloatArray, pole: float) -> FloatArray:
    """y[i] = pole y[i-1] + drive[i], from y[-1] = 0."""
    out = np.empty(len(drive))
    y = 0.0
    for i in range(len(drive)):
        y = pole * y + drive[i]
        out[i] = y
    return out


def low_pass(values: FloatArray, cutoff_hz: float, rate_hz: float) -> FloatArray:
    """Butterworth low-pass of second order by the bilinear transform with its frequency matched. values: (n,)."""
    if cutoff_hz >= _HIGHEST * rate_hz:
        return values
    w = np.tan(np.pi * cutoff_hz / rate_hz)
    scale = 1 / (1 + np.sqrt(2) * w + w * w)
    b = np.array([1.0, 2.0, 1.0]) * (w * w * scale)
    a = np.array([1.0, 2 * (w * w - 1) * scale, (1 - np.sqrt(2) * w + w * w) * scale])
    return biquad(np.ascontiguousarray(values, dtype=np.float64), b, a)


def wander(n: int, std: float, time_s: float, period_s: float, rng: np.random.Generator) -> FloatArray:
    """A first-order Gauss-Markov process, (n,): std everywhere, correlation exp(-t / time_s)."""
    pole = float(np.exp(-period_s / time_s))
    drive = rng.standard_normal(n) * (std * np.sqrt(1 - pole * pole))
    if n:
        drive[0] = std * rng.standard_normal()
    return first_order(drive, pole)
