"""Springs that stiffen under the outer wheels, of which the vehicle file is silent: seen by the body that rises in bends.

On springs that are straight lines the outer wheels go in by as much as the inner ones come out. Where the outer ones are on their stops, or
on springs that stiffen, they go in by less, and the axle's mean deflection falls with the lean, whichever way it is:

    (z_l + z_r) / 2 = c + k f_x + d v² + g (z_r - z_l) / 2 + r |z_r - z_l| / 2

Links that lift in bends make r 0 to -0.2. A gradient of such a drive is that of its bends: at rest the body rolls further.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.estimators.roll_map.touched_stops import SEEN, as_at_rest, stops_touched, with_stops
from pipelines.prepare.block_slope import block_slopes
from pipelines.prepare.prepared import Prepared
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

BY_LINKS, BY_STOPS = 0.2, 0.3
"""-r that links and springs' usual curves make at most, and from which on a gradient is STIFFER_STD unsure: on 344 random drives of the plant
and 55 of a blind author's simulator gradients are right within their spreads up to 0.25, and 3 to 12 % too small from 0.3 on."""
STIFFER_STD = 0.1
"""Of the gradient; in proportion from BY_LINKS on."""
OFTEN = 0.3
"""Share of that from which on the gradient is not the springs' at rest."""
MOVES, PEDALS = 3.0, 1.5
"""m/s from which, and m/s² of longitudinal acceleration up to which, rows are taken."""
LEAST_LEAN_M = 0.005
"""Spread of (z_r - z_l) / 2 below which nothing shows."""
APART = 0.3
"""Share of the spread of |z_r - z_l| / 2 that the other columns have to leave of it."""


@dataclass(frozen=True)
class RisesInBends:
    """slope: -r of the axle where it is largest. share: of STIFFER_STD, 0 to 1, by how far it is beyond what links do, less its own spread."""

    slope: float
    share: float


NOT_SEEN = RisesInBends(0.0, 0.0)


def rises_in_bends(prepared: Prepared, rows: NDArray[np.int64]) -> RisesInBends:
    """Of the rows (n,); `NOT_SEEN` without deflections of both wheels of an axle beside speed and longitudinal acceleration."""
    speed, along = prepared.columns.get("speed"), prepared.columns.get("accel_x")
    most = NOT_SEEN
    if speed is None or along is None:
        return most
    taken = rows[(speed[rows] > MOVES) & (np.abs(along[rows]) < PEDALS)]
    for axle in "fr":
        left, right = (prepared.columns.get(f"suspension_deflection_{axle}{side}") for side in "lr")
        if left is None or right is None:
            continue
        lean, mean = 0.5 * (right - left)[taken], 0.5 * (right + left)[taken]
        if not np.isfinite(lean).any() or float(np.nanstd(lean)) < LEAST_LEAN_M:
            continue
        # in a circle driven faster and faster the lean's size goes with the square of the speed, and tells nothing of its own
        size, beside = np.abs(lean), np.column_stack([along[taken], speed[taken] ** 2, lean])
        told = block_slopes(size, (mean,), beside, APART * float(np.nanstd(size)), 1 / prepared.rate_hz)
        if told is not None and -told.values[0] > most.slope:
            beyond = (-told.values[0] - told.std - BY_LINKS) / (BY_STOPS - BY_LINKS)
            most = RisesInBends(-told.values[0], min(max(beyond, 0.0), 1.0))
    return most


def with_rise(gradient: ParameterEstimate, seen: RisesInBends) -> ParameterEstimate:
    """The roll gradient as sure as it is at rest, where the body rose in the bends by more than links do."""
    if seen.share <= 0:
        return gradient
    words = (
        f"the body rises in bends, as on bump stops or springs that stiffen under the outer wheels (an axle's mean deflection falls by {seen.slope:.0%} "
        "of half the wheels' difference): at rest it rolls further (bump_stop_clearance_* says where stops begin)"
    )
    return as_at_rest(gradient, STIFFER_STD * seen.share, words, held=seen.share >= OFTEN)


def of_free_springs(
    gradient: ParameterEstimate, prepared: Prepared, rows: NDArray[np.int64], vehicle: Vehicle
) -> ParameterEstimate:
    """The roll gradient as sure as it is at rest: by stops that the file places or forces show, else by the body that rises in bends."""
    touched = stops_touched(prepared, rows, vehicle)
    if touched >= SEEN:
        return with_stops(gradient, touched)
    return with_rise(gradient, rises_in_bends(prepared, rows))
