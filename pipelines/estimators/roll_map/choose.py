"""The band that the roll fit works in: the sure one, or the whole one where the model is seen to hold in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import RollFit
from pipelines.results import FloatArray

MOST_ROWS = 3000
"""Rows beyond which the whole band is not tried: the noise of a drive as long is nothing beside the model's own error."""

AGREE = 11.3
"""99 % of chi-square with three degrees of freedom."""

MOST_WIDENED = 1.6
"""By how much the honest spread of a, b, c in the whole band may exceed that of white noise."""

BEYOND_MODE = 1.3


def _coefficients(fit: RollFit) -> tuple[FloatArray, FloatArray, FloatArray]:
    """a, b, c, their honest covariance, and their variances with white noise."""
    index = [fit.index(name) for name in "abc"]
    values = np.array([fit.values[name] for name in "abc"])
    block = np.ix_(index, index)
    return values, fit.covariance[block], np.diag(fit.white_covariance[block])


def holds(sure: RollFit, whole: RollFit) -> bool:
    """Whether the fit in the whole band may stand for the one in the sure band.

    It must agree with it within the sure one's spread (Hausman's test, on its careful side), and what it leaves over must
    be white: tyres, filters and rough roads show in the upper band first.
    """
    if not whole.converged:
        return False
    first, spread, _ = _coefficients(sure)
    second, honest, white = _coefficients(whole)
    apart = second - first
    agrees = float(apart @ np.linalg.solve(spread, apart)) <= AGREE
    return agrees and bool(np.all(np.diag(honest) <= MOST_WIDENED**2 * white))


def fit_best(
    sure: RollData, whole: Callable[[], RollData | None], fitted: Callable[[RollData], RollFit]
) -> tuple[RollData, RollFit]:
    """Data and fit to go on with.

    The sure band ends where the input falls to 0.005 of its peak. On a plant like the model it loses a factor of two of b; on
    vehicles with tyres, friction and filters the whole band gave damping 40 % off with a claim of 20 %. So the whole band
    is taken where it is seen to hold, and where the input has motion beyond the roll mode: short of that, noise and motion
    tell equally much there.
    """
    fit = fitted(sure)
    mode = math.sqrt(max(fit.values["a"], 1.0) / max(fit.values["c"], 0.1)) / (2 * math.pi)
    if sure.size > MOST_ROWS or sure.top_hz < BEYOND_MODE * mode or fit.explained < 0.5:
        return sure, fit
    data = whole()
    if data is None or data.size != sure.size:
        return sure, fit
    other = fitted(data)
    return (data, replace(other, whole_band=True)) if holds(fit, other) else (sure, fit)
