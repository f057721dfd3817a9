"""A roll gradient of springs that meet their bump stops is one of that drive's bends: at rest, and in gentle ones, the body rolls further.

Where the file says how far a wheel goes until then, its deflections tell; where it is silent, forces in the struts beside them, as a
wheel's force is a straight line of its travel (and of how far it is ahead of the other wheel, by a bar, and of its speed) up to a stop:

    F = c + k z + b (z - z_other) + d (z')+ + e (z')- + s (z - z_stop)+
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from parsers.signals import WHEELS
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.kinematics import AXLES, free_travel
from pipelines.vehicles.vehicle import Vehicle

OFTEN = 0.01
"""Share of the rows that were fitted, with a wheel on its stop, from which the gradient is no longer the springs' alone."""

STOPS_STD = 0.1
"""Of the gradient: what stops make of it, about as much as was found on simulated vehicles that rest near them."""


TRIED = (0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99)
"""Shares of the rows, by travel, below the places where a stop is looked for."""

STEEPER, EXPLAINED = 1.5, 0.5
"""What a stop adds to a wheel's rate at least, over the spring's, and the share that it takes of the line's residual: progressive
springs bend over all of their travel and leave less than that to a corner."""

LEAST_ROWS = 200


def stops_touched(prepared: Prepared, rows: NDArray[np.int64], vehicle: Vehicle) -> float:
    """Share of the rows (n,) in which a wheel is beyond the free travel that the vehicle file states, or that forces show beside deflections."""
    free = free_travel(vehicle)
    beyond = np.zeros(len(rows), dtype=np.bool_)
    for wheel in WHEELS:
        deflection = prepared.columns.get(f"suspension_deflection_{wheel}")
        if deflection is None:
            continue
        if free is not None:
            beyond |= deflection[rows] > free[next(axle for axle in AXLES if axle[0] == wheel[0])]
        elif (stop := stop_by_force(prepared, rows, wheel)) is not None:
            beyond |= deflection[rows] > stop
    return float(np.mean(beyond)) if len(rows) else 0.0


def stop_by_force(prepared: Prepared, rows: NDArray[np.int64], wheel: str) -> float | None:
    """Deflection in m from which a wheel's force rises as on a stop; None where it does not, or the log lacks a signal."""
    other = wheel[0] + ("r" if wheel[1] == "l" else "l")
    names = (f"suspension_deflection_{wheel}", f"suspension_deflection_{other}", f"suspension_force_{wheel}")
    if not all(name in prepared.columns for name in names):
        return None
    travel, beside, force = (prepared.columns[name] for name in names)
    speed = np.gradient(travel) * prepared.rate_hz
    columns = [
        np.ones(len(travel)),
        travel,
        travel - beside,
        np.maximum(speed, 0),
        np.minimum(speed, 0),
        force,
    ]
    table = np.column_stack(columns)[rows]
    table = table[np.isfinite(table).all(axis=1)]
    if len(table) < LEAST_ROWS:
        return None
    line, z, f = table[:, :-1], table[:, 1], table[:, -1]
    places = np.quantile(z, TRIED)
    fits = [_fit(np.column_stack([line, np.maximum(z - at, 0)]), f) for at in places]
    left, gains = min(fits, key=lambda fit: fit[0])
    whole, _ = _fit(line, f)
    rate, more = gains[1], gains[-1]
    if rate <= 0 or more < STEEPER * rate or left > (1 - EXPLAINED) * whole:
        return None
    return float(places[[fit[0] for fit in fits].index(left)])


def _fit(table: FloatArray, force: FloatArray) -> tuple[float, FloatArray]:
    """Sum of squares that a line leaves, and its gains."""
    gains, *_ = np.linalg.lstsq(table, force, rcond=None)
    rest = force - table @ gains
    return float(rest @ rest), np.asarray(gains, dtype=np.float64)


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
