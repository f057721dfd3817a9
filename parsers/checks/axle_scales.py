"""Deflections of one axle that show another roll than the other's, or one wheel's than its neighbour's: one body leans on all of them.

The wheels of both axles see the same lean but for what tyres give (an axle that holds more of it stands a tenth more askew) and for
their tracks. Sensors at the springs of one axle, or a lever that one axle's scale does not know, show a quarter or more besides; which
axle is right, the log does not say; nor which of two wheels of an axle, where one moves far more than the other. A blind test's rear
deflections of 0.7 moved roll arm, roll gradient and CG height by 9 to 14 %.

A wheel that rests on its bump stop, under a load to one side, moves less as well, but shows the body's lean: its axle leans as the other
one does, while a sensor of k times the size makes that (1 + k) / 2 of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid
from parsers.drive import Decision, Signal
from parsers.signals import WHEELS

ALIKE = (0.8, 1.4)
"""Roll by the rear deflections over that by the front ones that tracks, bars and tyres explain: where a stiff bar has the front axle hold four
fifths of the roll, and its tyres give as much as its springs, the rear springs move by a third more."""
BESIDE = 0.2
"""ln of how much more one wheel of an axle may move than the other: one-sided loads on springs that stiffen make a sixth."""
SPAN = 41
"""Cells of the grid in whose middle a wheel is taken to stand: 4 s."""
LEAST_MOVED_M, LEAST_REST = 0.0015, 0.05
"""Spread of a wheel's quick motion from which on it tells its size, and what any one part of the drive must leave of its square."""
LEANS_RIGHT = 0.4
"""Share of what one sensor of another size would change of its axle's lean (ln), within which both are right, and the springs differ."""
ODD = (0.3, 3.0)
"""Beyond these something else is wrong: a sign, a dead sensor, one that is another's."""
BLOCKS, LEAST_CELLS = 10, 300
FOLLOWS = 0.85
"""Least correlation of each axle's roll with the lateral acceleration."""
SURE = 3.0
"""Standard deviations by which the ratio is beyond `ALIKE`."""
LEAST_MPS2, LEAST_M = 0.3, 0.002
"""Spread of the lateral acceleration, and of the difference of the front wheels, from which on the body rolls."""


def unlike_axles(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """All four deflections left out, where front and rear ones surely contradict each other; nothing where they go together."""
    found = _lean_of_rear(signals, grid)
    if found is None:
        return []
    ratio, std = found
    low, high = ALIKE
    if not ODD[0] < ratio < ODD[1] or low - SURE * std <= ratio <= high + SURE * std:
        return []
    evidence = f"{ratio:.2f} ± {std:.2f} of the front's, {low:g} to {high:g} by tracks, bars and tyres; one axle's scale is wrong, or its sensors stand elsewhere than at the wheels"
    text = "of the rear axle show another roll of the body than those of the front axle"
    action = "left out: which of the two axles is right, the log does not say"
    return [
        Decision(
            f"suspension_deflection_{wheel}", "range", f"deflections {text}", action, evidence, applied=True
        )
        for wheel in WHEELS
    ]


def unlike_sides(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """Both deflections of an axle left out, where one of them surely moves far more than the other, and not for its springs; what was kept is said."""
    found: list[Decision] = []
    for axle, end in (("front", "f"), ("rear", "r")):
        names = [f"suspension_deflection_{end}{side}" for side in "lr"]
        left, right = (grid.get(name) if name in signals else None for name in names)
        moved = None if left is None or right is None else _sizes(left, right)
        if moved is None:
            continue
        ratio, std = moved
        if abs(ratio) <= BESIDE + SURE * std:
            continue
        low, high = math.exp(-BESIDE), math.exp(BESIDE)
        evidence = f"the left wheel moves {math.exp(ratio):.2f} times as much as the right one (± {100 * std:.0f} %), {low:.2g} to {high:.2g} times where both sensors are right"
        text = f"deflections of the {axle} axle's wheels differ in size"
        lean = _lean_of_rear(signals, grid)
        if lean is not None and _of_springs(ratio, lean):
            name = names[0] if ratio < 0 else names[1]
            action = "kept: both show the body's lean as the other axle's do, so that this wheel rests on its bump stop, or on springs that stiffen, under a load to one side"
            found.append(Decision(name, "range", text, action, evidence, applied=False))
            continue
        action = "left out: which of both is right, the log does not say"
        found += [Decision(name, "range", text, action, evidence, applied=True) for name in names]
    return found


def _of_springs(moved: float, lean: tuple[float, float]) -> bool:
    """Whether an axle leans as one does whose sensors are right. moved: ln of the left wheel's motion over the right one's; lean: of the rear
    axle over the front, and its standard deviation."""
    least = min(abs(math.log((1 + math.exp(size)) / 2)) for size in (moved, -moved))
    ratio, std = lean
    return ratio > 0 and abs(math.log(ratio)) + SURE * std / ratio < LEANS_RIGHT * least


def _lean_of_rear(signals: Mapping[str, Signal], grid: Grid) -> tuple[float, float] | None:
    """Roll by the rear deflections over that by the front ones, and its standard deviation; None where the drive does not tell."""
    names = [f"suspension_deflection_{wheel}" for wheel in WHEELS]
    columns = [grid.get(name) if name in signals else None for name in names]
    accel = grid.get("accel_y") if "accel_y" in signals else None
    there = [column for column in (*columns, accel) if column is not None]
    if accel is None or len(there) != len(names) + 1:
        return None
    rows = np.all(np.isfinite(there), axis=0)
    if np.count_nonzero(rows) < LEAST_CELLS:
        return None
    fl, fr, rl, rr, side = (column[rows] for column in there)
    return _ratio(fr - fl, rr - rl, side)


def _sizes(left: FloatArray, right: FloatArray) -> tuple[float, float] | None:
    """ln of how much more one wheel moves than the other within some seconds, and its standard deviation, from parts left out in turn."""
    rows = np.isfinite(left) & np.isfinite(right)
    if np.count_nonzero(rows) < LEAST_CELLS:
        return None
    middle = np.ones(SPAN) / SPAN
    quick = [
        (column - np.convolve(column, middle, mode="same"))[SPAN:-SPAN]
        for column in (left[rows], right[rows])
    ]
    if min(float(np.std(column)) for column in quick) < LEAST_MOVED_M:
        return None
    sums = np.array([[float(part @ part) for part in np.array_split(column, BLOCKS)] for column in quick])
    whole = sums.sum(axis=1)
    rest = whole[:, None] - sums
    if (rest < LEAST_REST * whole[:, None]).any():
        return None
    std = _scatter(0.5 * np.log(rest[0] / rest[1]))
    return 0.5 * float(np.log(whole[0] / whole[1])), std


def _scatter(without: FloatArray) -> float:
    """Standard deviation of a figure, from what it is (BLOCKS,) without one part of the drive after another."""
    return float(np.sqrt((BLOCKS - 1) / BLOCKS * np.sum((without - without.mean()) ** 2)))


def _ratio(front: FloatArray, rear: FloatArray, side: FloatArray) -> tuple[float, float] | None:
    """The rear's slope on the lateral acceleration over the front's, and its standard deviation from parts of the drive left out in turn."""
    if float(np.std(side)) < LEAST_MPS2 or float(np.std(front)) < LEAST_M:
        return None
    for each in (front, rear):
        if not np.std(each) > 0 or abs(float(np.corrcoef(each, side)[0, 1])) < FOLLOWS:
            return None
    parts = [
        [float(np.mean((each - each.mean()) * (s - s.mean())) * len(s)) for each in (f, r)]
        for f, r, s in zip(*(np.array_split(column, BLOCKS) for column in (front, rear, side)), strict=True)
    ]
    sums = np.array(parts)
    whole = sums.sum(axis=0)
    rest = whole - sums
    if whole[0] == 0 or not (rest[:, 0] * whole[0] > 0).all():
        return None
    return float(whole[1] / whole[0]), _scatter(rest[:, 1] / rest[:, 0])
