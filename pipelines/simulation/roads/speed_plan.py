"""From limits along a road to a driver's speed over time: forward and backward passes, waits, and a smooth foot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.jit import kernel
from pipelines.results import FloatArray
from pipelines.simulation.roads.profile import smoothed

_AIR = 1.2


@dataclass(frozen=True)
class Limits:
    """What bounds the speed at even steps of step_m. All shape (m,).

    speed_mps: 0 where the vehicle stops; accel_mps2, decel_mps2: the driver's, both positive; grade_rad: + uphill;
    wait_s: standstill, read where speed_mps is 0.
    """

    step_m: float
    speed_mps: FloatArray
    accel_mps2: FloatArray
    decel_mps2: FloatArray
    grade_rad: FloatArray
    wait_s: FloatArray


@dataclass(frozen=True)
class Power:
    """What the vehicle can do: usable power, grip of the driven wheels and drag a mass; rolling resistance a weight."""

    power_per_mass_wpkg: float
    traction_mps2: float
    drag_area_per_mass_m2pkg: float
    rolling_resistance: float


@kernel
def _fastest(
    step: float, limit: FloatArray, accel: FloatArray, decel: FloatArray, grade: FloatArray, p: FloatArray
) -> FloatArray:
    """Highest speeds that keep every limit: forward with accel and power, then backward with decel.

    p: power per mass, 0.5 rho c_d A per mass, rolling resistance, traction per mass. Each step is of even acceleration.
    """
    n = len(limit)
    v = np.empty(n)
    v[0] = limit[0]
    for i in range(n - 1):
        resist = 9.80665 * (p[2] + np.sin(grade[i])) + p[1] * v[i] * v[i]
        most = min(accel[i], min(p[0] / max(v[i], 2.0), p[3]) - resist)
        # too steep for the power: slower and slower, but never stuck
        v[i + 1] = min(limit[i + 1], np.sqrt(max(v[i] * v[i] + 2 * most * step, 0.25)))
    for i in range(n - 2, -1, -1):
        v[i] = min(v[i], np.sqrt(v[i + 1] * v[i + 1] + 2 * decel[i] * step))
    return v


def fastest(limits: Limits, power: Power) -> FloatArray:
    """Highest speed (m,) at each place that keeps all limits. No stop may follow the step right after another."""
    figures = np.array(
        [
            power.power_per_mass_wpkg,
            0.5 * _AIR * power.drag_area_per_mass_m2pkg,
            power.rolling_resistance,
            power.traction_mps2,
        ]
    )
    return _fastest(
        limits.step_m, limits.speed_mps, limits.accel_mps2, limits.decel_mps2, limits.grade_rad, figures
    )


def arrival_times(speed_mps: FloatArray, step_m: float) -> FloatArray:
    """Time (m,) at which each place is reached, without waits, from speeds along the road (even acceleration a step)."""
    mean = 0.5 * (speed_mps[1:] + speed_mps[:-1])
    return np.concatenate(([0.0], np.cumsum(step_m / np.maximum(mean, 1e-3))))


def over_time(
    speed_mps: FloatArray, limits: Limits, step_s: float, smooth_s: float
) -> FloatArray:  # fmt: skip
    """Speeds over time, (n,) at even steps: waits put in, then smoothed by a raised cosine of full width smooth_s.

    Smoothing bounds the jerk (a change of acceleration da takes smooth_s: at most 2 da / smooth_s) and keeps the
    distance. A wait should be longer than smooth_s, else the vehicle does not come to rest.
    """
    stops = limits.speed_mps <= 0
    waits = np.where(stops, limits.wait_s, 0.0)
    arrive = arrival_times(speed_mps, limits.step_m) + np.concatenate(([0.0], np.cumsum(waits)[:-1]))
    leave = arrive + waits
    # both the arrival and the departure of every stop are corners of v(t)
    order: NDArray[np.intp] = np.sort(np.concatenate((np.arange(len(arrive)), np.flatnonzero(stops))))
    second = np.concatenate(([False], order[1:] == order[:-1]))
    corners = np.where(second, leave[order], arrive[order])
    t = step_s * np.arange(int(corners[-1] / step_s) + 1)
    exact = np.interp(t, corners, speed_mps[order])
    return np.maximum(smoothed(np.asarray(exact), step_s, smooth_s), 0.0)


def slowest_near(values: FloatArray, step_m: float, reach_m: float) -> FloatArray:
    """Least value within reach_m of each place, (m,): a bend's limit begins before it and ends behind it."""
    half = round(reach_m / step_m)
    near = np.lib.stride_tricks.sliding_window_view(np.pad(values, half, mode="edge"), 2 * half + 1)
    return np.asarray(near.min(axis=1), dtype=np.float64)
