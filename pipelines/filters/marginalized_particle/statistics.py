"""What a weighted cloud says at one sample: means, standard deviations, quantiles."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.jit import lean_kernel

BINS = 400
REACH = 5.0
"""The quantiles' bins cover the mean -+ REACH standard deviations: a quantile is good to about a hundredth of one."""


@lean_kernel
def _from_bins(
    bins: FloatArray, low: float, wide: float, levels: tuple[float, float, float], out: FloatArray
) -> None:
    """Quantiles by straight lines through the bins' sums (of sum one)."""
    total, level = 0.0, 0
    for b in range(BINS):
        before = total
        total += bins[b]
        while level < 3 and (total >= levels[level] or b == BINS - 1):
            part = (levels[level] - before) / bins[b] if bins[b] > 0.0 else 0.0
            out[level] = low + wide * (b + min(max(part, 0.0), 1.0))
            level += 1


@lean_kernel
def quantiles(
    table: FloatArray,
    weights: FloatArray,
    particles: int,
    mean: FloatArray,
    std: FloatArray,
    levels: tuple[float, float, float],
    bins: FloatArray,
    out: FloatArray,
) -> None:
    """Weighted quantiles of the first three columns into out (3, 3). bins: (3, BINS), overwritten. weights: sum one."""
    for j in range(3):
        for b in range(BINS):
            bins[j, b] = 0.0
    low0, low1, low2 = mean[0] - REACH * std[0], mean[1] - REACH * std[1], mean[2] - REACH * std[2]
    per0, per1, per2 = 0.0, 0.0, 0.0
    scale = BINS / (2.0 * REACH)
    if std[0] > 0.0:
        per0 = scale / std[0]
    if std[1] > 0.0:
        per1 = scale / std[1]
    if std[2] > 0.0:
        per2 = scale / std[2]
    last = BINS - 1.0
    for i in range(particles):
        row, weight = table[i], weights[i]
        if weight <= 0.0:
            continue
        bins[0, int(min(max((row[0] - low0) * per0, 0.0), last))] += weight
        bins[1, int(min(max((row[1] - low1) * per1, 0.0), last))] += weight
        bins[2, int(min(max((row[2] - low2) * per2, 0.0), last))] += weight
    _from_bins(bins[0], low0, std[0] / scale, levels, out[0])
    _from_bins(bins[1], low1, std[1] / scale, levels, out[1])
    _from_bins(bins[2], low2, std[2] / scale, levels, out[2])


@lean_kernel
def weigh(
    table: FloatArray,
    logs: FloatArray,
    particles: int,
    first: int,
    states: int,
    heaviest: int,
    weights: FloatArray,
    sums: FloatArray,
    square_sums: FloatArray,
) -> tuple[float, float]:
    """Weights over the heaviest's, not yet of sum one, and their sum and sum of squares.

    sums, square_sums: (3 + states,) of K, D, h and the states, as differences from the heaviest particle's, times the weights.
    first: column of the states; their covariances follow.
    """
    total, squares = 0.0, 0.0
    size = 3 + states
    for j in range(size):
        sums[j], square_sums[j] = 0.0, 0.0
    origin, best = table[heaviest], logs[heaviest]
    for i in range(particles):
        weight = np.exp(logs[i] - best)
        weights[i] = weight
        if weight <= 0.0:
            continue
        total += weight
        squares += weight * weight
        row = table[i]
        at, gap = first + states, states
        for j in range(3):
            off = row[j] - origin[j]
            sums[j] += weight * off
            square_sums[j] += weight * off * off
        for j in range(3, size):
            off = row[first + j - 3] - origin[first + j - 3]
            sums[j] += weight * off
            square_sums[j] += weight * (off * off + row[at])
            at += gap
            gap -= 1
    return total, squares
