"""Tyre forces as the suspension map's estimator gives them, without having run it."""

from __future__ import annotations

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import Estimate, ParameterEstimate
from pipelines.tire_forces import TireForces, forces_as_traces

TIME = np.linspace(0.0, 20.0, 400)
FORCE = {w: 4000.0 + 100.0 * i + 500.0 * np.sin(TIME) for i, w in enumerate(WHEELS)}


def mapped(**diagnostics: float) -> Estimate:
    """An estimate as the suspension map gives it."""
    low, high = ({w: f + side for w, f in FORCE.items()} for side in (-120.0, 120.0))
    forces = TireForces(TIME, FORCE, low, high, False, "map", 10.0)
    entry = ParameterEstimate("tire_normal_force_fl_n", 4000.0, 60.0, 3880.0, 4120.0, "identified", "at rest")
    return Estimate(
        "suspension_mapping", "ran", "from struts", {entry.name: entry},
        traces=forces_as_traces(forces, {"fl": FORCE["fl"] + 10.0}),
        diagnostics={"least_force_fl_n": 3500.0, "least_force_time_fl_s": 4.7, **diagnostics},
    )  # fmt: skip
