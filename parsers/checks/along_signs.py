"""Signs of what goes along the vehicle: accel_x by what the pedals do to the speed, pitch by accel_x; and that of accel_z, by gravity."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, Together, compare
from parsers.checks.leaning import swift_tells
from parsers.checks.motion import smooth, vehicle_speed
from parsers.checks.pedals import backwards, by_pedals, change_of_speed
from parsers.checks.signs import SignResult, excited, varied
from parsers.drive import Decision
from parsers.quantiles import median

_LEAST, _LEAST_PEDALS, _LEAST_QUICK = 0.55, 0.7, 0.6
_RATIOS = (0.4, 2.5)
"""accel_x over a change of speed that pedals make: 0.9 to 1.2 in simulated drives on any road, 0.6 to 1.4 with poor speeds."""
_LEAST_PITCH = 0.65
_MIN_MPS = 1.0
DOUBTED = "sign of accel_x: it goes against"
"""How the sentence begins that says why accel_x looks inverted and is left: nothing may be held against it then."""


def along_signs(grid: Grid) -> SignResult:
    """accel_x against the change of speed, pitch against accel_x, accel_z against gravity."""
    inverted: set[str] = set()
    decisions: list[Decision] = []
    unchecked: list[str] = []
    forward, doubted = grid.get("accel_x"), False
    if forward is not None:
        found, why, doubted = _forward(grid, forward)
        if found is None:
            unchecked.append(f"sign of accel_x: {why}")
        elif found.sign < 0:
            inverted.add("accel_x")
            evidence = f"correlation {found.correlation:.2f} over {found.seconds:.0f} s"
            text = "accel_x has the sign opposite to the change of speed"
            decisions.append(Decision("accel_x", "sign", text, "inverted", evidence, applied=True))
            forward = -forward
    pitch = grid.get("pitch")
    if pitch is not None and forward is None:
        unchecked.append("sign of pitch: no longitudinal acceleration")
    if pitch is not None and forward is not None:
        nods, least = _nods(grid, pitch, forward)
        if nods is None:
            unchecked.append("sign of pitch: braking and driving move it too little")
        elif nods.sign > 0 and doubted:
            unchecked.append("sign of pitch: it rises with accel_x, whose own sign the drive does not tell")
        elif nods.sign > 0:
            inverted.add("pitch")
            evidence = f"correlation {nods.correlation:+.2f} with accel_x{'' if least > _LEAST_QUICK else ', changes of both,'} over {nods.seconds:.0f} s"
            text = "pitch rises with accel_x, but braking tips the nose down (pitch > 0)"
            decisions.append(Decision("pitch", "sign", text, "inverted", evidence, applied=True))
    decisions += _gravity(grid, inverted)
    return SignResult(frozenset(inverted), tuple(decisions), tuple(unchecked))


def _forward(grid: Grid, forward: FloatArray) -> tuple[Together | None, str, bool]:
    """How accel_x goes with the change of speed; None with the reason, and whether its sign looks wrong but hills or a wrong speed may be why."""
    change, speed = change_of_speed(grid), vehicle_speed(grid)
    if change is None or speed is None:
        return None, "no speed", False
    if not excited(change, 0.5):
        return None, "the speed changes too little", False
    found = by_pedals(grid, forward, change, _LEAST_PEDALS, _RATIOS)
    if found is not None and found.sign < 0 and backwards(grid):
        return (
            None,
            "it goes against the change of a speed that is negative: one of the two has the wrong sign",
            True,
        )
    if found is not None:
        return found, "", False
    plain = compare(smooth(forward), change, np.abs(speed) > _MIN_MPS)
    if plain is None or abs(plain.correlation) < _LEAST:
        return None, "it does not go with the change of speed", False
    if plain.sign < 0:
        return None, "it goes against the change of speed, but that is so slow that hills may be why", True
    return plain, "", False


def _nods(grid: Grid, pitch: FloatArray, forward: FloatArray) -> tuple[Together | None, float]:
    """How pitch goes with accel_x, None where that is not clear, and the correlation from which it is."""
    found, least = compare(pitch, forward) if varied(forward, 1.0) else None, _LEAST_PITCH
    if found is not None and abs(found.correlation) < least:
        # hills are in both, with another slope than the nod's: quick changes are the pedals'
        changes = grid.rate(pitch), grid.rate(forward)
        quick = compare(*changes)
        if quick is None or abs(quick.correlation) < _LEAST_QUICK:
            quick = swift_tells(*changes) or quick
        found, least = (found, least) if quick is None else (quick, _LEAST_QUICK)
    return (None if found is None or abs(found.correlation) < least else found), least


def _gravity(grid: Grid, inverted: set[str]) -> list[Decision]:
    vertical = grid.get("accel_z")
    if vertical is None or not np.isfinite(vertical).any():
        return []
    middle = median(vertical)
    evidence = f"median {middle:.2f} m/s²"
    if -11.5 < middle < -8:
        inverted.add("accel_z")
        text = "accel_z points down: it is near -9.81 m/s² where +9.81 m/s² belongs"
        return [Decision("accel_z", "sign", text, "inverted", evidence, applied=True)]
    return []
