"""How far off, taken together, are spring rates and the scale of the deflections?

A balance sees their product alone. Where the log would have the stated rates otherwise, the rates may be right and the sensors' levers wrong
(deflections at the damper, of another lever): a roll angle by deflections is then off by as much, and nothing else says so.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.joint.doubts import HEARD, Weighed
from pipelines.joint.posterior import Joint
from pipelines.joint.unknowns import AXLES
from pipelines.vehicles.vehicle import Vehicle

LEAST = 0.05
"""Share up to which it is what data sheets and levers are off by anyway."""


def springs_off(joint: Joint, doubts: Sequence[Weighed], vehicle: Vehicle) -> float:
    """Mean share by which the log has the stated rates of the axles otherwise, all doubts weighed; nought where it is little or none is stated."""
    shares = []
    for axle in AXLES:
        if vehicle.get(f"spring_rate_{axle}_npm") is None:
            return 0.0
        row = joint.known.index(f"spring_{axle}")
        along = np.zeros(len(joint.u))
        along[row] = joint.known.std[row]
        moved = along[row] * joint.u[row] + sum(d.weight * d.on(along)[0] for d in doubts if d.weight > HEARD)
        shares.append(float(moved) / float(joint.known.mean[row]))
    share = abs(float(np.mean(shares)))
    return share if share > LEAST else 0.0
