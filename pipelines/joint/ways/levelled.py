"""Do the springs level themselves? Where the drive says so almost surely, it is joined so.

As a doubt (`pipelines.joint.doubts`) it moves answers along straight lines from a mode at which the load is nought; a load of some
tonnes is too far for that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from pipelines.evidence import Evidence
from pipelines.joint.doubts.carried import LEVELS, level_chance
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.stated_figures import chance_wrong
from pipelines.joint.file_check import LOAD, stated_unknowns
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.unknowns import Known
from pipelines.joint.ways.file_ways import OPEN, joined_again, opened
from pipelines.joint.ways.rigid_tyres import log_odds
from pipelines.vehicles.vehicle import Vehicle

SURE = 0.7
"""Weight among all doubts from which on the springs are taken so."""
HEARD = 0.02
"""The same from which on they are asked for where something contradicts the rest."""

TEXT = f"{LEVELS}: the drive fits no others, and was joined with such (`self_levelling` in the vehicle file says so, or denies it)"


def as_levelled(joint: Joint, vehicle: Vehicle) -> tuple[Vehicle, bool] | None:
    """The vehicle with springs that level themselves, and whether the drive speaks for them by itself; None where it hardly does.

    What it does not speak for is one cause among others of a contradiction.
    """
    if vehicle.self_levelling is not None:
        return None
    weight = sum(each.weight for each in doubts_of(joint, vehicle) if each.doubt.text == LEVELS)
    return (replace(vehicle, self_levelling="both"), weight > SURE) if weight > HEARD else None


def levelled_odds(joint: Joint, levelled: Joint, vehicle: Vehicle) -> float:
    """ln odds with the log that the springs of both axles level themselves. joint, levelled: the posteriors without and with such."""
    return log_odds(joint, levelled) + math.log(0.5 * level_chance(vehicle))


def rather_another_load(
    joint: Joint, levelled: Joint, evidence: Sequence[Evidence], known: Known, vehicle: Vehicle
) -> bool:
    """Whether a stated load that is wrong explains the drive better than springs that level themselves, each by a fit of its own.

    joint: the posterior with neither; levelled: that with such springs.
    """
    names = stated_unknowns(vehicle).get(LOAD, ())
    if not names:
        return False
    loaded = joined_again(joint, evidence, known, opened(known, names, OPEN[LOAD]))
    odds = log_odds(joint, loaded) + math.log(chance_wrong(LOAD, vehicle))
    return odds > levelled_odds(joint, levelled, vehicle)
