"""Track and traces of the integrated observer for the report."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.integrated_observer.core import Observed
from pipelines.estimators.integrated_observer.spread import Setup
from pipelines.models.braking import drag
from pipelines.models.roll import DEGREES, GRAVITY
from pipelines.results import FloatArray, Trace, Track

MOST_POINTS = 400


def height_track(time_s: FloatArray, height: FloatArray, std: float) -> Track:
    """h^_int over the drive with the final interval about it."""
    good = np.flatnonzero(np.isfinite(height))
    picked = good[
        np.unique(np.linspace(0, len(good) - 1, min(MOST_POINTS, len(good))).round().astype(np.int64))
    ]
    value = height[picked]
    return Track("cg_height_m", time_s[picked], value, value - 1.96 * std, value + 1.96 * std)


def observer_traces(time_s: FloatArray, setup: Setup, observed: Observed, height: float) -> tuple[Trace, ...]:
    """Roll angle against the observer's, and the front axle's share of the load against (41)."""
    found: list[Trace] = []
    if observed.roll is not None:
        roll = observed.roll
        found.append(
            Trace(
                "roll observer",
                time_s,
                {
                    "integrated roll rate": DEGREES * roll.angle,
                    "observer": DEGREES * roll.roll,
                    "residual": DEGREES * (roll.angle - roll.roll),
                },
                {"integrated roll rate": "deg", "observer": "deg", "residual": "deg"},
                "Park & Choi (22), (38)",
            )
        )
    if observed.brake is not None and observed.brake.active.any():
        car, data = setup.car, setup.data
        moved = height * (data.f_x + drag(data.speed, car.drag_area_m2) / car.mass_kg)
        model = (GRAVITY * car.rear_m - moved) / (GRAVITY * car.wheelbase_m)
        model = np.where(observed.brake.active, model, np.nan)
        measured = observed.brake.share
        found.append(
            Trace(
                "front axle load in braking",
                time_s,
                {
                    "from slips (8)": 100 * measured,
                    "from height (41)": 100 * model,
                    "residual": 100 * (measured - model),
                },
                {"from slips (8)": "%", "from height (41)": "%", "residual": "%"},
                "share of the weight on the front axle",
            )
        )
    return tuple(found)
