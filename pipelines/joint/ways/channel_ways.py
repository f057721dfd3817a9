"""Is it a channel of the log? A torque of the engine and not of the wheels, a load cell of another range.

Where a drive contradicts itself the relations are joined again with each such channel's scale open: what is left of its relations tells
next to nothing of the mass, and the fits are compared as those of wrong figures of the file are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.channels import channels_of
from pipelines.joint.doubts.weighed import WRONG_FILE
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.unknowns import Known
from pipelines.joint.ways.file_ways import FARTHEST, joined_again
from pipelines.joint.ways.rigid_tyres import log_odds


def channel_ways(
    joint: Joint, evidence: Sequence[Evidence], known: Known
) -> Iterator[tuple[str, float, Joint, Known]]:
    """For each that a relation has: its name, ln odds with the log that its scale is wrong, the posterior with that open, its unknowns."""
    for channel, (scales, spread) in channels_of(evidence).items():
        rows = [known.index(name) for name in scales]
        std = known.std.copy()
        std[rows] = np.maximum(std[rows], spread)
        free = replace(known, std=std)
        found = joined_again(joint, evidence, known, free)
        if np.abs(found.u[rows]).max() <= FARTHEST:
            yield channel, log_odds(joint, found) + math.log(WRONG_FILE / (1 - WRONG_FILE)), found, free
