"""An estimate with whole distributions over the drive, for the report's tests: one that narrows, one with two peaks."""

from __future__ import annotations

import numpy as np

from pipelines.results import Distribution, Estimate

LEVELS = (0.025, 0.1, 0.25, 0.5, 0.75, 0.9, 0.975)
NORMAL = np.array([-1.96, -1.2816, -0.6745, 0.0, 0.6745, 1.2816, 1.96])


def distribution(parameter, middle, spread, *, note="", seconds=84.0, count=40):
    """Normal quantiles around `middle` that narrow to `spread` over the drive."""
    time = np.linspace(0.5, seconds, count)
    std = spread * (1 + 6 / (1 + time / 4))
    moved = middle + 0.5 * spread * np.sin(time / 7)
    return Distribution(parameter, time, LEVELS, tuple(moved + z * std for z in NORMAL), note)


def particle_filter(note="Of the filter's particles."):
    """A witness that follows three distributions."""
    return Estimate(
        "marginalized_particle_filter", "ran", "the filter ran over the drive", witness=True, used_fraction=0.5, runtime_s=2.0,
        distributions=(
            distribution("roll_stiffness_nmprad", 61000.0, 1800.0, note=note),
            distribution("roll_damping_nmsprad", 5400.0, 300.0, note=note),
            distribution("cg_height_m", 0.56, 0.02, note=note),
        ),
    )  # fmt: skip
