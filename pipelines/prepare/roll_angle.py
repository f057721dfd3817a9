"""The body's roll angle from what is there: measured, from suspension deflections, or from gyro and gravity.

Ranked in that order, and recorded: what was used says how it was made. Roll from deflections is the body against
its axles (it leaves out what the tyres give); a measured angle and a gyro's see the body against the horizon.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

Reference = Literal["horizon", "axles"]
BLEND_HZ = 0.05
"""Below this frequency gravity says where down is, above it the gyro."""

AGAINST_AXLES = "body against axles"
TYPICAL_TRACK = (1.55, 0.08)
"""m, mean and standard deviation over cars, where the vehicle file gives no track."""


@dataclass(frozen=True)
class RollSource:
    """One way to a roll angle. angle: (n,) rad on the prepared grid. scale_std: relative error of its scale."""

    kind: Literal["measured", "deflections", "gyro_gravity"]
    angle: FloatArray
    against: Reference
    how: str
    scale_std: float


def _track(vehicle: Vehicle, axle: str) -> tuple[float, float, str]:
    other = "rear" if axle == "front" else "front"
    for key in (f"track_{axle}_m", f"track_{other}_m"):
        known = vehicle.get(key)
        if known is not None:
            return known.value, known.std, f"{key} {known.value:g} m"
    return *TYPICAL_TRACK, f"track taken as {TYPICAL_TRACK[0]:g} m"


def from_deflections(columns: Mapping[str, FloatArray], vehicle: Vehicle) -> RollSource | None:
    """(right - left compression) / track, the mean of the axles that have both sensors; None without a pair."""
    angles: list[FloatArray] = []
    words: list[str] = []
    relative: list[float] = []
    for axle, letter in (("front", "f"), ("rear", "r")):
        left = columns.get(f"suspension_deflection_{letter}l")
        right = columns.get(f"suspension_deflection_{letter}r")
        if left is None or right is None:
            continue
        track, std, text = _track(vehicle, axle)
        angles.append((right - left) / track)
        relative.append(std / track)
        words.append(f"{axle}: {text}")
    if not angles:
        return None
    how = f"derived: suspension deflections ({', '.join(words)}), {AGAINST_AXLES}"
    return RollSource("deflections", np.mean(angles, axis=0), "axles", how, float(np.mean(relative)))


def from_gyro_and_gravity(prepared: Prepared, columns: Mapping[str, FloatArray]) -> RollSource | None:
    """Integrated roll rate, held to gravity below 0.05 Hz: f_y = v yaw_rate + g roll, both ways in time.

    Without speed and yaw rate only the fast part is there (a steady corner then shows no roll).
    """
    rate = columns.get("roll_rate")
    if rate is None:
        return None
    accel, speed, yaw = columns.get("accel_y"), columns.get("speed"), columns.get("yaw_rate")
    offset = prepared.standstill_offset.get("roll_rate", (None, 0.0))[0]
    angle = np.full(len(rate), np.nan)
    for segment in prepared.segments:
        rows = slice(segment.start, segment.stop)
        gyro = rate[rows] - (float(np.median(rate[rows])) if offset is None else offset)
        if not np.isfinite(gyro).all():
            continue
        turned = np.cumsum(gyro) / prepared.rate_hz
        turned -= 0.5 * gyro / prepared.rate_hz
        fast = turned - lowpass(turned, prepared.rate_hz, BLEND_HZ)
        slow = np.zeros(len(fast))
        if accel is not None and speed is not None and yaw is not None:
            tilt = (accel[rows] - speed[rows] * yaw[rows]) / GRAVITY
            if np.isfinite(tilt).all():
                slow = lowpass(tilt, prepared.rate_hz, BLEND_HZ)
        angle[rows] = fast + slow
    words = "with gravity below" if speed is not None and yaw is not None else "without speed, so only above"
    how = f"derived: integrated roll rate, {words} {BLEND_HZ:g} Hz"
    return RollSource("gyro_gravity", angle, "horizon", how, 0.01)


def rank_roll(prepared: Prepared, vehicle: Vehicle) -> tuple[RollSource, ...]:
    """All roll angles that this drive allows, the best first."""
    found: list[RollSource] = []
    columns = prepared.columns
    if "roll" in columns and np.isfinite(columns["roll"]).any():
        how = prepared.sources.get("roll", "measured")
        found.append(RollSource("measured", columns["roll"], "horizon", how, 0.003))
    for source in (from_deflections(columns, vehicle), from_gyro_and_gravity(prepared, columns)):
        if source is not None and np.isfinite(source.angle).any():
            found.append(source)
    return tuple(found)


def with_roll(prepared: Prepared, vehicle: Vehicle) -> tuple[Prepared, RollSource | None]:
    """The prepared drive with the best roll angle as its column "roll", and its source; None where there is none."""
    ranked = rank_roll(prepared, vehicle)
    if not ranked:
        return prepared, None
    best = ranked[0]
    others = [source.how for source in ranked[1:]]
    notes = prepared.notes
    if others:
        notes = (*notes, f"roll angle: {best.how}; ranked below it: {'; '.join(others)}")
    columns = {**prepared.columns, "roll": best.angle}
    sources = {**prepared.sources, "roll": best.how}
    measured = prepared.measured if best.kind == "measured" else prepared.measured - {"roll"}
    return replace(prepared, columns=columns, sources=sources, measured=measured, notes=notes), best
