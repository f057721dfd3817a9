"""From what a roll gyro reads to how the roll angle changes: a body that pitches turns some of the yaw into its roll axis.

    p = φ' - ψ' sin θ

with θ the pitch, nose down positive. What of θ stays the same (a unit mounted askew, a loaded boot) is a leak of the yaw rate that the
fits know; what the drive makes of it, the springs of all four wheels show. Speeding up and slowing down in bends of one direction, it is as
much as all of the roll rate: the gyro then seemed to turn otherwise than the springs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parsers.signals import WHEELS
from pipelines.prepare.prepared import Prepared
from pipelines.vehicles.usual import usual_wheelbase
from pipelines.vehicles.vehicle import Vehicle


def off_pitch(prepared: Prepared, vehicle: Vehicle) -> Prepared:
    """The prepared drive with what pitching puts into its roll rate taken off, as far as deflections of all wheels show it; as it is without."""
    names = [f"suspension_deflection_{wheel}" for wheel in WHEELS]
    columns = prepared.columns
    if not {"roll_rate", "yaw_rate", *names} <= columns.keys():
        return prepared
    stated = vehicle.get("wheelbase_m")
    base = usual_wheelbase(vehicle)[0] if stated is None else stated.value
    front_left, front_right, rear_left, rear_right = (columns[name] for name in names)
    pitch = 0.5 * (front_left + front_right - rear_left - rear_right) / base
    there = np.isfinite(pitch)
    if not there.any():
        return prepared
    turned = columns["yaw_rate"] * np.sin(pitch - np.median(pitch[there]))
    # where a deflection is missing the gyro is worth more than nothing
    rate = columns["roll_rate"] + np.where(np.isfinite(turned), turned, 0.0)
    return replace(prepared, columns={**columns, "roll_rate": rate})
