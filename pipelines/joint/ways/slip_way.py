"""Is it the slips of the wheels? What braked wheels' slips tell of height and place hangs on tyres that nobody knows.

Of 173 drives of the plant whose vehicles were measured, nine had slips that contradicted the rest at less than one in a hundred, and of
16 of a simulator that nobody here wrote (another slip curve, an engine that holds back one axle) five at less than one in five hundred. Against a place of the CG that is stated to 3 mm, the file would
be blamed for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.unknowns import Known
from pipelines.joint.ways.file_ways import joined_again
from pipelines.joint.ways.rigid_tyres import log_odds

CARRIER = "wheel slips"
"""Of the relation."""

CHANCE = 0.1
"""Beforehand, that it is off by more than it knows."""

WIDER = 5.0
"""Its spread then, over its own."""

NAME = "the slips of braked wheels wrong"
TEXT = f"{NAME}: all else contradicts them (tyres that differ front and rear?), and the drive was joined with what they tell five times as unsure"


def slip_ways(
    joint: Joint, evidence: Sequence[Evidence], known: Known
) -> Iterator[tuple[float, Joint, tuple[Evidence, ...]]]:
    """ln odds with the log that the slips are off, the posterior with them unsure, and its relations; nothing without slips."""
    figures = sum(len(e.observed) for e in evidence if e.carrier == CARRIER)
    if not figures:
        return
    unsure = tuple(
        replace(e, covariance=WIDER**2 * np.asarray(e.covariance)) if e.carrier == CARRIER else e
        for e in evidence
    )
    found = joined_again(joint, unsure, known, known)
    # a wider normal law has that much less of its mass where the figures are
    odds = log_odds(joint, found) - figures * math.log(WIDER)
    yield odds + math.log(CHANCE / (1 - CHANCE)), found, unsure
