"""Is a trailer towed? Torques then move more than the springs carry, and the air takes more hold of it.

Without this way a pickup that towed 750 kg was told to have springs that level themselves and a load of that mass (a blind author's: mass +35 %
at ten standard deviations, identified).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from pipelines.evidence import Evidence
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.unknowns import TOWED, TRAILER_DRAG_M2, Known
from pipelines.joint.ways.file_ways import joined_again
from pipelines.joint.ways.rigid_tyres import log_odds
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.vehicle import Vehicle

CHANCE = {"car": 0.005, "carrier": 0.02, "heavy": 0.1}
"""Beforehand, that a log was recorded with a trailer of which nobody says."""

MASS = (0.4, 0.3)
"""Of a trailer over the empty vehicle: mean and spread."""

LEAST = 0.04
"""Of the empty vehicle, kg a kg: a trailer that is lighter is none."""

HEAVY = 1.5
"""Standard deviations above what is usual from which on a load may be a trailer, where nothing contradicts either."""

NAME = "a trailer, or something else that the springs do not carry"
TEXT = (
    f"{NAME}: {{:.0f}} ± {{:.0f}} kg more follow the torques than the springs show, and the drive was joined with such "
    "(`[trailer] mass_kg` in the vehicle file says what is towed, or that nothing is)"
)


def with_trailer(known: Known) -> Known:
    """The unknowns with a trailer of any mass."""
    mean, std = known.mean.copy(), known.std.copy()
    kilos, row, drag = known.mean[known.index("empty_mass")], known.index(TOWED), known.index("drag")
    mean[row], std[row] = MASS[0] * kilos, MASS[1] * kilos
    mean[drag], std[drag] = mean[drag] + TRAILER_DRAG_M2[0], math.hypot(std[drag], TRAILER_DRAG_M2[1])
    return replace(known, mean=mean, std=std)


def rather_heavy(joint: Joint) -> bool:
    """Whether the drive shows more of a load than is usual: a rare load is no likelier than a trailer that nobody states."""
    return float(joint.u[joint.known.index("load")]) > HEAVY


def towed_kg(joint: Joint) -> tuple[float, float]:
    """Mass of the trailer, and how surely."""
    row = joint.known.index(TOWED)
    std = float(joint.known.std[row])
    return float(joint.known.mean[row] + std * joint.u[row]), std * math.sqrt(
        float(joint.covariance[row, row])
    )


def towed_text(joint: Joint) -> str:
    """What is said where nothing else explains the drive."""
    return TEXT.format(*towed_kg(joint))


def towed_ways(
    joint: Joint, evidence: Sequence[Evidence], known: Known, vehicle: Vehicle
) -> Iterator[tuple[float, Joint, Known]]:
    """ln odds with the log that there is a trailer, the posterior with it, and its unknowns; nothing where no torque tells, the vehicle file says
    what is towed, or it weighs next to nothing."""
    if "mass_kg" in vehicle.trailer or not any(TOWED in e.unknowns for e in evidence):
        return
    free = with_trailer(known)
    found = joined_again(joint, evidence, known, free)
    if towed_kg(found)[0] < LEAST * float(known.mean[known.index("empty_mass")]):
        return
    chance = CHANCE[kind_of(vehicle)]
    yield log_odds(joint, found) + math.log(chance / (1 - chance)), found, free
