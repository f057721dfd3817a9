"""The cubic spline through a signal's samples, read at sorted times: one compiled pass up, one down, one to read."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.jit import kernel


@kernel
def _read(
    time_s: FloatArray,
    values: FloatArray,
    wanted_s: FloatArray,
    bend: FloatArray,
    over: FloatArray,
    out: FloatArray,
) -> None:
    """Fill `out` (m,). bend, over: (n,) room for the second derivatives and for what the pass up leaves on the right."""
    n = len(time_s)
    # second derivatives m: h0 m[i-1] + 2 (h0 + h1) m[i] + h1 m[i+1] = 6 (slope after - slope before); the third derivative does
    # not jump at the second and the last but one sample ("not a knot"), which tells m[0] and m[n-1] by their two neighbours
    for i in range(1, n - 1):
        h0, h1 = time_s[i] - time_s[i - 1], time_s[i + 1] - time_s[i]
        right = 6 * ((values[i + 1] - values[i]) / h1 - (values[i] - values[i - 1]) / h0)
        below, middle, above = h0, 2 * (h0 + h1), h1
        if i == 1:
            middle += h0 * (h0 + h1) / h1
            above -= h0 * h0 / h1
            below = 0.0
        if i == n - 2:
            middle += h1 * (h0 + h1) / h0
            below -= h1 * h1 / h0
            above = 0.0
        if i > 1:
            middle -= below * over[i - 1]
            right -= below * bend[i - 1]
        over[i] = above / middle
        bend[i] = right / middle
    for i in range(n - 3, 0, -1):
        bend[i] -= over[i] * bend[i + 1]
    ratio = (time_s[1] - time_s[0]) / (time_s[2] - time_s[1])
    bend[0] = bend[1] + ratio * (bend[1] - bend[2])
    ratio = (time_s[n - 1] - time_s[n - 2]) / (time_s[n - 2] - time_s[n - 3])
    bend[n - 1] = bend[n - 2] + ratio * (bend[n - 2] - bend[n - 3])
    at = 0
    for k in range(len(wanted_s)):
        while at < n - 2 and time_s[at + 1] < wanted_s[k]:
            at += 1
        h = time_s[at + 1] - time_s[at]
        b = (wanted_s[k] - time_s[at]) / h
        a = 1 - b
        curved = (a * a * a - a) * bend[at] + (b * b * b - b) * bend[at + 1]
        out[k] = a * values[at] + b * values[at + 1] + curved * h * h / 6


def spline_at(time_s: FloatArray, values: FloatArray, wanted_s: FloatArray) -> FloatArray:
    """(m,) the "not a knot" cubic spline through values (n,) at time_s (n,), n >= 4, both rising, read at rising wanted_s (m,).

    Raises ValueError for fewer than four samples or shapes that do not fit.
    """
    n = len(time_s)
    if n < 4 or values.shape != time_s.shape:
        raise ValueError("a spline needs four samples, and a time for each")
    out = np.empty(len(wanted_s))
    times, samples, wanted = (
        np.ascontiguousarray(column, dtype=np.float64) for column in (time_s, values, wanted_s)
    )
    _read(times, samples, wanted, np.zeros(n), np.zeros(n), out)
    return out
