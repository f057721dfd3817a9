"""Signs of torques at the wheels, by what the pedals do to the speed: what drives pushes forwards, what brakes goes one way at all wheels.

A motor that recuperates pulls back while the vehicle slows, so that its torque goes with the change of speed as an engine's does. Hills do not
count: uphill a vehicle slows while it is driven hardest. Brake torques are logged with either sign, which is no mistake, but not with both.
"""

from __future__ import annotations

from collections.abc import Mapping

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray, Grid, Together, compare, size
from parsers.checks.motion import smooth, vehicle_speed
from parsers.checks.pedals import backwards, change_of_speed, pedalled
from parsers.drive import Decision, Signal
from parsers.signals import WHEELS

_LEAST = 0.7
"""Correlation from which a torque tells its sign: 0.8 to 1 in simulated drives of all kinds."""
_DRIVEN = 0.1
"""Of the largest drive torque: a wheel with less is not driven."""
_MOVES = 2.0
"""m/s: slower vehicles are being held or pushed about."""
_BRAKES = 0.5
"""m/s² of lost speed below which what drives says nothing: it has let go, and the brakes work."""


def torque_signs(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """What is decided of torques that go the wrong way: turned. Nothing where the drive does not tell, or is one backwards."""
    change, speed = change_of_speed(grid), vehicle_speed(grid)
    if change is None or speed is None or backwards(grid):
        return []
    moving = speed > _MOVES
    decisions = list[Decision]()
    names = _there(signals, "drive_torque")
    most = max((size(grid.columns[name]) for name in names), default=0.0)
    for name in names:
        found = _together(grid.columns[name], change, moving & (change > -_BRAKES))
        # what is left of noise, of gears that drag, at wheels that are not driven has any sign
        if found is not None and found.sign < 0 and size(grid.columns[name]) > _DRIVEN * most:
            text = f"{name} has the sign opposite to the change of speed: it drives forwards where it is below zero"
            decisions.append(_inverted(name, text, found))
    return decisions + _unlike_brakes(signals, grid, -change, moving)


def _there(signals: Mapping[str, Signal], kind: str) -> list[str]:
    return [name for name in (kind, *(f"{kind}_{wheel}" for wheel in WHEELS)) if name in signals]


def _together(torque: FloatArray, change: FloatArray, where: BoolArray) -> Together | None:
    """How a torque (n,) goes with a change of speed (n,) that pedals make; None where that is not clear."""
    told = list[Together]()
    smoothed = smooth(torque)
    for taken, driving, quick_or_large in pedalled(change):
        found = compare(taken(smoothed), driving, where & quick_or_large, centred=False)
        told += [found] if found is not None and abs(found.correlation) >= _LEAST else []
    return told[0] if len({found.sign for found in told}) == 1 else None


def _unlike_brakes(
    signals: Mapping[str, Signal], grid: Grid, lost: FloatArray, moving: BoolArray
) -> list[Decision]:
    """The wheels' brake torques that are below zero while others' are above. lost: (n,) m/s² of speed."""
    found = {
        name: told
        for name in _there(signals, "brake_torque")[-len(WHEELS) :]
        if name != "brake_torque"
        and (told := _together(grid.columns[name], lost, moving & (lost > 0))) is not None
    }
    if len({each.sign for each in found.values()}) < 2:
        return []
    return [
        _inverted(name, f"{name} is below zero where the vehicle brakes, other wheels' are above it", each)
        for name, each in found.items()
        if each.sign < 0
    ]


def _inverted(name: str, text: str, found: Together) -> Decision:
    evidence = f"correlation {found.correlation:.2f} over {found.seconds:.0f} s"
    return Decision(name, "sign", text, "inverted", evidence, applied=True)
