"""The road under the vehicle as the log shows it: its slope, and the force that presses on it over crests and dips."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipelines.models.axle_load import GRAVITY
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import BoolArray, Prepared, Segment
from pipelines.results import FloatArray

SLOW_GRADE_HZ = 0.1
CREST_HZ = 0.5
CORRELATION_S = 1.0
MOST_LEAK = 0.02
LEAST_THERE = 0.9
ALTITUDE_HZ = 0.05
STILL = "g cos(grade)"
GRADE_ERROR = {"road_grade": 0.003, "altitude": 0.008, "accelerometer": 0.01, "flat": 0.01}
"""rad, standard deviation of a constant error of the road's slope, by where it is from. STILL: in words, a force normal to the road that
nothing shows to change over crests."""


def without_small_holes(prepared: Prepared) -> Prepared:
    """Optional columns that are there for nine tenths of the segments, interpolated over the rest.

    A slope or a speed that comes at 20 Hz ends a few rows before the load does: that must not cost the whole column.
    """
    inside = np.zeros(len(prepared.time_s), dtype=bool)
    for segment in prepared.segments:
        inside[segment.start : segment.stop] = True
    rows = np.arange(len(inside))
    columns: dict[str, FloatArray] = {}
    for name, column in prepared.columns.items():
        there = np.isfinite(column)
        whole = there[inside].all()
        if not whole and inside.any() and float(np.mean(there[inside])) >= LEAST_THERE:
            column = np.interp(rows, rows[there], column[there])
        columns[name] = column
    return replace(prepared, columns=columns)


def by_segment(values: FloatArray, segments: tuple[Segment, ...], change: object) -> FloatArray:
    """`change` applied to each segment; NaN elsewhere and where a segment has holes."""
    out = np.full(len(values), np.nan)
    for segment in segments:
        rows = slice(segment.start, segment.stop)
        if np.isfinite(values[rows]).all():
            out[rows] = change(values[rows])  # type: ignore[operator]
    return out


@dataclass(frozen=True)
class Grade:
    """Slope of the road in rad (n,), how it was found in words, and the standard deviation of its constant error."""

    angle: FloatArray
    how: str
    std: float
    kind: str


def road_grade(prepared: Prepared, speed: FloatArray | None, accel: FloatArray | None) -> Grade:
    """The best slope: measured; from the accelerometer less dv/dt; from altitude; else flat, and said so."""
    columns, segments, rate = prepared.columns, prepared.segments, prepared.rate_hz
    measured = columns.get("road_grade")
    inside = np.zeros(len(prepared.time_s), dtype=bool)
    for segment in segments:
        inside[segment.start : segment.stop] = True
    if measured is not None and np.isfinite(measured[inside]).all() and inside.any():
        return Grade(measured, "measured: road_grade", GRADE_ERROR["road_grade"], "road_grade")
    if speed is not None and accel is not None:

        def slow(v: FloatArray) -> FloatArray:
            return lowpass(v, rate, SLOW_GRADE_HZ)

        tilt = by_segment(
            accel - by_segment(speed, segments, lambda v: np.gradient(v) * rate), segments, slow
        )
        if np.isfinite(tilt[inside]).all() and inside.any():
            angle = np.arcsin(np.clip(np.nan_to_num(tilt) / GRAVITY, -0.5, 0.5))
            words = f"derived: accel_x less dv/dt below {SLOW_GRADE_HZ:g} Hz"
            return Grade(angle, words, GRADE_ERROR["accelerometer"], "accelerometer")
    altitude = columns.get("altitude")
    if altitude is not None and speed is not None:

        def climb(v: FloatArray) -> FloatArray:
            return np.gradient(lowpass(v, rate, ALTITUDE_HZ)) * rate

        rise, along = (
            by_segment(altitude, segments, climb),
            by_segment(speed, segments, lambda v: lowpass(v, rate, ALTITUDE_HZ)),
        )
        if np.isfinite(rise[inside]).all() and inside.any():
            ratio = np.where(along > 2.0, rise / np.maximum(along, 2.0), 0.0)
            angle = np.arcsin(np.clip(np.nan_to_num(ratio), -0.4, 0.4))
            words = f"derived: altitude over distance below {ALTITUDE_HZ:g} Hz"
            return Grade(angle, words, GRADE_ERROR["altitude"], "altitude")
    return Grade(np.zeros(len(prepared.time_s)), "assumed: a flat road", GRADE_ERROR["flat"], "flat")


@dataclass(frozen=True)
class Vertical:
    """Specific force normal to the road in m/s² (n,), how it was found, and by how much of the force along the road it
    may be wrong (standard deviation of that share)."""

    force: FloatArray
    how: str
    leak_std: float


def vertical_force(
    prepared: Prepared,
    speed: FloatArray | None,
    accel: FloatArray | None,
    grade: Grade,
    good: BoolArray,
    loads: tuple[FloatArray, FloatArray] | None,
) -> Vertical:
    """Crests and dips change the force normal to the road by several per cent, which would read as load transfer.

    From the sum of both axle loads where both are there. From the rate of a measured grade: g cos(grade) + v times that rate. Else from accel_z, with its offset taken off (in
    the mean of a drive the force is g) and what goes with accel_x as well: an accelerometer mounted askew by a degree
    would turn the height by 2-3 %. Else g cos(grade).
    """
    still = np.asarray(GRAVITY * np.cos(grade.angle))
    if loads is not None and good.any():
        total = loads[0] + loads[1]
        return Vertical(
            total * float(np.mean(still[good]) / np.mean(total[good])), "sum of both axle loads", 0.0
        )
    if grade.kind == "road_grade" and speed is not None:

        def rate(v: FloatArray) -> FloatArray:
            slow = lowpass(v, prepared.rate_hz, min(CREST_HZ, 0.4 * prepared.rate_hz))
            return np.asarray(np.gradient(slow) * prepared.rate_hz)

        bend = by_segment(grade.angle, prepared.segments, rate)
        return Vertical(still + np.nan_to_num(bend * speed), "g cos(grade) and the grade's change", 0.0)
    up = prepared.columns.get("accel_z")
    if up is None or accel is None or not good.any() or not np.isfinite(up[good]).all():
        return Vertical(still, STILL, 0.0)
    moved, along = up[good] - np.mean(up[good]), accel[good] - np.mean(accel[good])
    power = max(float(along @ along), 1e-9)
    share = float(along @ moved) / power
    left = moved - share * along
    apart = 2 * CORRELATION_S * prepared.rate_hz
    leak = math.sqrt(float(left @ left) / len(left) * apart / power)
    force = still + up - np.mean(up[good]) - share * (accel - np.mean(accel[good]))
    return Vertical(
        force, "accel_z without its offset and without what goes with accel_x", min(leak, MOST_LEAK)
    )


def pitch_acceleration(prepared: Prepared) -> FloatArray | None:
    """The body's pitch acceleration from a gyro, rad/s² (n,); None without one."""
    rate = prepared.columns.get("pitch_rate")
    if rate is None:
        return None
    return by_segment(rate, prepared.segments, lambda v: np.gradient(v) * prepared.rate_hz)
