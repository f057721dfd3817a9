"""Deflections that show far more or far less of the wheels' travel than a gyro that turns with the same body: inches, cm for mm, a lever.

The body turns against the horizon by what its springs and its tyres give: the springs' roll rate is 0.65 to 1 of the gyro's. A scale that
is off by less than a factor is weighed with the vehicle file, where there is one; beyond it all that rests on the deflections is wrong.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, compare
from parsers.checks.springs import DEFLECTIONS
from parsers.drive import Decision, Signal

TRACK_M = 1.55
"""Of a usual car; tracks of road vehicles lie between 1.25 and 2.1 m."""

LEAST, MOST = 0.45, 1.5
"""The springs' roll rate over the gyro's that tyres, tracks and springs inside the wheels explain, with room."""

TYRES = 0.85
"""The usual ratio: what a vehicle rolls on its tyres, the springs do not show."""

FOLLOWS = 0.85
ALIKE = 1.5
"""How far apart the two axles' ratios may be: tracks and tyres make a quarter."""
LEAST_RATE = 0.02
"""rad/s, rms of the gyro's roll rate: below it noise decides."""

HINTS = (
    (25.4, "mm called inches would be"), (10.0, "mm called cm would be"), (2.54, "cm called inches would be"),
    (1 / 2.54, "inches called cm would be"), (0.1, "cm called mm would be"), (1 / 25.4, "inches called mm would be"),
)  # fmt: skip
"""Factors of usual mistakes, and the words for them."""

NEAR = 1.2


def wrong_travel(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """All four deflections left out, where a gyro surely contradicts their size; nothing where it does not, or there is none."""
    if "roll_rate" not in signals or any(name not in signals for name in DEFLECTIONS):
        return []
    gyro = grid.get("roll_rate")
    if gyro is None:
        return []
    finite = gyro[np.isfinite(gyro)]
    if not len(finite) or float(np.std(finite)) < LEAST_RATE:
        return []
    found = [compare(grid.rate(rolling) / TRACK_M, gyro) for rolling in _axles(grid)]
    front, rear = found if len(found) == 2 else (None, None)
    if front is None or rear is None or min(abs(f.correlation) for f in (front, rear)) < FOLLOWS:
        return []
    # axles that contradict each other have another fault than a unit: a wheel's sign, a dead sensor
    if front.sign != rear.sign or max(front.ratio, rear.ratio) > ALIKE * min(front.ratio, rear.ratio):
        return []
    ratio = math.sqrt(front.ratio * rear.ratio)
    if LEAST <= ratio <= MOST:
        return []
    times = ratio / TYRES
    hint = next((words for factor, words in HINTS if factor / NEAR < times < factor * NEAR), "")
    text = f"deflections show {times:.2g} times the travel that roll_rate says the springs make"
    if hint:
        text += f", as {hint}"
    evidence = f"their roll rate is {ratio:.2g} of the gyro's (correlation {abs(front.correlation):.2f} over {front.seconds:.0f} s), 0.65 to 1 by tyres"
    action = "left out; say the unit, or a factor, in a mapping file"
    return [Decision(name, "range", text, action, evidence, applied=True) for name in DEFLECTIONS]


def _axles(grid: Grid) -> list[FloatArray]:
    """Right less left deflection of each axle that has both."""
    found = []
    for axle in "fr":
        left, right = (grid.get(f"suspension_deflection_{axle}{side}") for side in "lr")
        if left is not None and right is not None:
            found.append(right - left)
    return found
