"""Which axis of an inertial unit feels gravity: one whose y or x does is not mounted upright, and every axis of it is another one's.

So cameras' units are, whose axes are those of the picture (x to the right, y down, z ahead).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.drive import Decision, Signal
from parsers.quantiles import median
from parsers.units import STANDARD_GRAVITY

ALL_OF_IT = (0.85, 1.15)
"""In g: what an axis along gravity reads at its median, whatever the drive; no bend lasts as long."""

NONE_OF_IT = 0.35
"""In g: what the vertical axis reads at most at its median for another one to be the upright one."""

FEWEST = 100
UNIT = ("accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch")


def not_upright(signals: Mapping[str, Signal]) -> dict[str, Decision]:
    """The signals of such a unit, which are left out, all with one decision. signals: as they came."""
    upward = signals.get("accel_z")
    if upward is None or len(upward.values) < FEWEST:
        return {}
    middle = median(upward.values) / STANDARD_GRAVITY
    if abs(middle) > NONE_OF_IT:
        return {}
    for name in ("accel_y", "accel_x"):
        signal = signals.get(name)
        if signal is None or signal.group != upward.group or len(signal.values) < FEWEST:
            continue
        felt = median(signal.values) / STANDARD_GRAVITY
        if ALL_OF_IT[0] < abs(felt) < ALL_OF_IT[1] and _all_the_time(signal.values / STANDARD_GRAVITY, felt):
            names = tuple(n for n in UNIT if n in signals and signals[n].group == upward.group)
            return dict.fromkeys(names, _decision(name, felt, middle, names))
    return {}


def _all_the_time(values: FloatArray, felt: float) -> bool:
    """Whether an axis reads its median's sign all the time: along or across a vehicle braking and bends go either way."""
    return float(np.mean(values * np.sign(felt) > 0.2)) > 0.98


def _decision(name: str, felt: float, middle: float, names: tuple[str, ...]) -> Decision:
    axis, up = name[-1], "up" if felt > 0 else "down"
    action = f"left out, with all that the unit measures ({len(names)} signals); a mapping file can turn it"
    if name == "accel_y" and felt < 0:
        action += ": of a camera's (x right, y down, z ahead) accel_x is z's channel, accel_y -1 × x's, accel_z -1 × y's, rates alike"
    return Decision(
        "accel_z", "choice",
        f"the inertial unit is not mounted upright: gravity is on its {axis} axis, which points {up}",
        action, f"medians: {name} {felt:+.2f} g, accel_z {middle:+.2f} g; {', '.join(names)}", applied=True,
    )  # fmt: skip
