"""How far off, taken together, are spring rates and the scale of the deflections?

A balance sees their product alone. Where the log would have the stated rates otherwise, the rates may be right and the sensors' levers wrong
(deflections at the damper, of another lever): a roll angle by deflections is then off by as much. A gyro beside them tells the two apart.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipelines.joint.doubts.weighed import HEARD, Weighed
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.unknowns import AXLES, CORNERS
from pipelines.joint.ways.travel_scale import GYRO_BESIDE_SPRINGS
from pipelines.vehicles.vehicle import Vehicle

LEAST = 0.05
"""Share up to which it is what data sheets and levers are off by anyway."""

TOLD = 0.05
"""Chance from which on another posterior is told as a way that the drive may be understood."""


def springs_off(
    joint: Joint, doubts: Sequence[Weighed], vehicle: Vehicle, others: Sequence[tuple[float, Joint]] = ()
) -> float:
    """Share by which the log may have the axles' stated rates otherwise, and the deflections' scale (rms); nought where it is little.

    All doubts weighed, and other posteriors by their chances. Rates that nobody states are no contradiction.
    """
    chances = [1 - sum(chance for chance, _ in others), *(chance for chance, _ in others)]
    shares = [
        _share(joint, doubts, vehicle),
        *(_share(other, (), vehicle, open_too=True) for _, other in others),
    ]
    by_chance = list(zip(chances, shares, strict=True))
    share = math.sqrt(sum(c * s**2 for c, s in by_chance))
    # a posterior that is told beside the likeliest counts by itself: the mean over all hides a scale that is a fifth off
    worst = max((s for c, s in by_chance if c >= TOLD), default=0.0)
    return share if max(share, worst) > LEAST else 0.0


def _share(joint: Joint, doubts: Sequence[Weighed], vehicle: Vehicle, *, open_too: bool = False) -> float:
    """The same by one posterior. Where a gyro sees the scale by itself, rates that are otherwise say nothing of it.

    open_too: with what that posterior leaves open of the scale, where that is more than levers are off by anyway.
    """
    stated = all(vehicle.get(f"spring_rate_{axle}_npm") is not None for axle in AXLES)
    open_ = stated and not any(e.carrier == GYRO_BESIDE_SPRINGS for e in joint.evidence)
    rates = _off(joint, doubts, [f"spring_{axle}" for axle in AXLES]) if open_ else 0.0
    scales = [f"scale_{wheel}" for wheel in CORNERS]
    return rates + _off(joint, doubts, scales, LEAST if open_too else math.inf)


def _off(joint: Joint, doubts: Sequence[Weighed], names: Sequence[str], usual: float = math.inf) -> float:
    """Share by which the log may have the mean of some unknowns otherwise: root mean square over the doubts. usual: spread of that
    mean above which it counts too."""
    rows = [joint.known.index(name) for name in names]
    along = np.zeros(len(joint.u))
    along[rows] = joint.known.std[rows] / joint.known.mean[rows] / len(rows)
    whole = float(along @ joint.u)
    heard = [(d.weight, *d.on(along)) for d in doubts if d.weight > HEARD]
    open_ = float(along @ joint.covariance @ along)
    square = (1 - sum(w for w, _, _ in heard)) * whole**2 + (open_ if open_ > usual**2 else 0.0)
    square += sum(w * ((whole + shift) ** 2 + max(more, 0.0)) for w, shift, more in heard)
    return math.sqrt(max(square, 0.0))
