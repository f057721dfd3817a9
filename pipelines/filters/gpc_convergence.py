"""Has a gPC-EKF converged, was the excitation enough, and is its interval to be believed? (dissertation 3.4.3, 3.5)"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipelines.filters.gpc_filter import StateSpaceRun
from pipelines.results import FloatArray

Excitation = Literal["sufficient", "weak", "insufficient"]

EXPANDS = 1.2
"""A spread expands where most of a run's last quarter (its 20 % quantile) lies this much above most of its second (80 %).

Under band-limited noise the spread goes up and down by half and this ratio stayed below 1, under a sine it was above 1.4.
"""

LITTLE, MUCH = 0.5, 0.9
"""What is left of the first spread: above LITTLE the data taught little, above MUCH nothing to speak of."""

SETTLED = 0.05
"""Share of the velocity's deviation below which the two velocities are one."""


@dataclass(frozen=True)
class VelocityTest:
    """The test of 3.5. derivative, velocity: (n,), of the filter's position, and the filter's own smoothed alike, NaN at the
    ends. difference: (n,) their moving RMS over the velocity's deviation. settled_s: from when on it stays below SETTLED,
    None where it does not.
    """

    derivative: FloatArray
    velocity: FloatArray
    difference: FloatArray
    settled_s: float | None


def smoothing_slope(window: int, step_s: float) -> tuple[FloatArray, FloatArray]:
    """Weights of the slope of a parabola through `window` points (Savitzky & Golay), and of the mean that belongs to it.

    slope . x is exactly mean . x' for any x that is a polyline: (window,) and (window - 1,). Comparing the slope with the
    velocity itself, as printed, leaves the smoothing's own error; comparing with the mean does not.
    """
    if window < 3 or window % 2 == 0:
        raise ValueError("the window is an odd number of points, 3 or more")
    places = np.arange(window) - window // 2
    slope = places / (step_s * np.sum(places**2))
    return slope, np.asarray(-np.cumsum(slope)[:-1] * step_s)


def velocity_test(
    time_s: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    *,
    window: int = 41,
    over_s: float = 5.0,
    fair: bool = True,
) -> VelocityTest:
    """Compare the derivative of the filter's position with its velocity, all (n,) at even steps (3.5, (68)-(69)).

    The position follows the sensor whatever the parameters; the velocity does so only with the right ones. window: of the
    smoothing (printed: 41). over_s: of the moving RMS. fair: smooth the velocity alike (printed: not).
    """
    rows = len(time_s)
    if rows < 2 * window or position.shape != velocity.shape or position.shape != (rows,):
        raise ValueError("position and velocity are as long as the time, and longer than two windows")
    step = float(time_s[1] - time_s[0])
    slope, mean = smoothing_slope(window, step)
    half = window // 2
    derivative, own = np.full(rows, np.nan), np.full(rows, np.nan)
    derivative[half : rows - half] = np.correlate(position, slope, "valid")
    middle = 0.5 * (velocity[1:] + velocity[:-1])
    own[half : rows - half] = np.correlate(middle, mean, "valid") if fair else velocity[half : rows - half]
    square = np.nan_to_num((derivative - own) ** 2)
    count = max(1, round(over_s / step))
    total = np.concatenate([[0.0], np.cumsum(square)])
    ends = np.arange(1, rows + 1)
    begins = np.maximum(ends - count, 0)
    deviation = float(np.nanstd(derivative[rows // 2 :]))
    difference = np.sqrt((total[ends] - total[begins]) / (ends - begins)) / max(deviation, 1e-300)
    above = np.flatnonzero(~(difference < SETTLED))
    first = 0 if not len(above) else int(above[-1]) + 1
    # the moving RMS looks back: it tells of nothing before it is full
    settled = None if first >= rows - half else float(time_s[max(first, min(count, rows - 1))])
    return VelocityTest(derivative, own, difference, settled)


@dataclass(frozen=True)
class SpreadReport:
    """What became of a parameter's spread.

    left: last over first. growth: most of the last quarter over most of the second. excitation and reason: in words.
    """

    left: float
    growth: float
    excitation: Excitation
    reason: str


def spread_report(run: StateSpaceRun, name: str, *, additions: bool) -> SpreadReport:
    """Judge the excitation from a parameter's spread (3.4.3). additions: the run had additions to the distribution.

    With additions the spread of what the drive does not show grows without end; without, it stays where it began.
    """
    i = run.names.index(name)
    std = run.std[:, i]
    if run.diverged:
        return SpreadReport(np.inf, np.inf, "insufficient", "the filter lost itself")
    tenth = max(1, len(std) // 10)
    last, quarter = float(np.median(std[-tenth:])), max(1, len(std) // 4)
    early = float(np.quantile(std[quarter : 2 * quarter + 1], 0.8))
    late = float(np.quantile(std[-quarter:], 0.2))
    left = last / float(run.start_std[i]) if run.start_std[i] > 0 else np.inf
    growth = late / early if early > 0 else np.inf
    if additions and growth > EXPANDS:
        return SpreadReport(
            left, growth, "insufficient", "the distribution expands: the excitation does not hold it together"
        )
    if not additions and left > MUCH:
        return SpreadReport(
            left, growth, "insufficient", "the data narrowed the distribution by less than a tenth"
        )
    if not additions and left > LITTLE:
        return SpreadReport(left, growth, "weak", "the data narrowed the distribution by less than half")
    return SpreadReport(left, growth, "sufficient", "the distribution stays narrow")


def least_known(
    run: StateSpaceRun, coefficients: FloatArray, names: tuple[str, ...]
) -> tuple[float, FloatArray]:
    """How much of the first spread is left in the least known direction of some parameters, and that direction (k,).

    coefficients (n, S): at one time. The direction is in first standard deviations; 1 = nothing learned. A single
    parameter may look known when a combination of several is not.
    """
    rows = [run.names.index(name) for name in names]
    scaled = coefficients[rows, 1:] / run.start_std[rows, None]
    sizes, directions = np.linalg.eigh(scaled @ scaled.T)
    return float(np.sqrt(max(sizes[-1], 0.0))), np.asarray(directions[:, -1])


def block_inflation(run: StateSpaceRun, name: str, *, blocks: int = 16, start: float = 0.25) -> float:
    """By how much the filter's own deviation is too small, 1 or more: from how its estimate moves.

    Over a block of samples a right filter without additions moves its mean by a random amount whose variance is what its own
    variance lost there. The mean of the squared ratio over the blocks of the run after `start` (a share) is 1 then; residuals
    that hang together (friction, a wrong model) make it larger. A constant error of the model stays hidden.
    """
    i = run.names.index(name)
    edges = np.linspace(start * (run.done - 1), run.done - 1, blocks + 1).astype(int)
    mean, variance = run.mean[edges, i], run.std[edges, i] ** 2
    lost, moved = -np.diff(variance), np.diff(mean) ** 2
    good = lost > 1e-9 * variance[:-1]
    return float(np.sqrt(max(1.0, np.mean(moved[good] / lost[good])))) if good.any() else 1.0
