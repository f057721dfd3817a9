"""What the report shows: estimates as intervals came in, posterior densities, fits and residuals over time."""

from __future__ import annotations

import numpy as np

from pipelines.bayes.priors import Priors
from pipelines.estimators.gpc_bayesian_map.data import ModelData
from pipelines.estimators.gpc_bayesian_map.fit import Fit
from pipelines.models.record import Model
from pipelines.parameters import PARAMETERS
from pipelines.results import FloatArray, Scatter, Trace, Track


def tracks(
    found: Fit, model: Model, data: ModelData, time_s: FloatArray, covariance: FloatArray
) -> tuple[Track, ...]:
    """Of the model's parameters that the report knows: MAP and 95 % interval after each interval."""
    steps = found.found.steps
    if len(steps) < 2:
        return ()
    last = np.array([group[-1][1] - 1 for group in data.groups])
    ends = time_s[data.blocks.first[last] + data.blocks.rows - 1]
    out = []
    for j, spec in enumerate(model.parameters):
        if spec.name not in PARAMETERS:
            continue
        value = np.array([step.map_value[j] for step in steps])
        chance = np.array([step.std[j] for step in steps]) * found.growth[j]
        # what does not shrink with more data is there from the beginning
        fixed = max(float(covariance[j, j]) - float(chance[-1]) ** 2, 0.0)
        half = 1.96 * np.sqrt(chance**2 + fixed)
        out.append(Track(spec.name, np.asarray(ends), value, value - half, value + half))
    return tuple(out)


def traces(found: Fit, model: Model, data: ModelData, time_s: FloatArray) -> tuple[Trace, ...]:
    """Measured against predicted outputs, offsets taken off as the fit does."""
    out = []
    for o, name in enumerate(model.outputs):
        predicted = found.predicted[:, o]
        there = np.isfinite(predicted)
        if not there.any():
            continue
        measured = np.where(there, data.outputs[:, o], np.nan)
        if data.blocks.frequency_hz[0] > 0:
            measured = measured - np.nanmean(measured)
            predicted = predicted - np.nanmean(predicted)
        columns = {"measured": measured, "model": predicted, "residual": measured - predicted}
        note = f"{model.title}; fitted from {data.blocks.frequency_hz[0]:.2g} to {data.blocks.frequency_hz[-1]:.2g} Hz"
        out.append(Trace(f"fit of {name}", time_s, columns, {}, note))
    return tuple(out)


def densities(found: Fit, model: Model, priors: Priors) -> tuple[Scatter, ...]:
    """Posterior density of each parameter (of the likelihood as it is, before it is widened), beside its prior."""
    posterior = found.found.posterior
    out = []
    for j, spec in enumerate(model.parameters):
        grid, density = posterior.density(j)
        before = priors.items[j].distribution
        top = float(np.interp(posterior.map_value[j], grid, density))
        out.append(
            Scatter(
                f"posterior_{spec.name}",
                f"Posterior density: {spec.title}",
                f"{spec.title} [{spec.unit}]",
                f"density [1/({spec.unit})]",
                np.array([posterior.map_value[j]]),
                np.array([top]),
                grid,
                density,
                density,
                density,
                f"Line: posterior of the fit alone, before model error and given figures widen it. Point: MAP. Prior: {before.mean:.4g} "
                f"± {before.std:.2g} {spec.unit}.",
            )
        )
    return tuple(out)
