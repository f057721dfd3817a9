"""Were the deflections zeroed on the vehicle as it stood, with its load? Then they tell what moves, and no load.

`suspension_deflection` is zero for the empty vehicle. A driver alone makes some 5 mm of it at every wheel, and sensors' zeros differ by
a millimetre: four of them that all begin within half a millimetre of nought were set to nought there, or come from a simulator that counts
from its own equilibrium. An empty vehicle with perfect sensors looks the same, and nothing in them tells the two apart: the load is then left
open, which holds both.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parsers.drive import Decision, Drive
from parsers.signals import WHEELS
from parsers.timebase import NS
from pipelines.prepare.decided import decided
from pipelines.vehicles.vehicle import Vehicle

NOUGHT_M = 0.0005
BEGIN_S = 1.0
FEWEST = 5
"""Samples of each wheel within BEGIN_S from its first that stand for where the drive began."""

NAMES = tuple(f"suspension_deflection_{wheel}" for wheel in WHEELS)


def begins_at_zero(drive: Drive) -> float | None:
    """Largest mean deflection over the drive's first second, m, where it is nought at all wheels; else None."""
    means = []
    for name in NAMES:
        signal = drive.signals.get(name)
        if signal is None or len(signal.time_ns) == 0:
            return None
        early = signal.time_ns <= signal.time_ns[0] + BEGIN_S * NS
        values = signal.values[early & np.isfinite(signal.values)]
        if len(values) < FEWEST:
            return None
        means.append(abs(float(values.mean())))
    largest = max(means)
    return largest if largest < NOUGHT_M else None


def with_zero_open(drive: Drive, vehicle: Vehicle) -> tuple[Drive, Vehicle]:
    """The drive with what was found in its record, and the vehicle with the zero of its deflections left open, where they begin at nought.

    As they are where the vehicle file says where the deflections are nought (`deflection_zero`).
    """
    if vehicle.deflection_zero is not None:
        return drive, vehicle
    largest = begins_at_zero(drive)
    if largest is None:
        return drive, vehicle
    said = Decision(
        "", "zero",
        "the suspension deflections begin at zero: nobody aboard, or zeroed on the vehicle as it stood, with its load",
        'no load is taken from them; deflection_zero = "empty" in the vehicle file lets them tell it',
        f"no wheel further than {1e3 * largest:.2f} mm from zero over the first second", applied=False,
    )  # fmt: skip
    return decided(drive, [said]), replace(vehicle, deflection_zero="loaded")
