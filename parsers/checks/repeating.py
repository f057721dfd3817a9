"""Signals that keep one value for long: of a sensor that froze, or of a quiet stretch of road and coarse steps.

A straight of a minute and a half leaves a roll angle in steps of half a degree at one value, and its sensor is as it was in the bends before. So what is moved
by the same is asked: where that has gone quiet as well, by so much that the signal's motion is less than its steps, nothing is frozen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.checks.grid import CELL_S, BoolArray, Grid
from parsers.checks.pedals import change_of_speed
from parsers.checks.wording import show
from parsers.drive import Signal
from parsers.quantiles import distinct, quantile

_ACROSS = ("accel_y", "yaw_rate", "roll", "roll_rate", "steering_wheel_angle")
_CHANGE = "change of speed"
_ALONG = ("accel_x", "pitch", "pitch_rate", _CHANGE)
_LOADS = ("axle_load_front", "axle_load_rear")
_LIKES = {
    **dict.fromkeys(_ACROSS[:-1], _ACROSS), **dict.fromkeys(_ALONG[:-1], _ALONG),
    "accel_z": ("roll_rate", "pitch_rate", "accel_x", "accel_y"), **dict.fromkeys(_LOADS, (*_ALONG, *_LOADS)),
}  # fmt: skip
"""Signal -> what moves where it does."""
REPEATING = tuple(_LIKES)
"""Signals that always move on the road: none of them keeps one value, but for the steps that it comes in."""
LONG_S, TIMES = 5.0, 20.0
"""One value that is kept for so long, and so many times as long as others usually are, is no measurement, unless all is quiet."""
_CELLS, _USUAL = 50, 0.7
_SAME = 1e-9
"""Of a signal's range: values nearer to each other differ by rounding alone."""
_LEAST_STEPS = 1.0
"""Steps by which a signal would have to spread within 5 s, were it as quiet as its likes: below that it may well stand."""
_FINE_STEPS = 20.0
"""Spread in steps elsewhere from which on a sensor's own noise moves it on the quietest road."""


@dataclass(frozen=True)
class Held:
    """One value kept for long. since_s: from the drive's start. share: of the time in which the vehicle moves."""

    found: str
    since_s: float
    share: float
    evidence: str


def repeated(signal: Signal, grid: Grid, moving: BoolArray) -> Held | None:
    """A signal that keeps one value for far longer than its steps usually last, while the vehicle, and what moves with it, moves."""
    values, time_s = signal.values, (signal.time_ns - _start(grid)) / 1e9
    if len(values) < 100:
        return None
    begins = np.flatnonzero(np.append(True, values[1:] != values[:-1]))
    if len(begins) < 20:
        return None
    ends = np.append(begins[1:], len(values)) - 1
    lasted = time_s[ends] - time_s[begins]
    usual = quantile(lasted, 0.99)
    longest = int(np.argmax(lasted))
    if lasted[longest] < max(LONG_S, TIMES * usual):
        return None
    held = (grid.time_s >= time_s[begins[longest]]) & (grid.time_s <= time_s[ends[longest]])
    driven = np.count_nonzero(held & moving)
    if driven * CELL_S < LONG_S or _quiet(signal, grid, held, moving):
        return None
    share = driven / max(int(np.count_nonzero(moving)), 1)
    evidence = f"one value for {lasted[longest]:.0f} s, of which the vehicle moves {driven * CELL_S:.0f} s; otherwise for {usual:.2g} s at the most"
    found = f"keeps the value {show(signal.name, float(values[begins[longest]]))}"
    return Held(found, float(time_s[begins[longest]]), share, evidence)


def _quiet(signal: Signal, grid: Grid, held: BoolArray, moving: BoolArray) -> bool:
    """Whether the signal may well stand while it is held (n,), since its likes hardly move there."""
    inside, outside = np.flatnonzero(held & moving), np.flatnonzero(~held & moving)
    if min(len(inside), len(outside)) < _CELLS:
        return False
    spread = _spread(grid.columns[signal.name], outside, _USUAL) / _step(signal.values)
    shares = []
    for name in _LIKES[signal.name]:
        column = change_of_speed(grid) if name == _CHANGE else grid.get(name)
        if name == signal.name or column is None:
            continue
        there, elsewhere = _spread(column, inside, 1.0), _spread(column, outside, _USUAL)
        # what stands altogether may be frozen with it, or have coarse steps as well
        if there > _SAME * elsewhere > 0:
            shares.append(there / elsewhere)
    if not shares:
        return spread < _FINE_STEPS
    return spread * quantile(np.array(shares), 0.5) < _LEAST_STEPS


def _spread(column: FloatArray, cells: IntArray, share: float) -> float:
    """The standard deviation of a column (n,) within 5 s of some of its cells that so many are not above; NaN where it has no values."""
    windows = np.std(column[cells[: len(cells) // _CELLS * _CELLS]].reshape(-1, _CELLS), axis=1)
    known = windows[np.isfinite(windows)]
    return quantile(known, share) if len(known) else math.nan


def _step(values: FloatArray) -> float:
    """The step that values (n,) come in; next to nothing where they come in none."""
    apart = np.diff(distinct(values))
    return quantile(apart[apart > _SAME * float(np.ptp(values))], 0.1)


def _start(grid: Grid) -> int:
    """The moment from which the grid counts, ns."""
    return min(int(signal.time_ns[0]) for signal in grid.made_of.values())
