"""Speeds that are negative all the way, faster than any reverse gear: a sign, and no drive backwards."""

from __future__ import annotations

import numpy as np

from parsers.checks.grid import Grid
from parsers.checks.motion import seconds
from parsers.checks.signs import SignResult
from parsers.checks.wording import show
from parsers.drive import Decision
from parsers.signals import WHEELS

_NAMES = ("speed", *(f"wheel_speed_{wheel}" for wheel in WHEELS))
_NO_REVERSE = 15.0
"""m/s: reverse gears end at 30 to 45 km/h."""
_MIN_SECONDS = 3.0
_MOVES, _MOST = 1.0, 0.98


def speed_signs(grid: Grid) -> SignResult:
    """Speeds whose sign is wrong; they come first, since lateral signs are held against yaw rate times speed."""
    decisions: list[Decision] = []
    for name in _NAMES:
        column = grid.get(name)
        if column is None or seconds(column < -_NO_REVERSE) < _MIN_SECONDS:
            continue
        moving = column[np.abs(column) > _MOVES]
        share = float(np.mean(moving < 0))
        if share < _MOST:
            continue
        text = f"{name} is negative all the way, down to {show(name, float(np.nanmin(column)))}, faster than any reverse gear"
        evidence = f"{100 * share:.0f} % of {seconds(np.abs(column) > _MOVES):.0f} s on the move"
        decisions.append(Decision(name, "sign", text, "inverted", evidence, applied=True))
    return SignResult(frozenset(each.signal for each in decisions), tuple(decisions), ())
