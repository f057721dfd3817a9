"""Both wheels of an axle with one sensor's samples: an axle's mean written twice, or mapped to both.

Taken for two wheels it says that the body never rolls, and what one sensor read counts as two. A model without roll writes such pairs as well, and
is right; so only a drive with bends tells, in which no body stands level.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.checks.grid import Grid
from parsers.checks.motion import seconds, smooth
from parsers.drive import Decision, Signal

_LEAST_SAMPLES = 100
_LEAST_MOVED_M = 0.001
_BENDS_MPS2, _BENDS_S = 1.0, 5.0
"""Lateral acceleration in which a body rolls by some millimetres at each wheel, and for how long."""


def twins(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """Deflections of an axle's two wheels left out where they are one sensor's; nothing where no bend tells."""
    side = grid.get("accel_y")
    if side is None:
        yaw, speed = grid.get("yaw_rate"), grid.get("speed")
        side = None if yaw is None or speed is None else yaw * speed
    if side is None:
        return []
    found: list[Decision] = []
    for axle in ("front", "rear"):
        names = [f"suspension_deflection_{axle[0]}{which}" for which in "lr"]
        pair = [signals[name] for name in names if name in signals]
        if len(pair) < 2 or not _same(*pair):
            continue
        bends = seconds((np.abs(smooth(side)) > _BENDS_MPS2) & np.isfinite(grid.columns[names[0]]))
        if bends < _BENDS_S:
            continue
        text = f"both wheels of the {axle} axle have one sensor's samples, so that the body would never roll"
        action = "left out: one deflection for an axle is no wheel's; with the sensor of the other wheel both are of use"
        evidence = f"{len(pair[0].values)} equal samples, also in bends of more than {_BENDS_MPS2:g} m/s² ({bends:.0f} s)"
        found += [Decision(name, "range", text, action, evidence, applied=True) for name in names]
    return found


def _same(left: Signal, right: Signal) -> bool:
    """Whether two signals hold the same samples, and move."""
    if len(left.values) < _LEAST_SAMPLES or not np.array_equal(left.values, right.values):
        return False
    return float(np.std(left.values[np.isfinite(left.values)])) > _LEAST_MOVED_M
