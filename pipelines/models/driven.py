"""Motion of a small linear model under inputs that run straight from row to row, as one compiled loop."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel, lean_kernel

BEYOND = 1e300
"""Stands for what is beyond all numbers, so that a motion that ran away is not taken for one that was not measured."""

STATES, INPUTS, OUTPUTS = 3, 2, 2
"""What the loop is written out for: loops over so few cost more than what is in them. Smaller models are filled up with nought."""


@lean_kernel
def _within(value: float) -> float:
    """The value, BEYOND where it is not finite."""
    return value if np.isfinite(value) else -BEYOND if value < 0 else BEYOND


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
    """Fill `found` (n, OUTPUTS); see `driven`. All arrays are as large as the constants say."""
    p00, p01, p02 = phi[0, 0], phi[0, 1], phi[0, 2]
    p10, p11, p12 = phi[1, 0], phi[1, 1], phi[1, 2]
    p20, p21, p22 = phi[2, 0], phi[2, 1], phi[2, 2]
    b00, b01, b10, b11, b20, b21 = (
        before[0, 0], before[0, 1], before[1, 0], before[1, 1], before[2, 0], before[2, 1],
    )  # fmt: skip
    a00, a01, a10, a11, a20, a21 = (
        after[0, 0], after[0, 1], after[1, 0], after[1, 1], after[2, 0], after[2, 1],
    )  # fmt: skip
    r00, r01, r02, r10, r11, r12 = (
        rows[0, 0], rows[0, 1], rows[0, 2], rows[1, 0], rows[1, 1], rows[1, 2],
    )  # fmt: skip
    for segment in range(starts.shape[0]):
        x0, x1, x2 = first[segment, 0], first[segment, 1], first[segment, 2]
        start, stop = starts[segment], stops[segment]
        for i in range(start, stop):
            if i > start:
                u, v, w, z = push[i - 1, 0], push[i - 1, 1], push[i, 0], push[i, 1]
                y0 = (b00 * u + b01 * v + a00 * w + a01 * z) + (p00 * x0 + p01 * x1 + p02 * x2)
                y1 = (b10 * u + b11 * v + a10 * w + a11 * z) + (p10 * x0 + p11 * x1 + p12 * x2)
                x2 = (b20 * u + b21 * v + a20 * w + a21 * z) + (p20 * x0 + p21 * x1 + p22 * x2)
                x0, x1 = y0, y1
            found[i, 0] = _within(r00 * x0 + r01 * x1 + r02 * x2)
            found[i, 1] = _within(r10 * x0 + r11 * x1 + r12 * x2)


def _filled(array: FloatArray, *shape: int) -> FloatArray:
    """The array with noughts behind it."""
    found = np.zeros(shape)
    found[tuple(slice(size) for size in array.shape)] = array
    return found


def driven(
    push: FloatArray,
    segments: tuple[IntArray, IntArray],
    held: tuple[FloatArray, FloatArray, FloatArray],
    rows: FloatArray,
    first: FloatArray,
) -> FloatArray:
    """(n, k) rows x of x[i+1] = phi x[i] + before u[i] + after u[i+1]; zero outside the segments, BEYOND where it is not finite.

    push: (n, u) inputs. segments: first rows and rows past the last. held: phi (s, s), before and after (s, u). rows: (k, s).
    first: (segments, s) states at the first rows. Raises ValueError where a segment leaves the arrays, a shape does not fit, or a
    model is larger than STATES, INPUTS or OUTPUTS.
    """
    phi, before, after = held
    states, inputs, outputs = len(phi), push.shape[1], len(rows)
    starts, stops = segments
    fit = (
        phi.shape == (states, states)
        and before.shape == after.shape == (states, inputs)
        and rows.shape == (outputs, states)
        and first.shape == (len(starts), states)
        and len(starts) == len(stops)
        and states <= STATES
        and inputs <= INPUTS
        and outputs <= OUTPUTS
    )
    if not fit:
        raise ValueError("the model's arrays do not fit together")
    if len(starts) and (starts.min() < 0 or stops.max() > len(push)):
        raise ValueError("a segment leaves the arrays")
    found = np.zeros((len(push), OUTPUTS))
    _driven(
        np.ascontiguousarray(push) if inputs == INPUTS else _filled(push, len(push), INPUTS),
        starts,
        stops,
        _filled(phi, STATES, STATES),
        _filled(before, STATES, INPUTS),
        _filled(after, STATES, INPUTS),
        _filled(rows, OUTPUTS, STATES),
        _filled(first, len(first), STATES),
        found,
    )
    return found[:, :outputs]
