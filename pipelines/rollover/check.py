"""The rollover coefficient from tyre forces against the one from accelerations: does the verdict's height agree?"""

from __future__ import annotations

import itertools
import math

import numpy as np

from parsers.signals import WHEELS
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.rollover.limits import coefficient_of_forces
from pipelines.rollover.margin import DriveMargin
from pipelines.rollover.motion import CUTOFF_HZ, Motion
from pipelines.rollover_results import CoefficientCheck
from pipelines.tire_forces import TireForces

LEAST_RMS = 0.05
LEAST_TURNING_S = 3.0
BLOCKS = 16
FORCE_SCALE_STD = 0.01
CONFLICT = 2.0
_95 = 1.959964


def slow_forces(forces: TireForces) -> dict[str, FloatArray]:
    """wheel -> (n,) low-passed as the motion is, gap-free stretch by stretch; NaN where not known."""
    rate = 1 / float(np.median(np.diff(forces.time_s))) if len(forces.time_s) > 1 else 0.0
    found = {}
    for wheel in WHEELS:
        values = np.full(len(forces.time_s), np.nan)
        for first, past in runs(np.isfinite(forces.value[wheel])):
            values[first:past] = lowpass(forces.value[wheel][first:past], rate, CUTOFF_HZ)
        found[wheel] = values
    return found


def by_forces(slow: dict[str, FloatArray]) -> FloatArray:
    """(n,) the coefficient (158) on the forces' own clock."""
    return np.asarray(coefficient_of_forces(*(slow[w] for w in WHEELS)))


def spread_of_forces(forces: TireForces, slow: dict[str, FloatArray], row: int) -> float:
    """Standard deviation of (158) at a row, from the forces' intervals."""
    total = sum(float(slow[w][row]) for w in WHEELS)
    share = by_forces({w: slow[w][row : row + 1] for w in WHEELS})[0]
    variance = 0.0
    for wheel in WHEELS:
        std = float(forces.high[wheel][row] - forces.low[wheel][row]) / (2 * _95)
        sign = 1.0 if wheel.endswith("l") else -1.0
        variance += ((sign - share) * std / total) ** 2
    return math.sqrt(variance)


def onto(motion: Motion, time_s: FloatArray, values: FloatArray) -> FloatArray:
    """(n,) on the motion's clock; NaN outside and in gaps."""
    known = np.isfinite(values)
    if known.sum() < 2:
        return np.full(len(motion.time_s), np.nan)
    found = np.interp(motion.time_s, time_s[known], values[known], left=np.nan, right=np.nan)
    nearest = np.clip(np.searchsorted(time_s, motion.time_s), 1, len(time_s) - 1)
    there = known[nearest] & known[nearest - 1]
    return np.where(there, found, np.nan)


def _slope(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Slope of y = a + b x, and its error by leaving out one stretch of the drive after the other."""
    edges = np.linspace(0, len(x), BLOCKS + 1).astype(int)
    sums = np.array(
        [
            [b - a, x[a:b].sum(), y[a:b].sum(), (x[a:b] ** 2).sum(), (x[a:b] * y[a:b]).sum()]
            for a, b in itertools.pairwise(edges)
        ]
    )

    def solve(s: FloatArray) -> float:
        n, sx, sy, sxx, sxy = s
        return float((n * sxy - sx * sy) / max(n * sxx - sx * sx, 1e-12))

    total = sums.sum(axis=0)
    without = np.array([solve(total - row) for row in sums])
    error = math.sqrt((BLOCKS - 1) / BLOCKS * float(np.sum((without - without.mean()) ** 2)))
    return solve(total), error


def compare(found: DriveMargin, from_forces: FloatArray) -> CoefficientCheck | None:
    """Slope of (158) over (160), with what the verdict allows for; None where the drive turns too little.

    from_forces: (n,) on the motion's clock. Only below 0.9: at the limit the wheels' loads stop changing.
    """
    accelerations = found.coefficient
    rows = np.isfinite(from_forces) & (np.abs(accelerations) < 0.9) & (np.abs(from_forces) < 0.9)
    x, y = accelerations[rows], from_forces[rows]
    turning = (
        np.sum(np.abs(x) > LEAST_RMS) * float(np.median(np.diff(found.motion.time_s))) if len(x) > 2 else 0.0
    )
    if turning < LEAST_TURNING_S or float(x.std()) < LEAST_RMS:
        return None
    slope, error = _slope(x, y)
    allowed = float(np.std(found.either)) / max(float(np.mean(found.either)), 1e-3)
    std = math.hypot(error, FORCE_SCALE_STD)
    apart = abs(slope - 1) / math.hypot(std, allowed)
    rms = float(np.sqrt(np.mean((y - x) ** 2)))
    consistent = apart <= CONFLICT
    more = 100 * (slope - 1)
    text = (
        f"the tyre forces move {abs(more):.1f} % {'more' if more >= 0 else 'less'} load across than the verdict's height, track and roll explain: "
        + (
            "within what their intervals allow"
            if consistent
            else "beyond what their intervals allow; the height or the track is in doubt"
        )
    )
    estimate = ParameterEstimate(
        "coefficient_slope", slope, std, slope - _95 * std, slope + _95 * std, "identified", text, None, 1.0, ("tyre forces",)
    )  # fmt: skip
    return CoefficientCheck(estimate, rms, consistent, text)
