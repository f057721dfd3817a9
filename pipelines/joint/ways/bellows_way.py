"""Are the axle loads what springs carry? Joined again with such loads, where the vehicle file does not say which they are.

As a doubt (`doubts`) they move answers along straight lines from a mode of tyres' loads. A lorry's links carry a third of its load transfer: from so
far off, a scale of the loads that is wrong looks nearer (a blind author's: CG height -35 % at 14 standard deviations).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from pipelines.evidence import Evidence
from pipelines.joint.doubts.carried import BELLOWS
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.unknowns import BY_SPRINGS, SPRINGS_CARRY, Known
from pipelines.joint.ways.rigid_tyres import log_odds
from pipelines.vehicles.axle_loads import by_springs
from pipelines.vehicles.vehicle import Vehicle

TEXT = f"{BELLOWS}: the drive fits no others, and was joined with such (`axle_load_by` in the vehicle file says so, or denies it)"


def asked(evidence: Sequence[Evidence], vehicle: Vehicle) -> bool:
    """Whether a relation hangs on it, and the file does not say."""
    return vehicle.axle_load_by is None and any(BY_SPRINGS in e.unknowns for e in evidence)


def of_springs(known: Known) -> Known:
    """The unknowns with axle loads that are what springs carry."""
    mean, std = known.mean.copy(), known.std.copy()
    mean[known.index(BY_SPRINGS)], std[known.index(BY_SPRINGS)] = SPRINGS_CARRY
    return replace(known, mean=mean, std=std)


def bellows_ways(
    joint: Joint, evidence: Sequence[Evidence], known: Known, vehicle: Vehicle
) -> Iterator[tuple[float, Joint, Known]]:
    """ln odds with the log that they are, the posterior with them, and its unknowns; nothing where it is not `asked`."""
    if not asked(evidence, vehicle):
        return
    free, start = of_springs(known), joint.u.copy()
    start[known.index(BY_SPRINGS)] = 0.0
    found = find_mode(evidence, free, near=[start])
    chance = by_springs(vehicle)
    yield log_odds(joint, found) + math.log(chance / (1 - chance)), found, free
