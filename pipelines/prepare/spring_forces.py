"""Forces of springs that stand closer together than the wheels of their rigid axle, as forces at the wheels.

With the springs s apart on a track t, and forces F_l and F_r in them, forces at the wheels that lift and roll the body the same are

    F_l' = (F_l + F_r) / 2 + s/t (F_l - F_r) / 2,   F_r' = (F_l + F_r) / 2 - s/t (F_l - F_r) / 2

which is what every method takes `suspension_force_*` for.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parsers.drive import Decision, Drive, Signal
from pipelines.prepare.decided import decided
from pipelines.results import FloatArray
from pipelines.vehicles.spring_base import narrowing
from pipelines.vehicles.vehicle import Vehicle

AXLES = ("front", "rear")


def _other_side(own: Signal, other: Signal) -> FloatArray:
    """The other wheel's force at this one's stamps."""
    if np.array_equal(own.time_ns, other.time_ns):
        return np.asarray(other.values, dtype=np.float64)
    start = own.time_ns[0]
    here, there = (signal.time_ns - start for signal in (own, other))
    return np.asarray(np.interp(here.astype(np.float64), there.astype(np.float64), other.values))


def at_the_wheels(drive: Drive, vehicle: Vehicle) -> Drive:
    """The drive with the springs' forces of each axle that has a stated spring base as forces at its wheels, and a decision that says so."""
    signals, said = dict(drive.signals), []
    for axle in AXLES:
        ratio, _ = narrowing(vehicle, axle)
        names = tuple(f"suspension_force_{axle[0]}{side}" for side in "lr")
        if ratio == 1.0 or not all(name in signals for name in names):
            continue
        left, right = (drive.signals[name] for name in names)
        for name, own, other in ((names[0], left, right), (names[1], right, left)):
            across = _other_side(own, other)
            signals[name] = replace(own, values=0.5 * ((1 + ratio) * own.values + (1 - ratio) * across))
            said.append(
                Decision(
                    name, "choice", f"the {axle} springs stand closer together than the wheels",
                    "taken as the force at the wheel that lifts and rolls the body the same",
                    f"spring base over track {ratio:.3f} (vehicle file)", applied=True,
                )
            )  # fmt: skip
    return decided(drive, said, signals)
