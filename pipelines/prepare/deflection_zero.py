"""Were the deflections zeroed on the vehicle as it stood, with its load? Then they tell what moves, and no load.

`suspension_deflection` is zero for the empty vehicle. A driver alone makes some 5 mm of it at every wheel, and sensors' zeros differ by
a millimetre: four of them that all begin within half a millimetre of nought were set to nought there, or come from a simulator that counts
from its own equilibrium. An empty vehicle with perfect sensors looks the same, and nothing in them tells the two apart: the load is then left
open, which holds both.

Where the vehicle file says what the sensors show with the empty vehicle (`suspension_deflection_fl_m` … in its [sensors]), that is taken off.

No load is less than nothing: where the body stands clearly above where the deflections are zero, that was under a load, whatever it was.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parsers.drive import Decision, Drive
from parsers.signals import WHEELS
from parsers.timebase import NS
from pipelines.prepare.decided import decided
from pipelines.prepare.standstill import SPEEDS
from pipelines.vehicles.vehicle import Vehicle

NOUGHT_M = 0.0005
BEGIN_S = 1.0
CREEPS_MPS = 0.3
FEWEST = 5
"""Samples of each wheel in which the drive has not begun: as long as it stands, a second of it in any case."""

HIGH_M = 0.006
"""How much above zero the body must stand in the mean of all wheels and of the drive: an empty tank and the lift of a motorway are worth 2 and 3 mm."""

NAMES = tuple(f"suspension_deflection_{wheel}" for wheel in WHEELS)


def _begin_ns(drive: Drive) -> int:
    """Until when the drive has not begun: to its first motion where it stands first, at least BEGIN_S."""
    least = drive.start_ns + int(BEGIN_S * NS)
    for name in SPEEDS:
        signal = drive.signals.get(name)
        if signal is not None and len(signal.time_ns):
            moving = np.flatnonzero(np.abs(signal.values) > CREEPS_MPS)
            return max(least, int(signal.time_ns[moving[0]] if len(moving) else signal.time_ns[-1]))
    return least


def begins_at_zero(drive: Drive) -> float | None:
    """Largest median deflection before the drive's first motion, m, where it is nought at all wheels; else None."""
    end = _begin_ns(drive)
    found = []
    for name in NAMES:
        signal = drive.signals.get(name)
        if signal is None:
            return None
        values = signal.values[(signal.time_ns <= end) & np.isfinite(signal.values)]
        if len(values) < FEWEST:
            return None
        found.append(abs(float(np.median(values))))
    largest = max(found)
    return largest if largest < NOUGHT_M else None


def stands_high(drive: Drive) -> float | None:
    """By how much the body stands above where the deflections are zero, m, in the mean of the wheels; None where by no more than an empty one may."""
    medians = []
    for name in NAMES:
        signal = drive.signals.get(name)
        values = np.empty(0) if signal is None else signal.values[np.isfinite(signal.values)]
        if not len(values):
            return None
        medians.append(float(np.median(values)))
    high = -float(np.mean(medians))
    return high if high > HIGH_M else None


def less_their_zeros(drive: Drive, vehicle: Vehicle) -> tuple[Drive, Vehicle]:
    """The drive with what its deflection sensors show with the empty vehicle taken off, as the vehicle file has it, and the vehicle with
    deflections that are nought when it is empty. As they are where the file says nothing of it.
    """
    signals, said = dict(drive.signals), []
    for name in NAMES:
        stated = vehicle.sensors.get(f"{name}_m")
        if stated is None or name not in signals:
            continue
        own = signals[name]
        signals[name] = replace(own, values=own.values - stated.value)
        said.append(
            Decision(
                name, "zero", "the vehicle file says what the sensor shows with the empty vehicle", "taken off",
                f"{1e3 * stated.value:.1f} ± {1e3 * stated.std:.1f} mm", applied=True,
            )
        )  # fmt: skip
    if not said:
        return drive, vehicle
    return decided(drive, said, signals), replace(vehicle, deflection_zero="empty")


def with_zero_open(drive: Drive, vehicle: Vehicle) -> tuple[Drive, Vehicle]:
    """The drive with what was found in its record, and the vehicle with the zero of its deflections left open, where they begin at nought or
    have it stand higher than without a load.

    As they are where the vehicle file says where the deflections are nought (`deflection_zero`).
    """
    if vehicle.deflection_zero is not None:
        return drive, vehicle
    high, largest = stands_high(drive), begins_at_zero(drive)
    if high is not None:
        found = "the suspension deflections have the body stand higher than where they are zero: they were zeroed under another load"
        evidence = f"{1e3 * high:.0f} mm in the mean of the wheels and of the drive"
    elif largest is not None:
        found = "the suspension deflections begin at zero: nobody aboard, or zeroed on the vehicle as it stood, with its load"
        evidence = f"no wheel further than {1e3 * largest:.2f} mm from zero before the first motion"
    else:
        return drive, vehicle
    action = 'no load is taken from them; deflection_zero = "empty" in the vehicle file lets them tell it'
    said = Decision("", "zero", found, action, evidence, applied=False)
    return decided(drive, [said]), replace(vehicle, deflection_zero="loaded")
