"""Does what is carried change in mid-drive? By what the wheels carry from rest to rest where that is measured, else by what torques move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parsers.drive import Drive
from pipelines.prepare.decided import decided
from pipelines.prepare.load_at_rest import changes_at_rest
from pipelines.prepare.load_by_torque import changes_by_torque
from pipelines.prepare.load_change import LoadStep
from pipelines.prepare.stands import find_stands
from pipelines.vehicles.vehicle import Vehicle


def load_step(drive: Drive, vehicle: Vehicle) -> LoadStep | None:
    """The largest change of load in mid-drive, with the others beside it; None where there is none, or the log cannot tell."""
    stands = find_stands(drive, vehicle)
    if stands is None or len(np.unique(stands.rest)) < 2:
        steps = changes_by_torque(drive, vehicle)
    else:
        steps = changes_at_rest(stands, vehicle)
    if not steps:
        return None
    largest = max(steps, key=lambda step: abs(step.change_kg))
    return replace(largest, others=tuple(step for step in steps if step is not largest))


def with_load_step(drive: Drive, step: LoadStep | None) -> Drive:
    """The drive with what was found in its record."""
    return drive if step is None else decided(drive, [step.decision])
