"""Do the springs level themselves? Where the drive says so almost surely, it is joined so.

As a doubt (`pipelines.joint.doubts`) it moves answers along straight lines from a mode at which the load is nought; a load of some
tonnes is too far for that.
"""

from __future__ import annotations

from dataclasses import replace

from pipelines.joint.doubts import LEVELS, doubts_of
from pipelines.joint.posterior import Joint
from pipelines.vehicles.vehicle import Vehicle

SURE = 0.7
"""Weight among all doubts from which on the springs are taken so."""

TEXT = f"{LEVELS}: the drive fits no others, and was joined with such (`self_levelling` in the vehicle file says so, or denies it)"


def as_levelled(joint: Joint, vehicle: Vehicle) -> Vehicle | None:
    """The vehicle with springs that level themselves, where the drive speaks for them; else None."""
    if vehicle.self_levelling is not None:
        return None
    weight = sum(each.weight for each in doubts_of(joint, vehicle) if each.doubt.text == LEVELS)
    return replace(vehicle, self_levelling="both") if weight > SURE else None
