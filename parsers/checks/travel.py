"""Deflections that show far more or far less of the wheels' travel than a gyro that turns with the same body: inches, cm for mm, a lever.

The body turns against the horizon by what its springs and its tyres give: the springs' roll rate is 0.65 to 1 of the gyro's. A scale that
is off by less than a factor is weighed with the vehicle file, where there is one; beyond it all that rests on the deflections is wrong.

A gyro turns with the road as well, wheels follow what is uneven, and on usual roads both are as large as the lean itself. So the two are
compared only in what each goes along with bends, within three seconds, in which hardly a road banks into a bend: what is the
road's in either of them stays out, and so does noise. Some roads do: superelevation of 4 % with run-offs of two seconds takes half of a
pickup's roll from the gyro (a ratio of 0.83 on level roads becomes 1.55), more of it all. So the ratio may be 2, and where the lateral
acceleration, hardly more than yaw rate times speed, says that roads bank, the gyro is no witness: then the lean that the springs show in
bends must be one that no vehicle has.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, Together, compare
from parsers.checks.leaning import swift
from parsers.checks.motion import MIN_SPEED, smooth, vehicle_speed
from parsers.checks.signs import lateral_reference, varied
from parsers.checks.springs import DEFLECTIONS
from parsers.drive import Decision, Signal

TRACK_M = 1.55
"""Of a usual car; tracks of road vehicles lie between 1.25 and 2.1 m."""

LEAST, MOST = 0.42, 2.0
"""The springs' roll rate over the gyro's that tyres, tracks, springs inside the wheels and roads explain, with room. Usual unit mistakes are
factors of 2.5 and more."""

BANKED = 1.03
"""Slowly changing lateral acceleration over yaw rate times speed: 1.03 to 1.2 by the body's lean on level roads. Below, the body leans by less
than 1.7 degrees per g against the horizon, tyres included: only a racing car's does, or one on roads that bank."""

SLOW_CELLS, TOGETHER = 31, 0.9
"""Over which the two are smoothed for that, and their least correlation."""

LEANS = (0.001, 0.04)
"""Lean on the springs, rad per m/s² (0.6 and 23 degrees per g): racing cars have 0.0012, loaded tractors in quick bends 0.021."""

TYRES = 0.85
"""The usual ratio: what a vehicle rolls on its tyres, the springs do not show."""

FOLLOWS, FOLLOWS_FELT = 0.5, 0.7
"""Least correlation of springs and gyro with bends; what is left is road and noise, and makes the ratio less sure. What is felt across has
the body's roll over uneven ground in it as well: there more is asked."""
ALIKE = 1.5
"""How far apart the two axles' ratios may be: tracks and tyres make a quarter."""
LEAST_MPS2 = 0.5
"""From the median of the lateral acceleration, for a second: below it noise decides."""

HINTS = (
    (25.4, "mm called inches would be"), (10.0, "mm called cm would be"), (2.54, "cm called inches would be"),
    (1 / 2.54, "inches called cm would be"), (0.1, "cm called mm would be"), (1 / 25.4, "inches called mm would be"),
)  # fmt: skip
"""Factors of usual mistakes, and the words for them."""

NEAR = 1.2


@dataclass(frozen=True)
class Share:
    """The roll that an axle's springs show over the gyro's, with its sign and its standard deviation. lean: of the springs by lateral
    acceleration, rad per m/s²."""

    ratio: float
    std: float
    seconds: float
    lean: float


def axle_shares(grid: Grid) -> dict[str, Share]:
    """The share of each axle ("f", "r") whose springs and whose gyro go along with bends clearly; none without a gyro or bends."""
    gyro, lateral = grid.get("roll_rate"), _lateral(grid)
    if gyro is None or lateral is None or not varied(lateral[0], LEAST_MPS2):
        return {}
    bends, follows = swift(grid.rate(lateral[0])), lateral[1]
    body = compare(swift(gyro), bends)
    if body is None or abs(body.correlation) < follows:
        return {}
    shares = {}
    for axle, springs in axle_leans(grid).items():
        ratio = springs.correlation * springs.ratio / (body.correlation * body.ratio)
        # of two slopes, each known by about one independent value a second
        spread = sum((1 / each.correlation**2 - 1) / each.seconds for each in (springs, body))
        shares[axle] = Share(
            ratio, abs(ratio) * math.sqrt(spread), springs.seconds, springs.correlation * springs.ratio
        )
    return shares


def axle_leans(grid: Grid) -> dict[str, Together]:
    """How the lean that the springs of each axle ("f", "r") show goes along with bends, rad by m/s²; of those that do so clearly."""
    lateral = _lateral(grid)
    if lateral is None or not varied(lateral[0], LEAST_MPS2):
        return {}
    bends, follows = swift(grid.rate(lateral[0])), lateral[1]
    leans = {}
    for axle, rolling in _axles(grid).items():
        springs = compare(swift(grid.rate(rolling) / TRACK_M), bends)
        if springs is not None and abs(springs.correlation) >= follows:
            leans[axle] = springs
    return leans


def _lateral(grid: Grid) -> tuple[FloatArray, float] | None:
    """Yaw rate times speed, m/s², into which no uneven ground goes, else what is felt across; and the correlation from which it tells."""
    turning = lateral_reference(grid.without({"accel_y"}))
    if turning is not None:
        return turning[1], FOLLOWS
    felt = lateral_reference(grid)
    return None if felt is None else (felt[1], FOLLOWS_FELT)


def felt_over_driven(grid: Grid) -> float:
    """Slowly changing lateral acceleration over yaw rate times speed; NaN where the two do not go together clearly."""
    lateral, yaw, speed = grid.get("accel_y"), grid.get("yaw_rate"), vehicle_speed(grid)
    if lateral is None or yaw is None or speed is None:
        return math.nan
    driven = yaw * np.where(np.abs(speed) > MIN_SPEED, speed, np.nan)
    found = compare(smooth(lateral, SLOW_CELLS), smooth(driven, SLOW_CELLS))
    if found is None or abs(found.correlation) < TOGETHER:
        return math.nan
    return abs(found.correlation) * found.ratio


def _explained(grid: Grid, ratio: float, std: float, lean: float) -> bool:
    """Whether tyres, tracks and roads may make the roll that springs show over the gyro's. lean: see `Share`."""
    if LEAST - std <= ratio <= MOST + std:
        return True
    return felt_over_driven(grid) < BANKED and LEANS[0] <= lean <= LEANS[1]


def wrong_travel(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """All four deflections left out, where a gyro surely contradicts their size; nothing where it does not, or there is none."""
    if "roll_rate" not in signals or any(name not in signals for name in DEFLECTIONS):
        return []
    shares = axle_shares(grid)
    if len(shares) < 2:
        return []
    front, rear = shares["f"], shares["r"]
    sizes = sorted((abs(front.ratio), abs(rear.ratio)))
    # axles that contradict each other have another fault than a unit: a wheel's sign, a dead sensor
    if front.ratio * rear.ratio <= 0 or sizes[1] > ALIKE * sizes[0]:
        return []
    ratio, std = math.sqrt(sizes[0] * sizes[1]), max(front.std, rear.std)
    lean = math.sqrt(abs(front.lean * rear.lean))
    if _explained(grid, ratio, std, lean):
        return []
    times = ratio / TYRES
    hint = next((words for factor, words in HINTS if factor / NEAR < times < factor * NEAR), "")
    text = f"deflections show {times:.2g} times the travel that roll_rate says the springs make"
    if hint:
        text += f", as {hint}"
    evidence = f"their roll rate is {ratio:.2g} ± {std:.1g} of the gyro's in bends (over {front.seconds:.0f} s), 0.65 to 1 by tyres"
    action = "left out; say the unit, or a factor, in a mapping file"
    return [Decision(name, "range", text, action, evidence, applied=True) for name in DEFLECTIONS]


def _axles(grid: Grid) -> dict[str, FloatArray]:
    """Right less left deflection of each axle ("f", "r") that has both, m."""
    found = {}
    for axle in "fr":
        left, right = (grid.get(f"suspension_deflection_{axle}{side}") for side in "lr")
        if left is not None and right is not None:
            found[axle] = right - left
    return found
