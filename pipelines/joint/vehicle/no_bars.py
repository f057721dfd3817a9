"""Anti-roll bars that a vehicle file states as nought at both axles: a vehicle without any, or one whose bars nobody looked up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pipelines.joint.vehicle.unknowns import AXLES, Known
from pipelines.vehicles.anti_roll import usual_bar
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.vehicle import Vehicle

NOT_LOOKED_UP = 0.1
"""Chance that the latter is so. A nought is what tables are filled with, and cars or vans with no bar at all are few on the road (a front
axle has one as a rule, a rear one often none) and many among simple models, whose files say so."""

KEYS = {axle: f"anti_roll_stiffness_{axle}_nmprad" for axle in AXLES}


def bars_not_looked_up(known: Known, vehicle: Vehicle) -> Mapping[str, tuple[float, float]]:
    """The bars that such a vehicle has beside its springs, where it has any: unknown -> N m/rad, spread. Empty where the file states one,
    or nothing; of lorries and buses too, many of which have leaf springs alone."""
    stated = [vehicle.get(key) for key in KEYS.values()]
    if kind_of(vehicle) == "heavy" or any(q is None or q.value != 0 for q in stated):
        return {}
    rest = {key: q for key, q in vehicle.quantities.items() if key not in KEYS.values()}
    usual = {axle: usual_bar(axle, replace(vehicle, quantities=rest)) for axle in AXLES}
    return {
        f"bar_{axle}": (float(known.mean[known.index(f"bar_{axle}")]) + bar.value, bar.std)
        for axle, bar in usual.items()
    }
