"""From particles to what the log can tell: a = K/(m h), b = D/(m h), c = I/(m h) + h - z, with an honest covariance.

K, D and h of a particle hang on the mass and inertia that it was given, and on one body about an axis on the ground. Only
a, b and c show in the motion (`pipelines.models.roll`); from them the vehicle follows by the draws of `roll_map`, which
know of unsprung masses, roll axis, tyres and mirror. Added here to the clouds' spread: correlated residuals, the model's
own error, dry friction, and what is not known of the channels' delay.
"""

from __future__ import annotations

import numpy as np

from pipelines.estimators.marginalized_particle_filter.inputs import Inputs, spread_over_time
from pipelines.estimators.marginalized_particle_filter.run import Clouds
from pipelines.estimators.roll_map.answers import (
    DISCREPANCY,
    DISCREPANCY_AXLES,
    LEFT_OVER,
    LEFT_OVER_AXLES,
    Coefficients,
)
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.model import known_parameters
from pipelines.filters.marginalized_particle.records import Cloud
from pipelines.results import FloatArray

NAMES = ("a", "b", "c")
FRICTION_MPS2 = 0.08
"""Lateral acceleration that dry friction may be worth."""


def moments_of(cloud: Cloud) -> tuple[FloatArray, FloatArray]:
    """Mean (3,) and covariance (3, 3) of a, b, c over a cloud."""
    stiffness, damping, height, mass, inertia, sensor = cloud.theta.T
    moment = mass * height
    table = np.array([stiffness / moment, damping / moment, inertia / moment + height - sensor])
    weight = cloud.weights / cloud.weights.sum()
    mean = table @ weight
    away = table - mean[:, None]
    return mean, np.asarray((away * weight) @ away.T)


def pooled(clouds: list[Cloud]) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance of several clouds on the same data: within them, and between their means once and 1/r more."""
    found = [moments_of(cloud) for cloud in clouds]
    means = np.array([mean for mean, _ in found])
    within = np.mean([covariance for _, covariance in found], axis=0)
    if len(found) < 2:
        return means[0], np.asarray(within)
    between = np.cov(means.T)
    return means.mean(axis=0), np.asarray(within + (1 + 1 / len(found)) * between)


def inflation(clouds: Clouds, step_s: float) -> float:
    """Factor on the covariance for innovations that are larger than stated, or correlated."""
    factors = []
    for run in clouds.runs:
        normalised = run.innovation / run.innovation_std
        # the first rows hold the start's error
        factors += [spread_over_time(column[5:], step_s) for column in normalised.T]
    return float(np.median(factors)) if len(factors) < 4 else float(np.quantile(factors, 0.75))


def wander(means: FloatArray, last: FloatArray) -> FloatArray:
    """(3, 3) mean square by which the running estimate (s, 3) strays from its last value, the first third left out.

    A vehicle's coefficients stand still: where a filter that follows them strays, its model fits one part of the drive and
    not the other.
    """
    away = means[len(means) // 3 :] - last
    return np.asarray(away.T @ away / max(len(away), 1))


def honest(
    mean: FloatArray, covariance: FloatArray, data: RollData, inputs: Inputs, scale_std: float
) -> Coefficients:
    """a, b, c for the second stage: the clouds' covariance, plus what the model and the channels do not know."""
    table, left = (DISCREPANCY_AXLES, LEFT_OVER_AXLES) if data.against_axles else (DISCREPANCY, LEFT_OVER)
    own = np.array([table.get(name, 0.0) for name in NAMES]) * mean
    # in phase with the angle, friction is in either: the larger of both
    parts = np.array([max(left, FRICTION_MPS2 / max(float(np.std(data.accel)), 1e-6)), left, left])
    own = np.hypot(own, parts * mean[0] / max(data.quickness, 0.1) ** np.arange(3))
    usual = {k.name: k for k in known_parameters(data, None, 0.2, inputs.delay_std_s, None)}
    # springs that stiffen: K φ (1 + s φ²) looks like K (1 + 3/4 s φ²) at an amplitude φ
    lean = float(np.quantile(np.abs(data.accel - np.median(data.accel)), 0.95)) / max(float(mean[0]), 1.0)
    own[0] = np.hypot(own[0], 0.75 * usual["stiffening"].std * lean**2 * mean[0])
    late = np.array([0.0, mean[0], mean[1]]) * inputs.delay_std_s
    scaled = scale_std * mean
    total = covariance + np.diag(own**2) + np.outer(late, late) + np.outer(scaled, scaled)
    weak_mean, weak_std = (np.array([getattr(usual[n], part) for n in NAMES]) for part in ("mean", "std"))
    # what any road vehicle is like keeps apart what a slow drive leaves open; the second stage takes it out again
    gain = total @ np.linalg.inv(total + np.diag(weak_std**2))
    kept = total - gain @ total
    return Coefficients(NAMES, mean + gain @ (weak_mean - mean), 0.5 * (kept + kept.T), weak_mean, weak_std)
