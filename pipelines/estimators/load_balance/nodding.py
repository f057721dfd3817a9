"""The columns of the pitch balance by the horizon: quick changes alone, of the pitch angle and of what makes it."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from pipelines.estimators.load_balance.smoothing import (
    LONG_MEMORY_M,
    SIDE_MEMORY_M,
    STICK_HZ,
    Smoother,
    friction_state,
    held_by_tyres,
)
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray

QUICK = (
    "fx_brake", "fx_drive", "dip_brake", "dip_drive", "dfx", "vdot", "v2", "v2_on", "on_rolling", "pitch_acc",
)  # fmt: skip
"""Columns of `data` that the balance holds high-passed."""

BY_SHAFTS = ("drive_on", "held_on", "held_fx")
"""And those of these that are there: what shafts do while the brakes are on, by their torque or by what is usual."""

SLOWEST_HZ = 0.1
"""What changes slower is grade, offset and drift."""

SLOW_MPS, STRAIGHT_RADPS = 8.0, 0.08
"""Speed and yaw rate from which an instrument counts less: more road passes, and the pitch gyro sees banked turning."""

STICK_RAD, YIELD_RAD = 0.0006, 0.0032
"""Pitch within which the axles' dry friction turns round: `STICK_M` and `YIELD_M` at each."""


def _quick(column: FloatArray, rate_hz: float, breaks: FloatArray) -> FloatArray:
    """High-passed stretch by stretch, zero phase; rows that are missing stay so."""
    out = np.full(len(column), np.nan)
    edges = np.flatnonzero(np.diff(breaks, prepend=np.nan, append=np.nan) != 0)
    for start, stop in pairwise(edges):
        part = column[start:stop]
        if np.isfinite(part).all() and stop - start > rate_hz / SLOWEST_HZ:
            out[start:stop] = part - lowpass(part, rate_hz, SLOWEST_HZ)
    return out


def _rolls(prepared: Prepared) -> FloatArray:
    """(n,) 1 while the wheels roll, 0 at rest: tyres that stand resist nothing."""
    still = prepared.standstill
    return np.ones(len(prepared.time_s)) if len(still) == 0 else np.asarray(~still, dtype=np.float64)


def _tip(prepared: Prepared) -> FloatArray | None:
    """(n,) pitch against the horizon where it is logged, else what the gyro sums to; None without either."""
    c = prepared.columns
    angle, gyro = c.get("pitch"), c.get("pitch_rate")
    if angle is not None and prepared.share_of(angle) > 0.9:
        return np.asarray(angle)
    if gyro is None or prepared.share_of(gyro) <= 0.9:
        return None
    out = np.full(len(gyro), np.nan)
    for s in prepared.segments:
        out[s.start : s.stop] = np.cumsum(gyro[s.start : s.stop]) / prepared.rate_hz
    return out


def nodding_columns(
    prepared: Prepared, found: Mapping[str, FloatArray], smooth: Smoother, speed: FloatArray
) -> dict[str, FloatArray]:
    """The balance's columns and instruments, on the thinned rows; empty where a signal is missing. speed: (n,) m/s."""
    tip, along = _tip(prepared), prepared.columns.get("accel_x")
    if tip is None or along is None or not {*QUICK, "v", "yaw", "on"} <= {*found}:
        return {}
    rate = prepared.rate_hz / smooth.step
    segment = np.full(len(prepared.time_s), -1.0)
    for i, s in enumerate(prepared.segments):
        segment[s.start : s.stop] = i
    breaks = segment[smooth.rows]

    def quick(column: FloatArray) -> FloatArray:
        return _quick(column, rate, breaks)

    calm = Smoother(prepared, STICK_HZ)
    nodded = calm.whole(tip)
    made = {"tip": quick(smooth(tip)), "dtip": quick(smooth(tip, 1))}
    for name, limit in (("tip_stick", STICK_RAD), ("tip_yield", YIELD_RAD)):
        made[name] = quick(smooth(friction_state(nodded, prepared, limit)))
    for name in (*QUICK, *(n for n in BY_SHAFTS if n in found)):
        made[f"quick_{name}"] = quick(found[name])
    made["quick_scrub"] = quick(smooth(held_by_tyres(nodded, prepared, speed, SIDE_MEMORY_M)))
    made["quick_held"] = quick(smooth(held_by_tyres(calm.whole(along), prepared, speed, LONG_MEMORY_M)))
    made["quick_rolls"] = quick(smooth(_rolls(prepared)))
    made["quick_fz"] = quick(found["fz"]) if "fz" in found else np.zeros(len(breaks))
    weight = 1 / (1 + (found["v"] / SLOW_MPS) ** 2) / (1 + (found["yaw"] / STRAIGHT_RADPS) ** 2)
    slope = found["vdot"]
    shapes = {
        "slope_on": slope * found["on"], "slope_off": slope * (1 - found["on"]), "slope_square": slope * np.abs(slope),
        "slope_sign": np.tanh(2 * slope), "jerk": np.gradient(slope) * rate, "jolt": np.gradient(np.gradient(slope)) * rate**2,
    }  # fmt: skip
    return made | {name: quick(shape) * weight for name, shape in shapes.items()}
