"""The balances fitted again with axle loads that are what springs carry, where the vehicle file does not say which they are.

Bellows' pressures lack what the links carry in braking and driving, a third of a lorry's load transfer. From a fit of tyres' loads that is
too far off for a doubt along straight lines (`pipelines.joint.doubts`): so both are fitted, and the answers hold both by their chances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipelines.estimators.load_balance.relations import Relation
from pipelines.estimators.load_balance.solve import Fit, solve
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.weighed import Weighed
from pipelines.joint.vehicle.unknowns import BY_SPRINGS
from pipelines.joint.ways.bellows_way import of_springs
from pipelines.vehicles.axle_loads import by_springs
from pipelines.vehicles.vehicle import Vehicle

Fitted = tuple[float, Fit, Sequence[Weighed]]
"""Chance with the log, the fit, and its doubts."""


def _evidence(fit: Fit) -> float:
    """ln of how well a kind of loads explains the balances (Laplace), up to what both kinds share."""
    misfit = float(fit.u @ fit.u) + sum(reduced.chi2 for reduced in fit.reduced)
    return 0.5 * (float(np.linalg.slogdet(fit.covariance)[1]) - misfit)


def by_both(found: Sequence[Relation], fit: Fit, vehicle: Vehicle, *, doubted: bool) -> tuple[Fitted, ...]:
    """The fit by itself, or with the one of springs' loads, the likelier first. doubted: whether doubts are asked for at all."""
    row = fit.known.index(BY_SPRINGS)
    if vehicle.axle_load_by is not None or not any(row in relation.unknowns for relation in found):
        return ((1.0, fit, doubts_of(fit, vehicle) if doubted else ()),)
    other, chance = solve(tuple(found), of_springs(fit.known)), by_springs(vehicle)
    odds = _evidence(other) - _evidence(fit) + math.log(chance / (1 - chance))
    share = 1 / (1 + math.exp(min(max(-odds, -50.0), 50.0)))
    both = [
        (weight, each, doubts_of(each, replace(vehicle, axle_load_by=by)) if doubted else ())
        for weight, each, by in ((1 - share, fit, "tires"), (share, other, "springs"))
    ]
    return tuple(sorted(both, key=lambda one: -one[0]))
