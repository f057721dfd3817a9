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
from pipelines.vehicles.kinematics import AXLES, Spread, share_beyond, stop_places
from pipelines.vehicles.vehicle import Vehicle

SEEN, OFTEN = 0.002, 0.03
"""Shares of the rows that were fitted, with a wheel on its stop, from which the gradient is less sure, and no longer the springs' alone."""

STOPS_STD, WHOLE = 0.1, 0.1
"""Of the gradient: what stops make of it where WHOLE of the rows have a wheel on one, about as much as was found on simulated vehicles that
rest near them; in proportion where fewer have."""

TRIED = (0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99)
"""Shares of the rows, by travel, below the places where a stop is looked for."""

STEEPER, EXPLAINED = 1.5, 0.5
"""What a stop adds to a wheel's rate at least, over the spring's, and the share that it takes of the line's residual: progressive
springs bend over all of their travel and leave less than that to a corner."""

LEAST_ROWS = 200


def stops_touched(prepared: Prepared, rows: NDArray[np.int64], vehicle: Vehicle) -> float:
    """Share of the rows (n,) in which a wheel is on the bump stop that the vehicle file places, or that forces show beside deflections.

    Expected over where the stop may begin: a bare figure is good to 10 %, and what comes within its spread of the stop is not on it.
    """
    stated = stop_places(vehicle)
    places: dict[str, Spread] = {}
    for wheel in WHEELS:
        if f"suspension_deflection_{wheel}" not in prepared.columns:
            continue
        if stated is not None:
            places[wheel] = stated[next(axle for axle in AXLES if axle[0] == wheel[0])]
        elif (stop := stop_by_force(prepared, rows, wheel)) is not None:
            places[wheel] = (stop, 0.0)
    if not len(rows):
        return 0.0
    travel = {w: prepared.columns[f"suspension_deflection_{w}"][rows] for w in places}
    return share_beyond(travel, places)


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
    """The roll gradient as sure as it is at rest, where stops were touched in a share of the rows: weak where that is OFTEN or more."""
    if touched < SEEN:
        return gradient
    words = f"bump stops may have been touched in {touched:.1%} of the bends, and held the body: at rest it rolls further"
    return as_at_rest(gradient, STOPS_STD * min(touched / WHOLE, 1.0), words, held=touched >= OFTEN)


def as_at_rest(gradient: ParameterEstimate, share: float, words: str, *, held: bool) -> ParameterEstimate:
    """A roll gradient with a share of itself more in its spread. held: whether it is too unlike that at rest to be identified, as `words` say."""
    if gradient.value is None or gradient.std is None:
        return gradient
    std = math.hypot(gradient.std, share * gradient.value)
    half = 1.96 * std
    return replace(
        gradient, std=std, low=gradient.value - half, high=gradient.value + half, inner=(),
        status="weak" if held and gradient.status == "identified" else gradient.status, reason=f"{words}; {gradient.reason}",
        refused=f"{words}; " if held else gradient.refused,
    )  # fmt: skip
