"""Response of a second-order system to a sampled input that runs straight between samples, as one compiled loop."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel


@kernel
def _run(
    f: FloatArray,
    phi: FloatArray,
    before: FloatArray,
    after: FloatArray,
    gain: float,
    starts: IntArray,
    stops: IntArray,
    out: FloatArray,
) -> None:
    """Fill out (n, 2) with state and rate; each segment starts at rest under its first input."""
    p00, p01, p10, p11 = phi[0, 0], phi[0, 1], phi[1, 0], phi[1, 1]
    for segment in range(len(starts)):
        x0 = gain * f[starts[segment]]
        x1 = 0.0
        for k in range(starts[segment], stops[segment]):
            out[k, 0] = x0
            out[k, 1] = x1
            if k + 1 < stops[segment]:
                x0, x1 = (
                    p00 * x0 + p01 * x1 + before[0] * f[k] + after[0] * f[k + 1],
                    p10 * x0 + p11 * x1 + before[1] * f[k] + after[1] * f[k + 1],
                )


def linear_response(
    f: FloatArray,
    phi: FloatArray,
    before: FloatArray,
    after: FloatArray,
    gain: float,
    segments: tuple[IntArray, IntArray],
) -> FloatArray:
    """State and rate (n, 2) of x[k+1] = phi x[k] + before f[k] + after f[k+1]; zeros between segments.

    f: (n,). phi: (2, 2). before, after: (2,). gain: steady state per input, where each segment starts. segments: first
    rows and rows past the last. Raises ValueError where a segment leaves the array.
    """
    starts, stops = segments
    if len(starts) and (starts.min() < 0 or stops.max() > len(f)):
        raise ValueError("a segment leaves the array")
    out = np.zeros((len(f), 2))
    _run(np.ascontiguousarray(f), phi, before, after, gain, starts, stops, out)
    return out
