"""Channels that change from sample to sample as no vehicle does: read with the wrong byte order, start bit or length of a CAN database.

Of such a channel the low bits rule the value: it is as large as its range and knows nothing of the sample before. A sensor's noise knows
as little, but is small; a vehicle's motion is large, and lasts over many samples.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.checks.wording import show
from parsers.drive import Decision, Signal

LOUD: dict[str, float] = {
    "accel_x": 6.0, "accel_y": 6.0, "roll_rate": 0.8, "pitch_rate": 0.8, "yaw_rate": 0.8, "roll": 0.25, "pitch": 0.25,
    "steering_wheel_angle": 3.0, "speed": 15.0, "wheel_speed": 15.0, "brake_pressure": 4e6, "suspension_deflection": 0.06,
}  # fmt: skip
"""SI: a spread that no drive's noise reaches."""

LASTS = 0.8
"""Correlation of neighbouring samples below which a signal of that size is no motion: at 10 Hz a slalom has 0.95."""

CLOSE_S = 0.12
"""Neighbours are samples no further apart than this: a vehicle's motion is slower."""

FEWEST = 200


def scrambled(signals: Mapping[str, Signal]) -> dict[str, Decision]:
    """The signals that are left out for it, each with its decision."""
    found = {}
    for name, signal in signals.items():
        loud = LOUD.get(name) or LOUD.get(name.rsplit("_", 1)[0])
        if loud is None or len(signal.values) < FEWEST:
            continue
        spread = float(np.std(signal.values))
        if not spread > loud:
            continue
        together = _together(signal, spread)
        if together is not None and together < LASTS:
            found[name] = Decision(
                name, "range",
                f"{name} changes from sample to sample as no vehicle does: its byte order, start bit or length is another, or it is another channel",
                "left out; correct the CAN database or the mapping file",
                f"spread {show(name, spread)}, correlation of neighbouring samples {together:.2f}", applied=True,
            )  # fmt: skip
    return found


def _together(signal: Signal, spread: float) -> float | None:
    """Correlation of neighbouring samples; None where there are too few."""
    close = np.diff(signal.time_ns) < CLOSE_S * 1e9
    if np.count_nonzero(close) < FEWEST // 2:
        return None
    steps = np.diff(signal.values)[close]
    return 1 - 0.5 * float(np.mean(steps * steps)) / spread**2
