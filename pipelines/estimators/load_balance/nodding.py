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

GENTLE_MPS2, STEEP = 0.65, 6
"""Changes of speed by which half of the nod lies within what the springs' dry friction gives before it slides, and how sharply: with such of
0.35 and 0.55 m/s² in circles vans, cars and off-road vehicles nodded by 0.6 of what their springs let them, with 1.0 to 2.5 by 0.93 to 1.05."""

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


def _summed(column: FloatArray, prepared: Prepared) -> FloatArray:
    """(n,) a rate summed up within each segment."""
    out = np.full(len(column), np.nan)
    for s in prepared.segments:
        out[s.start : s.stop] = np.cumsum(column[s.start : s.stop]) / prepared.rate_hz
    return out


def _tip(prepared: Prepared) -> tuple[FloatArray, FloatArray | None] | None:
    """(n,) pitch against the horizon where it is logged, else what the gyro sums to, and then what of that is turning: yaw rate times lateral
    acceleration, summed up, which a body's roll a m/s² makes an angle (a leaning body's pitch gyro turns with the vehicle); noughts where nothing tells. None without either."""
    c = prepared.columns
    angle, gyro, yaw, aside = (c.get(name) for name in ("pitch", "pitch_rate", "yaw_rate", "accel_y"))
    if angle is not None and prepared.share_of(angle) > 0.9:
        return np.asarray(angle), None
    if gyro is None or prepared.share_of(gyro) <= 0.9:
        return None
    turning = np.zeros(len(gyro)) if yaw is None or aside is None else yaw * aside
    known = prepared.share_of(turning) > 0.9
    return _summed(gyro, prepared), _summed(turning, prepared) if known else np.zeros(len(gyro))


def _strength(pushed: FloatArray, weight: FloatArray) -> float:
    """How hard the drive changes its speed, m/s²: mean of what it changes it by, weighed by its square and the instruments'; 0 where it never does."""
    rows = np.isfinite(pushed) & np.isfinite(weight)
    square = (weight[rows] * pushed[rows]) ** 2
    whole = float(square.sum())
    return float(np.sqrt(square @ pushed[rows] ** 2 / whole)) if whole > 0 else 0.0


def nodding_columns(
    prepared: Prepared, found: Mapping[str, FloatArray], smooth: Smoother, speed: FloatArray
) -> dict[str, FloatArray]:
    """The balance's columns and instruments, on the thinned rows; empty where a signal is missing. speed: (n,) m/s."""
    felt, along = _tip(prepared), prepared.columns.get("accel_x")
    if felt is None or along is None or not {*QUICK, "v", "yaw", "on"} <= {*found}:
        return {}
    tip, turned = felt
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
    made["quick_turned"] = np.zeros(len(breaks)) if turned is None else quick(smooth(turned))
    weight = 1 / (1 + (found["v"] / SLOW_MPS) ** 2) / (1 + (found["yaw"] / STRAIGHT_RADPS) ** 2)
    pushed = made["quick_fx_brake"] + made["quick_fx_drive"]
    gentle = 0.0 if turned is None else 1 / (1 + (_strength(pushed, weight) / GENTLE_MPS2) ** STEEP)
    made |= {f"stuck_{mode}": gentle * made[f"quick_fx_{mode}"] for mode in ("brake", "drive")}
    slope = found["vdot"]
    shapes = {
        "slope_on": slope * found["on"], "slope_off": slope * (1 - found["on"]), "slope_square": slope * np.abs(slope),
        "slope_sign": np.tanh(2 * slope), "jerk": np.gradient(slope) * rate, "jolt": np.gradient(np.gradient(slope)) * rate**2,
    }  # fmt: skip
    return made | {name: quick(shape) * weight for name, shape in shapes.items()}
