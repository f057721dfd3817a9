"""How far the motion's parameters may be off: Laplace's covariance, widened where the innovations are not white."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from pipelines.results import FloatArray

SMOOTHED_BINS = 16
"""Half the frequencies over which the innovations' spectrum is averaged: 33 of them leave it good to 18 %."""


def long_run_covariance(scores: FloatArray, lags: int) -> FloatArray:
    """Sum of the scores' autocovariances up to `lags`, with Bartlett's weights (Newey-West): (p, p).

    Triangular weights are those of sums over windows of lags + 1 rows, so that no lag need be taken on its own.
    """
    centred = scores - scores.mean(axis=0)
    window = lags + 1
    nothing = np.zeros((window, scores.shape[1]))
    running = np.cumsum(np.concatenate((nothing, centred, nothing[1:])), axis=0)
    sums = running[window:] - running[:-window]
    return np.asarray(sums.T @ sums / window)


def coloured_covariance(taught: FloatArray, normalised: FloatArray) -> FloatArray:
    """(p, p) the scores' covariance where each channel's innovations have the spectrum that they show and not a white one.

    taught: (p, n, m) slopes of the normalised innovations. normalised: (n, m), NaN where missing.
    """
    total = np.zeros((len(taught), len(taught)))
    for channel in range(normalised.shape[1]):
        there = np.isfinite(normalised[:, channel])
        if there.sum() < 4:
            continue
        nu = np.clip(normalised[there, channel], -4, 4)
        power = np.abs(np.fft.rfft(nu)) ** 2 / len(nu)
        # the mean is an offset's, and fitted: the lowest line says nothing of its neighbours
        power[0] = power[1]
        power = uniform_filter1d(power, min(2 * SMOOTHED_BINS + 1, len(power)), mode="mirror")
        slopes = np.fft.rfft(taught[:, there, channel], axis=1)
        twice = np.full(len(power), 2.0)
        twice[0] = 1.0
        if len(nu) % 2 == 0:
            twice[-1] = 1.0
        total += np.real((slopes * (twice * power / len(nu))) @ slopes.conj().T)
    return total


def honest_covariance(
    information: FloatArray,
    prior: FloatArray,
    coloured: FloatArray,
    long_run: FloatArray,
    windows: float,
    slow_share: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Laplace's covariance, and the same widened in every direction in which the scores vary more than ideal.

    coloured: by the innovations' spectrum. long_run: by how the scores hang together over time, which holds errors that come
    with the manoeuvre, but is a noisy figure: of `windows` independent stretches and p parameters the largest direction
    comes out (1 + sqrt(p / windows))² times too wide by chance alone (Marchenko and Pastur), which is taken off, but not of motion as slow as the road's bank, whose
    correlation is longer than the stretches.
    """
    curvature = information + np.diag(prior)
    scale = 1 / np.sqrt(np.diag(curvature))
    values, vectors = np.linalg.eigh(curvature * np.outer(scale, scale))
    root = (vectors / np.sqrt(np.maximum(values, 1e-12))).T * scale
    by_chance = (1 + np.sqrt(len(prior) / max(windows, 1.0))) ** (2 * (1 - slow_share))
    ratio = root @ (long_run / by_chance + np.diag(prior)) @ root.T
    spread, axes = np.linalg.eigh(0.5 * (ratio + ratio.T))
    plain = root @ (coloured + np.diag(prior)) @ root.T
    shown = np.diag(axes.T @ plain @ axes)
    widened = axes @ np.diag(np.maximum(np.maximum(spread, shown), 1.0)) @ axes.T
    return np.asarray(root.T @ root), np.asarray(root.T @ widened @ root)
