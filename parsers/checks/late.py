"""Channels that come late: what two of them say of one motion is the same, some time apart.

Receivers, bridges between buses and filters hold a channel back by tens to hundreds of milliseconds. Fits allow for a delay where they know of one;
a tenth of a second or more is a fault of the recording that its owner will want to hear of.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks import far_lags
from parsers.checks.far_lags import at_far_lags
from parsers.checks.grid import CELL_S, MIN_CELLS, Grid, clip, go_together
from parsers.checks.motion import smooth
from parsers.checks.springs import springs_tilt
from parsers.drive import Decision

LEAST_S = 0.08
"""Below it, filters and what lies between two motions (a body rolls after the wheels are steered) may look like a delay."""

SLOW_S = 0.2
"""The same for motions between which a vehicle's own dynamics lie: slip grows, tyres give way, a tall body leans late (157 ms were a lorry's own)."""

ALLOWED_S = 0.2
"""The most that fits look for."""

LOOSE_S = 0.5
"""The same where one makes the other by way of tyres or springs."""

FARTHEST = 8
"""Cells that are looked over one by one, either way; further off, to five seconds, what is most alike is brought next to each other first."""

ALIKE = 0.8
"""Least correlation at the best lag."""

NEARER = 0.02
"""Likeness that a second more must bring: a weave is as like itself a wave later."""

LEAVES = 0.5
"""Share of what is unlike without a lag that may be left at the best one."""

PARTS = 4
"""Into so many stretches the drive is cut: they have to agree within `SCATTER_S`, or `SCATTER` of the delay: in slow bends it is hardly seen."""
SCATTER_S, SCATTER = 0.04, 0.4
MOVING_MPS = 10.0
"""In slower bends what is felt three metres ahead of the CG comes a third of a second early."""


SPRINGS = "suspension_deflection"
"""What stands for all four where they are late together."""


@dataclass(frozen=True)
class Late:
    """first comes seconds after what second says of the same motion; said: what that is, in words."""

    first: str
    second: str
    said: str
    seconds: float
    correlation: float


def _pairs(grid: Grid) -> Iterator[tuple[str, str, str, FloatArray, FloatArray, float]]:
    """Names of both, what the second says in words, both columns, and the least delay to be told."""
    speed, yaw, across, along = (grid.get(n) for n in ("speed", "yaw_rate", "accel_y", "accel_x"))
    for angle in ("roll", "pitch"):
        tilt, rate, springs = grid.get(angle), grid.get(f"{angle}_rate"), springs_tilt(grid, angle)
        if tilt is not None and rate is not None:
            yield angle, f"{angle}_rate", f"{angle}_rate", grid.rate(tilt), rate, LEAST_S
        if tilt is not None and springs is not None:
            yield angle, "springs", "the suspension deflections", grid.rate(tilt), grid.rate(springs), LEAST_S
        if rate is not None and springs is not None:
            yield SPRINGS, f"{angle}_rate", f"{angle}_rate", grid.rate(springs), rate, LEAST_S
    if speed is not None and yaw is not None and across is not None:
        turning = np.where(np.abs(speed) > MOVING_MPS, yaw * speed, np.nan)
        yield "accel_y", "yaw_rate", "yaw_rate × speed", across, turning, SLOW_S
    steering, rolling = grid.get("steering_wheel_angle"), grid.get("roll_rate")
    if steering is not None and yaw is not None and speed is not None:
        curvature = yaw / np.where(np.abs(speed) > MOVING_MPS, speed, np.nan)
        yield "steering_wheel_angle", "yaw_rate", "yaw_rate over speed", steering, curvature, LOOSE_S
    if rolling is not None and across is not None and grid.get("roll") is None:
        yield "roll_rate", "accel_y", "the change of accel_y", rolling, grid.rate(across), LOOSE_S
    if speed is not None and along is not None:
        change = grid.rate(smooth(speed, 3))
        yield "speed", "accel_x", "accel_x", change, smooth(along, 3), SLOW_S


def _at_lags(first: FloatArray, second: FloatArray) -> FloatArray | None:
    """(2 FARTHEST + 1,) correlations, first taken that many cells later; None where too little of both is there."""
    if len(first) <= 2 * FARTHEST:
        return None
    inner = slice(FARTHEST, len(first) - FARTHEST)
    columns = [
        second[FARTHEST - lag : len(second) - FARTHEST - lag] for lag in range(-FARTHEST, FARTHEST + 1)
    ]
    both = np.isfinite(first[inner]) & np.logical_and.reduce([np.isfinite(column) for column in columns])
    if int(np.count_nonzero(both)) < MIN_CELLS:
        return None
    a = first[inner][both]
    found = [go_together(a, column[both], True) for column in columns]
    together = [each.correlation for each in found if each is not None]
    return np.array(together) if len(together) == len(columns) else None


def _clipped(values: FloatArray) -> FloatArray | None:
    """Stray values brought to the border of what is usual; None of a column in which nothing moves."""
    there = np.isfinite(values)
    if not there.any():
        return None
    result = values.copy()
    result[there] = clip(values[there])
    return result if np.ptp(result[there]) > 0 else None


def _peak(correlations: FloatArray) -> tuple[float, float] | None:
    """Lag in seconds, and the correlation there, of either sign; None at an end of what was looked over."""
    best = int(np.argmax(np.abs(correlations)))
    if best in (0, len(correlations) - 1):
        return None
    left, top, right = (abs(float(correlations[best + i])) for i in (-1, 0, 1))
    bend = left - 2 * top + right
    part = 0.5 * (left - right) / bend if bend < 0 else 0.0
    return (best - FARTHEST + part) * CELL_S, top


def _coarse(first: FloatArray, second: FloatArray) -> int:
    """Cells that first comes after second, where that is more than `_at_lags` looks over; of lags that are as good, the least."""
    found = at_far_lags(first, second)
    if found is None:
        return 0
    lags = np.arange(-far_lags.FARTHEST, far_lags.FARTHEST + 1)
    best = int(lags[np.argmax(found - NEARER * CELL_S * np.abs(lags))])
    return best if abs(best) > FARTHEST - 2 else 0


def _delay(first: FloatArray, second: FloatArray) -> tuple[float, float] | None:
    """Seconds that first comes after second, and their correlation; None where a drive's parts do not say the same."""
    at_hand = _at_lags(first, second)
    far = _coarse(first, second)
    if far and at_hand is not None:
        apart = (first[far:], second[:-far]) if far > 0 else (first[:far], second[-far:])
        found = _agreed(*apart, float(at_hand[FARTHEST]))
        if found is not None and found[1] > 0:
            return found[0] + far * CELL_S, found[1]
    return None if at_hand is None else _agreed(first, second, float(at_hand[FARTHEST]))


def _agreed(first: FloatArray, second: FloatArray, unmoved: float) -> tuple[float, float] | None:
    """`_delay` of columns that are brought next to each other. unmoved: correlation without a lag."""
    whole = _at_lags(first, second)
    found = None if whole is None else _peak(whole)
    if whole is None or found is None or found[1] < ALIKE:
        return None
    if 1 - found[1] ** 2 > LEAVES * (1 - unmoved**2):
        return None
    own = [_at_lags(a, b) for a, b in zip(np.array_split(first, PARTS), np.array_split(second, PARTS), strict=True)]  # fmt: skip
    lags = [peak[0] for c in own if c is not None and (peak := _peak(c)) is not None and peak[1] > ALIKE]
    if len(lags) < 2 or max(abs(lag - found[0]) for lag in lags) > max(SCATTER_S, SCATTER * abs(found[0])):
        return None
    return found


def delays(grid: Grid, left_out: Collection[str]) -> list[Late]:
    """The pairs that are apart by more than is usual."""
    found = []
    for first, second, said, mine, others, least in _pairs(grid):
        a, b = _clipped(mine), _clipped(others)
        if not {first, second}.isdisjoint(left_out) or a is None or b is None:
            continue
        delay = _delay(a, b)
        if delay is not None and abs(delay[0]) > least:
            found.append(Late(first, second, said, *delay))
    return found


def late(grid: Grid, left_out: Collection[str]) -> list[Decision]:
    """What is said of channels that come late, each once; they are left as they are. grid: with signs and units put right."""
    found: list[Decision] = []
    told: set[str] = set()
    for each in delays(grid, left_out):
        if each.first in told:
            continue
        told.add(each.first)
        order = "after" if each.seconds > 0 else "before"
        what = "the suspension deflections come" if each.first == SPRINGS else f"{each.first} comes"
        text = f"{what} {1000 * abs(each.seconds):.0f} ms {order} {each.said}"
        allowed = "fits of roll and pitch allow for a delay"
        if abs(each.seconds) > ALLOWED_S:
            allowed = "more than any fit allows for: what holds the two together is wrong"
        action = f"left as it is ({allowed}); put it right where the log is made"
        evidence = f"correlation {each.correlation:.2f} there"
        found.append(Decision(each.first, "delay", text, action, evidence, applied=False))
    return found
