"""The models that the roll fit takes, and its band: the sure one, or the whole one where the model is seen to hold in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import Mixed, RollFit, fit_roll
from pipelines.estimators.roll_map.model import STANDARD, Known
from pipelines.estimators.roll_map.select import select_parts
from pipelines.results import FloatArray

MOST_ROWS = 3000
"""Rows beyond which the whole band is not tried: the noise of a drive as long is nothing beside the model's own error."""

AGREE = 11.3
"""99 % of chi-square with three degrees of freedom."""

MOST_WIDENED = 1.6
"""By how much the honest spread of a, b, c in the whole band may exceed that of white noise."""

HOPELESS = 1.5, 4.0
"""By how many times MOST_WIDENED and AGREE the usual model may miss in the whole band until no further part is tried there: of 112 such
drives of the plant thirteen held in the end, and none had missed by more than 1.24 and 1.9 times."""

LEAST_TRIED = 0.2
"""Share of the roll signal's variance that must follow from the lateral acceleration before parts of a model are weighed."""


def _coefficients(fit: RollFit) -> tuple[FloatArray, FloatArray, FloatArray]:
    """a, b, c, their honest covariance, and their variances with white noise."""
    pick = fit.jacobian[:3]
    white = np.diag(pick @ fit.white_covariance @ pick.T)
    if fit.mixed is not None:
        white = white + np.diag(fit.mixed.between)[:3]
    mean, covariance = fit.told
    return mean[:3], covariance[:3, :3], white


def holds(sure: RollFit, whole: RollFit) -> bool:
    """Whether the fit in the whole band may stand for the one in the sure band.

    It must agree with it within the sure one's spread (Hausman's test, on its careful side), and what it leaves over must
    be white: tyres, filters and rough roads show in the upper band first.
    """
    if not whole.converged:
        return False
    apart, widened = _missed(sure, whole)
    return apart <= AGREE and widened <= MOST_WIDENED


def _missed(sure: RollFit, whole: RollFit) -> tuple[float, float]:
    """chi-square of the whole band's a, b, c against the sure band's, and the most by which their honest spread exceeds that of white noise."""
    first, spread, _ = _coefficients(sure)
    second, honest, white = _coefficients(whole)
    away = second - first
    widened = float(np.sqrt(np.max(np.diag(honest) / white)))
    return float(away @ np.linalg.solve(spread, away)), widened


def hopeless(sure: RollFit, whole: RollFit) -> bool:
    """Whether the usual model finds no end near the sure band's, or misses the whole band by more than any part that it may lack has ever made good."""
    if not whole.converged:
        return True
    apart, widened = _missed(sure, whole)
    return not (apart <= HOPELESS[1] * AGREE and widened <= HOPELESS[0] * MOST_WIDENED)


@dataclass(frozen=True)
class Asked:
    """known: the parameters of a model with certain parts on some data. edges: of the running sums. liveliest: the liveliest stretches of
    the drive, so many rows at most; None where they hold nothing.
    """

    known: Callable[[RollData, frozenset[str]], tuple[Known, ...]]
    edges: IntArray
    liveliest: Callable[[int], RollData | None]


def mixed_fit(fits: list[tuple[RollFit, float]]) -> RollFit:
    """The heaviest of several models (given first), with the coefficients of all of them by weight."""
    first = fits[0][0]
    if len(fits) == 1:
        return first
    weights = np.array([weight for _, weight in fits])
    handed = np.array([fit.handed for fit, _ in fits])
    mean = weights @ handed
    away = handed - mean
    between = (away.T * weights) @ away
    inside = sum(weight * (fit.jacobian @ fit.covariance @ fit.jacobian.T) for fit, weight in fits)
    return replace(first, mixed=Mixed(mean, np.asarray(inside + between), np.asarray(between)))


def fit_models(data: RollData, asked: Asked, sure: RollFit | None = None) -> RollFit:
    """The models that the stretches of the drive leave standing, fitted to all of it and mixed by their weights.

    sure: the fit in the sure band, to start from in the whole one. Where the usual model misses it by far, that one stands alone.

    Beyond MOST_ROWS the liveliest stretches say which parts are needed, and the model with these stands alone: several on half an hour
    would cost ten times as much as one.
    """
    near = None if sure is None else sure.values
    # what does not agree with the sure band is not taken (`holds`): none is sought far from it
    base = fit_roll(data, asked.known(data, STANDARD), asked.edges, near, close=sure is not None)
    if base.explained < LEAST_TRIED or (sure is not None and hopeless(sure, base)):
        return base
    if data.size > MOST_ROWS:
        return _of_liveliest(data, asked, base)
    verdict = select_parts(data, lambda parts: asked.known(data, parts), base.values)
    fits: list[tuple[RollFit, float]] = []
    for parts, weight in verdict.models:
        try:
            fits.append((fit_roll(data, asked.known(data, parts), asked.edges, base.values), weight))
        except np.linalg.LinAlgError:
            # a model that ran away: the others, or the one that every suspension has, stand for it
            continue
    settled = [pair for pair in fits if pair[0].converged] or fits
    if not settled:
        return base
    total = sum(weight for _, weight in settled)
    return replace(mixed_fit([(fit, weight / total) for fit, weight in settled]), verdict=verdict)


def _of_liveliest(data: RollData, asked: Asked, base: RollFit) -> RollFit:
    """The usual model (`base`, of all data) with what the liveliest stretches ask for on top."""
    part = asked.liveliest(MOST_ROWS)
    if part is None or part.size == 0:
        return base
    verdict = replace(
        select_parts(part, lambda parts: asked.known(part, parts), base.values),
        liveliest_s=part.size * part.step_s,
    )
    if verdict.supported <= STANDARD:
        return replace(base, verdict=verdict)
    try:
        fit = fit_roll(data, asked.known(data, STANDARD | verdict.supported), asked.edges, base.values)
    except np.linalg.LinAlgError:
        # it stood on its part and runs away on the whole: the usual one stands
        return base
    # as does the usual one where the other finds no end
    return base if base.converged and not fit.converged else replace(fit, verdict=verdict)


def fit_best(sure: RollData, whole: Callable[[], RollData | None], asked: Asked) -> tuple[RollData, RollFit]:
    """Data and fit to go on with.

    The sure band ends where the input falls to 0.005 of its peak. On a plant like the model it loses a factor of two of b; on
    vehicles with tyres, friction and filters the whole band gave damping 40 % off with a claim of 20 %. So the whole band
    is taken where it is seen to hold, and where the input has motion beyond the roll mode: short of that, noise and motion
    tell equally much there.
    """
    fit = fit_models(sure, asked)
    if sure.size > MOST_ROWS or fit.explained < 0.5:
        return sure, fit
    data = whole()
    if data is None or data.size != sure.size:
        return sure, fit
    other = fit_models(data, asked, fit)
    return (data, replace(other, whole_band=True)) if holds(fit, other) else (sure, fit)
