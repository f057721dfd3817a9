"""Inertial signals, deflections and forces that are cut off at the end of a sensor's or a recorder's range: flat tops.

What is cut off is smaller than it was, by an unknown amount, exactly where the vehicle is driven hardest: no sample at all is honester.
It shows without knowing the range: a noisy signal never stands still at its largest value, again and again, unless it is held there. Signals that do
stay at an extreme (brake pressure, pedals, speeds, stops of steering) are not looked at, nor are those without noise, which
a simulator may hold anywhere. A spring on its stop still moves by more than the noise; a wheel that hangs at full droop may not, and
is then as little the force that its deflection stands for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray

_LOOKED_AT = (
    "roll_rate",
    "pitch_rate",
    "yaw_rate",
    "accel_",
    "suspension_deflection_",
    "suspension_force_",
    "tire_normal_force_",
)
_RUN = 4
_LEAST_RUNS = 3
_LEAST_SAMPLES = 20
_NEAR = 0.3
_LEAST_NEAR = 100
_MOST_REPEATS = 0.1
_LEAST_TURNS = 0.2
_LEAST_THIRDS = 0.6
_THIRDS_OF_NOISE = 0.6745 * 20**0.5
"""Median size of the third differences of white noise, over its standard deviation."""


@dataclass(frozen=True)
class Limits:
    """Values at which a signal is cut off; NaN where it is not."""

    low: float
    high: float

    def reached(self, values: FloatArray) -> BoolArray:
        """Which of the values (n,) are cut off."""
        return np.asarray((values == self.low) | (values == self.high), dtype=np.bool_)


def flat_tops(name: str, values: FloatArray) -> Limits | None:
    """Where a signal's values (n,) are cut off, or None. Stray values are to be taken out before."""
    if not name.startswith(_LOOKED_AT) or len(values) < _LEAST_NEAR:
        return None
    high, low = float(values.max()), float(values.min())
    above, below = high > 0 and _flat(values, high), low < 0 and _flat(-values, -low)
    if not (above or below):
        return None
    # a range mostly ends alike on both sides, and the other end may be reached but a few times
    alike = high == -low
    return Limits(low if below or alike else np.nan, high if above or alike else np.nan)


def _flat(values: FloatArray, top: float) -> bool:
    """Whether noisy values (n,) are held at their largest one."""
    at = values == top
    if np.count_nonzero(at) < _LEAST_SAMPLES:
        return False
    edges = np.flatnonzero(np.diff(at, prepend=False, append=False))
    lengths = edges[1::2] - edges[::2]
    if np.count_nonzero(lengths >= _RUN) < _LEAST_RUNS:
        return False
    # how the signal moves where it is large, too, but not at the top
    near = (values > _NEAR * top) & ~at
    steps = np.diff(values)
    both = near[1:] & near[:-1]
    turns = (steps[1:] * steps[:-1])[both[1:] & both[:-1]]
    if len(turns) < _LEAST_NEAR or np.mean(steps[both] == 0) > _MOST_REPEATS:
        return False
    return bool(np.mean(turns < 0) >= _LEAST_TURNS) or _noisy(steps, both)


def _noisy(steps: FloatArray, both: BoolArray) -> bool:
    """Whether values whose steps (n,) are `both` near the top have noise of more than the steps that they come in.

    Noise is in third differences, which know no slope: a fast motion has few turns however noisy it is. Those of white noise
    turn round in 77 of 100 places.
    """
    inside = both[2:] & both[1:-1] & both[:-2]
    thirds = np.diff(steps, n=2)
    pairs = (thirds[1:] * thirds[:-1])[inside[1:] & inside[:-1]]
    if len(pairs) < _LEAST_NEAR // 2 or np.mean(pairs < 0) < _LEAST_THIRDS:
        return False
    some = np.abs(steps[steps != 0])
    spread = float(np.median(np.abs(thirds[inside]))) / _THIRDS_OF_NOISE
    return spread > float(some.min())
