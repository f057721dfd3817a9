"""Vertical forces at the wheels that are other wheels': bends load one side and braking the front, whatever the vehicle.

A force has the weight in it, so that its sign is told at rest; one that moves the other way round in bends or in braking stands at another
wheel. Struts exchanged between left and right put the CG to the wrong side, and those between front and rear its place along.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from parsers.checks.grid import Grid
from parsers.checks.wheel_signs import Marks, bends_sign, marks_of, odd_in_braking
from parsers.drive import Decision
from parsers.quantiles import median
from parsers.signals import WHEELS

FORCES = ("suspension_force", "tire_normal_force")
_AXLES = {"front": frozenset(("fl", "fr")), "rear": frozenset(("rl", "rr"))}
_SIDES = {"left": frozenset(("fl", "rl")), "right": frozenset(("fr", "rr"))}
_ALL = frozenset(WHEELS)


def exchanged_forces(grid: Grid, known: Collection[str] = ()) -> list[Decision]:
    """Forces that stand at another wheel than their name says, left out. known: signals that something else is wrong with."""
    found: list[Decision] = []
    for kind in FORCES:
        names = {wheel: f"{kind}_{wheel}" for wheel in WHEELS}
        columns = [grid.get(name) for name in names.values()]
        if any(c is None or not median(c[c == c]) > 0 for c in columns) or not set(known).isdisjoint(
            names.values()
        ):
            continue
        marks = marks_of(grid, tuple(names.values()))
        if marks is not None:
            found += _exchanged(grid, names, marks)
    return found


def _exchanged(grid: Grid, names: Mapping[str, str], marks: Marks) -> list[Decision]:
    """What is decided of one kind of forces."""
    pitching = frozenset(odd_in_braking(marks))
    turned = _turned(grid, marks)
    if turned is None:
        text = "moves otherwise than those of other wheels in bends, and nothing tells which are right"
        return _out(names, _ALL, text, marks)
    if not turned and not pitching:
        return []
    text = "moves as at another wheel: channels look exchanged"
    if not pitching and (turned == _ALL or turned in _AXLES.values()):
        text = "moves in bends as on the other side: left and right look exchanged"
    elif not turned and (pitching == _ALL or pitching in _SIDES.values()):
        text = "moves in braking as on the other axle: front and rear look exchanged"
    return _out(names, turned | pitching, text, marks)


def _turned(grid: Grid, marks: Marks) -> frozenset[str] | None:
    """Wheels that move in bends as on the other side; None where the wheels contradict each other and nothing tells which are right."""
    sign = bends_sign(grid)
    for few in (1, -1):
        odd = frozenset(wheel for wheel, sense in marks.bends.items() if sense == few)
        if len(odd) == 1:
            return odd
    if sign is None:
        return frozenset() if len(set(marks.bends.values())) == 1 else None
    return frozenset(wheel for wheel, sense in marks.bends.items() if sense * sign < 0)


def _out(names: Mapping[str, str], wheels: Collection[str], text: str, marks: Marks) -> list[Decision]:
    action = "left out: say which channel is which wheel in a mapping file"
    return [
        Decision(names[wheel], "sign", f"{names[wheel]} {text}", action, marks.figures, applied=True)
        for wheel in WHEELS
        if wheel in wheels
    ]
