"""Changes of speed that only pedals make: quicker, or larger, than any hill's; all of them where accel_x says that the road is level.

An accelerometer, and the springs, feel the change of speed and the grade: v' + g grade. On rolling roads a driver makes up for a part of the
grade alone, so that the vehicle slows while it is pushed: all that is felt goes against the change of speed, at a ratio that may be anything. Grades
change over some hundred metres, pedals within a second or two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray, Grid, Together, compare
from parsers.checks.motion import seconds, smooth, vehicle_speed

_SLOW_CELLS = 71
"""7.1 s: at 20 m/s a wave of the road is 400 m and more, of which a mean over 7.1 s leaves a tenth of its height out."""
_QUICK = 0.2
"""m/s² off the mean of 7.1 s: 8 % of grade that comes and goes within half a minute makes 0.05."""
_LARGE = 1.5
"""m/s²: 15 % of grade without any pedal."""
_SAME, _ALIKE = 0.9, 1.2
"""Least correlation of accel_x with the change of speed, and most of their ratio, on level roads: a pitching body has up to a tenth of it."""
_MOVES = 1.0
"""m/s."""
View = tuple[Callable[[FloatArray], FloatArray], FloatArray, BoolArray]


def change_of_speed(grid: Grid) -> FloatArray | None:
    """(n,) m/s², positive forwards, also where a signed speed says that the vehicle drives backwards; None without a speed."""
    speed = vehicle_speed(grid)
    return None if speed is None else grid.rate(smooth(speed))


def backwards(grid: Grid) -> bool:
    """Whether the speed is below zero for most of the drive: the vehicle drives backwards, or its speed has the wrong sign."""
    speed = vehicle_speed(grid)
    return speed is not None and seconds(speed < -_MOVES) > seconds(speed > _MOVES)


def pedalled(change: FloatArray) -> Iterator[View]:
    """Of a change of speed (n,), or its loss, m/s²: how a column is to be taken beside it, the change so taken, and where that is the pedals'."""
    quick = quickly(change)
    yield quickly, quick, np.abs(quick) > _QUICK
    yield as_it_is, change, np.abs(change) > _LARGE


def level(grid: Grid) -> bool:
    """Whether accel_x is the change of speed and nothing else: no grade goes into it."""
    forward, change = grid.get("accel_x"), change_of_speed(grid)
    found = None if forward is None or change is None else compare(smooth(forward), change)
    return found is not None and found.correlation >= _SAME and 1 / _ALIKE < found.ratio < _ALIKE


def quickly(values: FloatArray) -> FloatArray:
    """What is left of a column (n,) without its mean over 7.1 s."""
    return values - smooth(values, _SLOW_CELLS)


def as_it_is(values: FloatArray) -> FloatArray:
    """A column (n,) with all that it holds."""
    return values


def by_pedals(
    grid: Grid,
    felt: FloatArray,
    change: FloatArray,
    least: float,
    ratios: tuple[float, float] = (0.0, np.inf),
) -> Together | None:
    """How what is felt (n,) goes with the change of speed (n,), m/s², whatever the road does: None where no pedal tells.

    least: correlation from which it tells. ratios: of what is felt to the change of speed, between which they belong together.
    """
    felt, told = smooth(felt), list[Together]()
    for taken, driving, where in pedalled(change):
        told += _clear(compare(taken(felt), driving, where, centred=False), least, ratios)
    if not told and level(grid):
        told += _clear(compare(felt, change), least, ratios)
    return told[0] if len({found.sign for found in told}) == 1 else None


def _clear(found: Together | None, least: float, ratios: tuple[float, float]) -> list[Together]:
    clear = found is not None and abs(found.correlation) >= least and ratios[0] < found.ratio < ratios[1]
    return [found] if found is not None and clear else []
