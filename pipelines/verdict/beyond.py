"""Is the vehicle one that anybody has measured? A height far beyond all of its body style is a wrong figure in the vehicle file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipelines.results import ParameterEstimate
from pipelines.vehicles.priors import known_body, measured_vehicles
from pipelines.vehicles.vehicle import Vehicle

LOW, HIGH = 0.92, 1.35
"""Share of the lowest measured CG height of a body style, of all vehicles of it, below which none is taken to be; and of the highest: a
load on the roof lifts it by a fifth at most."""

FEWEST = 20
"""Measured vehicles of a style from which on it has a lowest and a highest."""

SURELY = 1.64
"""Standard deviations by which the answer must lie beyond."""


def beyond_measured(
    parameters: Mapping[str, ParameterEstimate], vehicle: Vehicle
) -> dict[str, ParameterEstimate]:
    """The answers; none of them is identified where the CG stands where it stands in no measured vehicle of the body style.

    Balances tell products (mass times height, stiffness over both): one figure of the file that is wrong by a factor goes into all.
    """
    found, height = dict(parameters), parameters.get("cg_height_m")
    style = known_body(vehicle.body)
    if (
        style is None
        or height is None
        or height.value is None
        or height.std is None
        or height.status == "not_identifiable"
    ):
        return found
    table = measured_vehicles()
    same = table.height[np.array([body == style for body in table.body])]
    if len(same) < FEWEST:
        return found
    lowest, highest = float(same.min()), float(same.max())
    if height.value + SURELY * height.std < LOW * lowest:
        where, limit = "low", lowest
    elif height.value - SURELY * height.std > HIGH * highest:
        where, limit = "high", highest
    else:
        return found
    words = (
        f"no measured {style} has its CG so {where} ({height.value:.2f} m; the {where}est of {len(same)}: {limit:.2f} m): check the vehicle "
        "file's mass, rates and lengths and the log's units; "
    )
    return {
        name: replace(entry, status="weak", reason=words + entry.reason)
        if entry.status == "identified"
        else entry
        for name, entry in found.items()
    }
