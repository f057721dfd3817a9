"""Do an axle's springs still work as springs? A load that sets the body on its bump stops, or on helper leaves, makes them others.

What such a wheel carries at rest is then no longer its deflection times the rate, it is stiffer inwards than outwards, and the left
one, which a load at one side presses harder, is not as stiff as the right one. No balance by deflections knows where stops begin. So
where a drive contradicts itself the relations are joined again with all of it open at one axle (each wheel's rate and force at rest,
how the rate rises), and the two fits are compared as those of rigid tyres are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from pipelines.evidence import Evidence, Values
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.suspension import levelled_n
from pipelines.joint.vehicle.unknowns import AXLES, Known
from pipelines.joint.ways.file_ways import joined_again
from pipelines.joint.ways.rigid_tyres import log_odds
from pipelines.joint.ways.travel_scale import GYRO_BESIDE_SPRINGS
from pipelines.results import FloatArray
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.vehicle import Vehicle

CHANCE = {"car": 0.01, "carrier": 0.05, "heavy": 0.05}
"""Chance beforehand that a drive was made so, at the rear: overloaded cars, helper leaves of vans and pickups. At the front a tenth."""

RATE = 0.6
"""Spread of a wheel's rate over the spring's, about 1: stops are three to six times as hard, and carry only inwards."""

WIDER = {"stop": 8.0, "square": 10.0, "cube": 10.0}
"""By what factor the rate's rise is less known than that of a free spring."""

NAME = "{} springs that rest on stops or helpers"
TEXT = "{} springs that rest on stops or helpers under the load: the drive fits no free ones, and was joined with their rates open"


def on_stops(known: Known, axle: str, vehicle: Vehicle) -> Known:
    """The unknowns with one axle's springs open."""
    kilos = float(known.mean[known.index("empty_mass")])
    std = known.std.copy()
    for side in "lr":
        wheel = f"{axle[0]}{side}"
        std[known.index(f"scale_{wheel}")] = RATE
        row = known.index(f"zero_{wheel}")
        std[row] = max(std[row], levelled_n(vehicle, kilos))
    for part, factor in WIDER.items():
        std[known.index(f"{part}_{axle}")] *= factor
    return replace(known, std=std)


def _as_travel(relation: Evidence, wheels: frozenset[str]) -> Evidence:
    """A relation that sees the wheels' travel and not what it takes: stops are no other scale there."""
    if relation.carrier != GYRO_BESIDE_SPRINGS or not wheels & {*relation.unknowns}:
        return relation

    def predict(values: Values) -> FloatArray:
        right = {name: np.ones_like(np.asarray(values[name], dtype=float)) for name in wheels}
        return relation.predict(cast("Values", {**values, **right}))

    return replace(relation, predict=predict)


def stop_ways(
    free: Joint, evidence: Sequence[Evidence], known: Known, vehicle: Vehicle
) -> Iterator[tuple[str, float, Joint, Known, tuple[Evidence, ...]]]:
    """For each axle: its name, ln odds with the log that its springs rest on stops, the posterior with that, its unknowns and relations.

    Nothing where no relation has the deflections of both wheels.
    """
    for axle in AXLES:
        wheels = frozenset(f"scale_{axle[0]}{side}" for side in "lr")
        if not any(wheels <= {*e.unknowns} for e in evidence if e.source != "vehicle file"):
            continue
        open_ = on_stops(known, axle, vehicle)
        seen = tuple(_as_travel(e, wheels) for e in evidence)
        found = joined_again(free, seen, known, open_)
        chance = CHANCE[kind_of(vehicle)] * (1.0 if axle == "rear" else 0.1)
        yield axle, log_odds(free, found) + math.log(chance / (1 - chance)), found, open_, seen
