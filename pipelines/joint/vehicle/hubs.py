"""How much of the braked hubs' own inertia their links take past the springs: one place for posterior, struts and planes.

Half the wheelbase over the length of the side-view swing arms: none with parallel links, 0.1 to 0.3 with the long arms of front axles,
all of it with arms that point at the middle of the wheelbase (where the axis of pitch stands, in plane models).
"""

from __future__ import annotations

import math

import numpy as np

from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

SHORT_ARMS, MOST = 0.2, 1.1
"""Chance that an axle's arms may be of any length, so that any share up to MOST is as likely: a normal prior about long arms leaves none
of it for an estimator that has no other relation to tell."""

AXLES = ("front", "rear")


def _told(vehicle: Vehicle) -> tuple[float, float, bool]:
    """Mean and standard deviation of the posterior's own prior, and whether the file states it."""
    known = before_the_log(vehicle)
    i = known.names.index("hubs_past")
    stated = all(vehicle.get(f"wheel_recession_{axle}") is not None for axle in AXLES)
    return float(known.mean[i]), float(known.std[i]), stated


def hubs_past_of(vehicle: Vehicle) -> tuple[float, float]:
    """Mean and standard deviation of the share, with room towards all of it where the file is silent."""
    mean, std, stated = _told(vehicle)
    if stated:
        return mean, std
    middle = (1 - SHORT_ARMS) * mean + SHORT_ARMS * MOST / 2
    square = (1 - SHORT_ARMS) * (std**2 + mean**2) + SHORT_ARMS * MOST**2 / 3
    return middle, math.sqrt(square - middle**2)


def hubs_past_draws(vehicle: Vehicle, rng: np.random.Generator, count: int) -> FloatArray:
    """Draws of the share, (count,)."""
    mean, std, stated = _told(vehicle)
    usual = mean + std * rng.standard_normal(count)
    if stated:
        return np.asarray(usual)
    return np.where(rng.random(count) < SHORT_ARMS, rng.uniform(0, MOST, count), usual)
