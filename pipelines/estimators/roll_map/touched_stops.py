"""A roll gradient of springs that meet their bump stops is one of that drive's bends: at rest, and in gentle ones, the body rolls further."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from parsers.signals import WHEELS
from pipelines.prepare.prepared import Prepared
from pipelines.results import ParameterEstimate
from pipelines.vehicles.kinematics import AXLES, free_travel
from pipelines.vehicles.vehicle import Vehicle

OFTEN = 0.01
"""Share of the rows that were fitted, with a wheel on its stop, from which the gradient is no longer the springs' alone."""

STOPS_STD = 0.1
"""Of the gradient: what stops make of it, about as much as was found on simulated vehicles that rest near them."""


def stops_touched(prepared: Prepared, rows: NDArray[np.int64], vehicle: Vehicle) -> float:
    """Share of the rows (n,) in which a wheel is beyond the free travel that the vehicle file states; nought where it is silent."""
    free = free_travel(vehicle)
    if free is None:
        return 0.0
    beyond = np.zeros(len(rows), dtype=np.bool_)
    for wheel in WHEELS:
        deflection = prepared.columns.get(f"suspension_deflection_{wheel}")
        if deflection is not None:
            beyond |= deflection[rows] > free[next(axle for axle in AXLES if axle[0] == wheel[0])]
    return float(np.mean(beyond)) if len(rows) else 0.0


def with_stops(gradient: ParameterEstimate, touched: float) -> ParameterEstimate:
    """The roll gradient as sure as it is at rest, where stops were touched in more than OFTEN of the rows: no more than weak."""
    if touched < OFTEN or gradient.value is None or gradient.std is None:
        return gradient
    std = math.hypot(gradient.std, STOPS_STD * gradient.value)
    half = 1.96 * std
    words = (
        f"bump stops were touched in {touched:.0%} of the bends, and held the body: at rest it rolls further"
    )
    return replace(
        gradient, std=std, low=gradient.value - half, high=gradient.value + half, inner=(),
        status="weak" if gradient.status == "identified" else gradient.status, reason=f"{words}; {gradient.reason}",
        refused=f"{words}; ",
    )  # fmt: skip
