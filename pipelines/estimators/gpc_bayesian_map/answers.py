"""From a fit to parameters of the report: spread, status, words."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pipelines.bayes.priors import Known, Priors
from pipelines.estimators.gpc_bayesian_map.body import Figure
from pipelines.estimators.gpc_bayesian_map.chosen import SETTINGS_FILE
from pipelines.estimators.gpc_bayesian_map.fit import Fit
from pipelines.models.record import Model
from pipelines.parameters import PARAMETERS
from pipelines.results import FloatArray, ParameterEstimate, Prior
from pipelines.vehicles.vehicle import Vehicle

IDENTIFIED_SHARE, WEAK_SHARE = 0.1, 0.25
"""Largest standard deviations, as a share of the value, of a parameter that is identified or told at all."""

UNEXPLAINED = 0.2
"""Error of a parameter for each share of the outputs that does not follow from the model."""

TAUGHT, WELL_TAUGHT = 0.9, 0.5
"""A posterior wider than this share of its prior taught nothing; narrower than the second, much."""


def spread(
    found: Fit, model: Model, priors: Priors, error_scale: float = 1.0, further: float = 0.0
) -> FloatArray:
    """Covariance (d, d) of the parameters: the posterior's grown by the blocks' scatter, given figures, model error.

    further: a share of each value that this drive adds to the model's error.
    """
    posterior = found.found.posterior
    values = posterior.map_value
    # a surrogate that is not exact may have its densest point elsewhere by as much of a spread
    error = found.found.error if np.isfinite(found.found.error) else 0.0
    covariance = posterior.covariance * np.outer(found.growth, found.growth) * (1 + error**2)
    logs = np.array([item.log for item in priors.items])
    scale = np.where(logs, values, 1.0)
    for shift in found.shifts.values():
        moved = shift * scale
        covariance = covariance + np.outer(moved, moved)
    # what a model leaves unexplained it may have explained by wrong parameters
    unsaid = np.hypot(UNEXPLAINED * (1 - found.explained), further)
    shares = np.array([np.hypot(spec.model_error, unsaid) for spec in model.parameters])
    errors = error_scale * shares * np.abs(values)
    return np.asarray(covariance + np.diag(errors**2))


def told(model: Model) -> tuple[str, ...]:
    """The parameters of `pipelines.parameters` that a model's own parameters are."""
    return tuple(p.name for p in model.parameters if p.name in PARAMETERS and not p.nuisance)


def own_figures(model: Model, values: Mapping[str, float], stds: Mapping[str, float]) -> dict[str, Figure]:
    """The model's parameters as they stand."""
    return {name: Figure(values[name], stds[name], model.title) for name in told(model)}


def answer(
    name: str,
    figure: Figure,
    vehicle: Vehicle,
    source: str,
    known: Known | None,
    at_edge: bool,
) -> ParameterEstimate:
    """One parameter with its status. known: its prior in the engine, where the parameter is one of the model's own."""
    reference = vehicle.reference.get(name)
    prior = figure.prior
    if known is not None:
        prior = Prior(known.distribution.mean, known.distribution.std, known.source)
    unsure = ""
    share = figure.std / max(abs(figure.value), 1e-12)
    if at_edge:
        unsure = "the densest value lies at the end of its prior: widen the prior, or the model does not hold"
    elif prior is not None and figure.std > TAUGHT * prior.std:
        unsure = "the drive taught no more than was known before"
    elif figure.value <= 0 or share > WEAK_SHARE:
        unsure = "too uncertain"
    if unsure:
        said = f"{unsure} ({figure.value:.4g} ± {figure.std:.2g}: {figure.said})"
        return _nothing(name, said, prior, reference)
    half = 1.96 * figure.std
    taught = prior is None or figure.std < WELL_TAUGHT * prior.std
    identified = taught and share <= IDENTIFIED_SHARE
    return ParameterEstimate(
        name, figure.value, figure.std, figure.value - half, figure.value + half,
        "identified" if identified else "weak", figure.said + _set_aside(name, prior, vehicle), prior, reference, (source,),
    )  # fmt: skip


def _set_aside(name: str, prior: Prior | None, vehicle: Vehicle) -> str:
    """In words, what the vehicle file states of a parameter whose prior the user wrote for this run."""
    stated = vehicle.get(name)
    if stated is None or prior is None or prior.source != SETTINGS_FILE:
        return ""
    return (
        f"; with the settings file's prior ({prior.value:.4g} ± {prior.std:.2g}), which sets the vehicle file's {stated.value:.4g} ± "
        f"{stated.std:.2g} aside"
    )


def _nothing(name: str, reason: str, prior: Prior | None, reference: float | None) -> ParameterEstimate:
    if prior is None or not math.isfinite(prior.std):
        return ParameterEstimate(name, None, None, None, None, "not_identifiable", reason, None, reference)
    half = 1.96 * prior.std
    return ParameterEstimate(
        name, prior.value, prior.std, prior.value - half, prior.value + half, "not_identifiable",
        f"{reason}; the figures are the prior's", prior, reference, ("prior",),
    )  # fmt: skip


def nothing(
    names: tuple[str, ...], vehicle: Vehicle, reason: str, priors: Priors | None = None
) -> dict[str, ParameterEstimate]:
    """All parameters as not identifiable."""
    known = {item.name: item for item in priors.items} if priors is not None else {}
    found = {}
    for name in names:
        item = known.get(name)
        prior = (
            Prior(item.distribution.mean, item.distribution.std, item.source) if item is not None else None
        )
        found[name] = _nothing(name, reason, prior, vehicle.reference.get(name))
    return found
