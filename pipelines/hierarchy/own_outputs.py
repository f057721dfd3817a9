"""A drive's parameters at given unknowns, and their derivatives, by central differences in one call."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.results import FloatArray

STEP = 1e-3
"""Of the unknowns' standard deviations before the log."""


def outputs_at(
    names: tuple[str, ...], at: FloatArray, std: FloatArray, given: Mapping[str, float]
) -> tuple[dict[str, float], dict[str, FloatArray]]:
    """Parameters at (k,) unknowns, SI, and their derivatives (k,) each. std: (k,) sizes of the steps' unit."""
    size = len(names)
    steps = np.diag(STEP * std)
    moved = np.concatenate([at[None], at + steps, at - steps])
    found = outputs_of(dict(zip(names, moved.T, strict=True)), given)
    whole = {name: np.broadcast_to(column, len(moved)) for name, column in found.items()}
    values = {name: float(column[0]) for name, column in whole.items()}
    slopes = {n: (c[1 : 1 + size] - c[1 + size :]) / (2 * STEP * std) for n, c in whole.items()}
    return values, slopes
