"""Motion of a small linear model under inputs that run straight from row to row, as one compiled loop."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel

BEYOND = 1e300
"""Stands for what is beyond all numbers, so that a motion that ran away is not taken for one that was not measured."""


@kernel
def _driven(
    push: FloatArray,
    starts: IntArray,
    stops: IntArray,
    phi: FloatArray,
    before: FloatArray,
    after: FloatArray,
    rows: FloatArray,
    first: FloatArray,
    found: FloatArray,
) -> None:
    """Fill `found` (n, k); see `driven`."""
    states, outputs = phi.shape[0], rows.shape[0]
    inputs = push.shape[1]
    x, following = np.zeros(states), np.zeros(states)
    for segment in range(starts.shape[0]):
        x[:] = first[segment]
        for i in range(starts[segment], stops[segment]):
            for k in range(outputs):
                total = 0.0
                for s in range(states):
                    total += rows[k, s] * x[s]
                found[i, k] = total if np.isfinite(total) else BEYOND
            if i + 1 == stops[segment]:
                break
            for s in range(states):
                total = 0.0
                for u in range(inputs):
                    total += before[s, u] * push[i, u] + after[s, u] * push[i + 1, u]
                for j in range(states):
                    total += phi[s, j] * x[j]
                following[s] = total
            x[:] = following


def driven(
    push: FloatArray,
    segments: tuple[IntArray, IntArray],
    held: tuple[FloatArray, FloatArray, FloatArray],
    rows: FloatArray,
    first: FloatArray,
) -> FloatArray:
    """(n, k) rows x of x[i+1] = phi x[i] + before u[i] + after u[i+1]; zero outside the segments, BEYOND where it is not finite.

    push: (n, u) inputs. segments: first rows and rows past the last. held: phi (s, s), before and after (s, u). rows: (k, s).
    first: (segments, s) states at the first rows. Raises ValueError where a segment leaves the arrays or a shape does not fit.
    """
    phi, before, after = held
    states, inputs = len(phi), push.shape[1]
    starts, stops = segments
    fit = (
        phi.shape == (states, states)
        and before.shape == after.shape == (states, inputs)
        and rows.shape == (len(rows), states)
        and first.shape == (len(starts), states)
        and len(starts) == len(stops)
    )
    if not fit:
        raise ValueError("the model's arrays do not fit together")
    if len(starts) and (starts.min() < 0 or stops.max() > len(push)):
        raise ValueError("a segment leaves the arrays")
    found = np.zeros((len(push), len(rows)))
    _driven(push, starts, stops, phi, before, after, rows, first, found)
    return found
