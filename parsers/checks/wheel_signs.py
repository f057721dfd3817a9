"""Each wheel's deflection by itself: of four that stand under one body, bends press one side and braking one axle.

What goes along with bends and what goes along with braking tell of a deflection whose it is, and with which sign: a wheel that does both the
other way round has the other sign; one that does bends alone so stands on the other side. Axle and body together (`parsers.checks.springs`,
`parsers.checks.signs`) are looked at later, when no wheel contradicts the others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import MIN_CELLS, Grid, clip
from parsers.checks.motion import seconds, smooth
from parsers.checks.pedals import View, as_it_is, backwards, change_of_speed, level, pedalled
from parsers.checks.signs import MIN_LATERAL, lateral_reference, lateral_signs, lateral_votes, varied
from parsers.checks.springs import DEFLECTIONS
from parsers.drive import Decision
from parsers.signals import WHEELS

FOLLOWS = 0.5
"""Least partial correlation of each wheel: right drives of all roads come to 0.6 and more."""
_LEAST_CELLS = 200
_APART = 0.8
"""Correlation of bends and braking from which on they cannot be told apart."""
_MIN_CHANGE = 0.7
_YAW_ALONE = {"yaw_rate"}
_PAIRS = {"front": {"fl", "fr"}, "rear": {"rl", "rr"}, "left": {"fl", "rl"}, "right": {"fr", "rr"}}
_AXLES = (_PAIRS["front"], _PAIRS["rear"])


@dataclass(frozen=True)
class OddWheels:
    """inverted: deflections of the other sign, put right; left_out: a decision for each that cannot be used; decisions: on the inverted."""

    inverted: frozenset[str] = frozenset()
    left_out: tuple[Decision, ...] = ()
    decisions: tuple[Decision, ...] = ()


@dataclass(frozen=True)
class Marks:
    """+1 where a wheel moves as it should, -1 where the other way round. braking: empty where that does not tell. figures: in words."""

    bends: Mapping[str, int]
    braking: Mapping[str, int]
    figures: str


def odd_wheels(grid: Grid) -> OddWheels:
    """Wheels that move otherwise than the others in bends, and mostly in braking; nothing without all four or a drive that tells."""
    marks = marks_of(grid)
    if marks is None or (len(set(marks.bends.values())) == 1 and len(set(marks.braking.values())) < 2):
        return OddWheels()
    if marks.braking:
        return _by_both(grid, marks)
    for few in (1, -1):
        odd = {wheel for wheel, sign in marks.bends.items() if sign == few}
        if len(odd) == 1:
            return _out(
                odd,
                "moves in bends as on the other side, unlike the other three: its sign, or its wheel, is wrong",
                marks,
            )
    return _by_bends(grid, marks)


def _by_both(grid: Grid, marks: Marks) -> OddWheels:
    """Where braking tells as well: its signs are known, those of bends up to the sign of the lateral signals."""
    coherent = len({marks.bends[wheel] * marks.braking[wheel] for wheel in WHEELS}) == 1
    if not coherent:
        return _by_bends(grid, marks)
    wrong = {wheel for wheel in WHEELS if marks.braking[wheel] < 0}
    if not wrong or len(wrong) == len(WHEELS):
        return OddWheels()
    if len(wrong) < len(WHEELS) - 1 and wrong not in _PAIRS.values():
        return _out(wrong, "has the sign opposite to the other wheels', in bends and in braking", marks)
    which = next((f"the {name} wheels" for name, pair in _PAIRS.items() if pair == wrong), "three wheels")
    names = [f"suspension_deflection_{wheel}" for wheel in WHEELS if wheel in wrong]
    text = f"suspension deflections of {which} have the sign opposite to the rest, in bends and in braking"
    action = f"{', '.join(names[:-1])} and {names[-1]} inverted (compression is positive)"
    decision = Decision(names[0], "sign", text, action, marks.figures, applied=True)
    return OddWheels(frozenset(names), (), (decision,))


def _by_bends(grid: Grid, marks: Marks) -> OddWheels:
    """Wheels that contradict the lateral signals or braking alone; all four where nothing else tells which of them are right."""
    sign = lateral = bends_sign(grid)
    alike = len(set(marks.bends.values())) == 1
    if alike:
        sign = next(iter(marks.bends.values()))
    if sign is None:
        text = "moves otherwise than those of other wheels in bends, and nothing tells which are right"
        return _out(set(WHEELS), text, marks)
    pitching = odd_in_braking(marks)
    if pitching == set(WHEELS) or (alike and sign != lateral and not odd_in_braking(marks, -1)):
        pitching = set()  # all four have the other sign, which the axles together tell
    turned = {wheel for wheel in WHEELS if marks.bends[wheel] * sign < 0}
    odd = turned | pitching
    if not odd:
        return OddWheels()
    if turned in _AXLES and not pitching:
        return _out(
            odd, "moves in bends as on the other side: left and right of this axle look exchanged", marks
        )
    return _out(odd, "moves as at another wheel: channels look exchanged, or have the other sign", marks)


def odd_in_braking(marks: Marks, sign: int = 1) -> set[str]:
    """Wheels that move in braking as on the other axle because they are another's. sign: -1 if all four have the other sign.

    Not an axle: how its links hold it in braking may be anything. Nor one wheel alone of four that agree in bends: the propeller shaft's
    torque rolls the body over a driven live axle while the links lift both sides of it, so that one side goes the other way. No wrong channel
    does that: another sign or side shows in bends as well, and front and rear exchanged on one side make two wheels odd.
    """
    odd = {wheel for wheel, sense in marks.braking.items() if sense * sign < 0}
    alone = len(odd) == 1 and len(set(marks.bends.values())) == 1
    return set() if alone or odd in _AXLES else odd


def bends_sign(grid: Grid) -> int | None:
    """-1 where the lateral reference itself has the wrong sign, by what is no spring; None where only turning is there to tell."""
    rest = grid.without(DEFLECTIONS)
    reference = lateral_reference(rest)
    if reference is None or {vote.name for vote in lateral_votes(rest, reference)} <= _YAW_ALONE:
        return None
    return -1 if reference[0] in lateral_signs(rest).inverted else 1


def _out(wheels: set[str], text: str, marks: Marks) -> OddWheels:
    action = "left out: say the sign, or which channel is which wheel, in a mapping file"
    names = [f"suspension_deflection_{wheel}" for wheel in WHEELS if wheel in wheels]
    return OddWheels(
        left_out=tuple(
            Decision(name, "sign", f"{name} {text}", action, marks.figures, applied=True) for name in names
        )
    )


def marks_of(grid: Grid, names: Sequence[str] = DEFLECTIONS) -> Marks | None:
    """How the signals of the four wheels move; None where a drive does not tell."""
    reference, change = lateral_reference(grid), change_of_speed(grid)
    columns = [grid.get(name) for name in names]
    there = [column for column in columns if column is not None]
    if (
        reference is None
        or change is None
        or len(there) < len(columns)
        or not varied(reference[1], MIN_LATERAL)
    ):
        return None
    bends, slowing = smooth(reference[1]), -change
    wheels = [smooth(column) for column in there]
    rows = np.all(np.isfinite([*there, bends, slowing]), axis=0)
    if np.count_nonzero(rows) < _LEAST_CELLS:
        return None
    drivers = [clip(bends[rows]), clip(slowing[rows])]
    if not _moves(drivers) or abs(_correlation(*drivers)) > _APART:
        return None
    turned = [_partial([clip(column[rows]), *drivers]) for column in wheels]
    told = [found[0] for found in turned if found is not None and abs(found[0]) >= FOLLOWS]
    if len(told) < len(WHEELS):
        return None
    turning = {w: _sign(found, w in _PAIRS["right"]) for w, found in zip(WHEELS, told, strict=True)}
    braked = _braked(grid, wheels, bends, slowing) if _brakes(grid, slowing[rows]) else ()
    braking = {w: _sign(found, w in _PAIRS["front"]) for w, found in zip(WHEELS, braked, strict=False)}
    words = ", ".join(f"{w} {found:+.2f}" for w, found in zip(WHEELS, told, strict=True))
    figures = f"correlations with {reference[0]}: {words}"
    if braked:
        words = ", ".join(f"{w} {found:+.2f}" for w, found in zip(WHEELS, braked, strict=True))
        figures += f"; with the loss of speed by the pedals: {words}"
    return Marks(turning, braking, figures)


def _brakes(grid: Grid, slowing: FloatArray) -> bool:
    """Whether the vehicle brakes or speeds up at all, by a speed whose sign is beyond doubt."""
    return seconds(np.abs(slowing) > _MIN_CHANGE) >= 1.0 and not backwards(grid)


def _braked(
    grid: Grid, wheels: Sequence[FloatArray], bends: FloatArray, slowing: FloatArray
) -> tuple[float, ...]:
    """Partial correlations of the wheels (n,) with the loss of speed (n,) where that is the pedals', whatever the road does; empty where they do
    not tell of all wheels."""
    ways: list[View] = list(pedalled(slowing))
    if level(grid):
        ways.append((as_it_is, slowing, np.isfinite(slowing)))
    for taken, driving, where in ways:
        columns = [taken(column) for column in (*wheels, bends)]
        rows = np.all(np.isfinite([*columns, driving]), axis=0) & where
        if np.count_nonzero(rows) < MIN_CELLS:
            continue
        drivers = [clip(columns[-1][rows]), clip(driving[rows])]
        if not _moves(drivers) or abs(_correlation(*drivers)) > _APART:
            continue
        found = [_partial([clip(column[rows]), *drivers]) for column in columns[:-1]]
        told = tuple(each[1] for each in found if each is not None and abs(each[1]) >= FOLLOWS)
        if len(told) == len(wheels):
            return told
    return ()


def _sign(correlation: float, positive: bool) -> int:
    return 1 if (correlation > 0) == positive else -1


def _moves(columns: Sequence[FloatArray]) -> bool:
    return all(float(np.std(column)) > 0 for column in columns)


def _correlation(first: FloatArray, second: FloatArray) -> float:
    return float(np.mean((first - first.mean()) * (second - second.mean())) / first.std() / second.std())


def _partial(columns: Sequence[FloatArray]) -> tuple[float, float] | None:
    """Correlation of the first column with each of the other two, what the third explains taken off; None where one stands still."""
    if not _moves(columns):
        return None
    first, second, third = columns
    a, b, c = _correlation(first, second), _correlation(first, third), _correlation(second, third)
    left = np.sqrt(np.maximum([(1 - b * b) * (1 - c * c), (1 - a * a) * (1 - c * c)], 1e-12))
    return float((a - b * c) / left[0]), float((b - a * c) / left[1])
