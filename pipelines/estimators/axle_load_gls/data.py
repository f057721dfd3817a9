"""From a prepared drive to the balance of axle loads: which load, which force along the road, which grade."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.axle_load_gls.road import (
    Grade,
    pitch_acceleration,
    road_grade,
    vertical_force,
    without_small_holes,
)
from pipelines.models.axle_load import GRAVITY, mean_error
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Quantity, Vehicle

AXLES: dict[str, tuple[str, str]] = {"front": ("fl", "fr"), "rear": ("rl", "rr")}
SHORTEST_RUN_S = 2.0
MOVING_MPS = 0.5
SPEEDS: tuple[str, ...] = ("speed", "gps_speed_3d", "gps_speed_2d")
WHEEL_PAIRS: tuple[tuple[str, str], ...] = (
    ("wheel_speed_fl", "wheel_speed_fr"),
    ("wheel_speed_rl", "wheel_speed_rr"),
)


def load_channels(signals: Collection[str], axle: str) -> tuple[str, ...]:
    """The signals that give this axle's load: one axle sensor, else both tyre forces, else both suspension forces."""
    if f"axle_load_{axle}" in signals:
        return (f"axle_load_{axle}",)
    for kind in ("tire_normal_force", "suspension_force"):
        pair = tuple(f"{kind}_{wheel}" for wheel in AXLES[axle])
        if all(name in signals for name in pair):
            return pair
    return ()


def speed_channels(signals: Collection[str], vehicle: Vehicle | None = None) -> tuple[str, ...]:
    """The signals that give the speed, best first; wheels of one axle (the undriven one where that is known)."""
    for name in SPEEDS:
        if name in signals:
            return (name,)
    share = None if vehicle is None else vehicle.get("drive_front_share")
    pairs = WHEEL_PAIRS if share is None or share.value < 0.5 else WHEEL_PAIRS[::-1]
    for pair in pairs:
        if all(name in signals for name in pair):
            return pair
    return ()


def kind_of(columns: Mapping[str, FloatArray], axle: str) -> str | None:
    """Which sensors give this axle's load: "axle", "tyre", "suspension"; None without."""
    names = load_channels(columns, axle)
    return names[0].split("_")[0].replace("tire", "tyre") if names else None


def axle_load(
    columns: Mapping[str, FloatArray], axle: str, vehicle: Vehicle
) -> tuple[FloatArray, float, str, float] | None:
    """Load of an axle in N (n,), the standard deviation of what was added to it, how it was made, and what was added in N;
    None without a sensor."""
    names = load_channels(columns, axle)
    if not names:
        return None
    total = np.sum([columns[name] for name in names], axis=0)
    if not names[0].startswith("suspension_force"):
        return total, 0.0, " + ".join(names), 0.0
    unsprung = vehicle.get(f"unsprung_mass_{axle}_kg")
    if unsprung is None:
        mass = vehicle.get("mass_kg")
        heavy = 1500.0 if mass is None else mass.value
        unsprung = Quantity(*usual_unsprung(vehicle, axle, heavy), "usual share of the mass")
    words = f"{' + '.join(names)} + unsprung weight ({unsprung.value:.0f} kg, {unsprung.source})"
    weight = unsprung.value * GRAVITY
    return total + weight, unsprung.std * GRAVITY, words, weight


def speed_of(columns: Mapping[str, FloatArray], vehicle: Vehicle) -> tuple[FloatArray, str] | None:
    """Speed in m/s (n,) and what it is from; None without."""
    names = speed_channels([n for n, c in columns.items() if np.isfinite(c).any()], vehicle)
    if not names:
        return None
    return np.asarray(np.mean([columns[name] for name in names], axis=0)), " and ".join(names)


@dataclass(frozen=True)
class AxleData:
    """Rows that meet the gates, cut into runs. All arrays (n,) unless said.

    load: share_rear F_r - share_front F_f in N. front, rear: mean loads in N over the rows, None where not measured.
    added_std: standard deviation in N of what was added to the sensors (unsprung weight).
    accel: accelerometer in m/s², or None. vertical: specific force normal to the road in m/s². pitch_accel: of the
    body in rad/s², + nose down, or None. speed, or None. grade: see Grade. starts: 1 where a run begins.
    drive_rows: how many rows the drive had. kinds: sensors of the front and the rear axle's load ("axle", "tyre",
    "suspension"), None where there are none; added: weight in N that was put to them. total_std: of the mean sum of both, N.
    """

    time_s: FloatArray
    rate_hz: float
    load: FloatArray
    share_front: float
    share_rear: float
    front: float | None
    rear: float | None
    added_std: float
    accel: FloatArray | None
    speed: FloatArray | None
    vertical: FloatArray
    vertical_words: str
    vertical_leak: float
    pitch_accel: FloatArray | None
    grade: FloatArray
    starts: FloatArray
    grade_source: Grade
    load_words: str
    speed_words: str
    drive_rows: int
    rows: np.ndarray
    kinds: tuple[str | None, str | None] = (None, None)
    added: tuple[float, float] = (0.0, 0.0)
    total_std: float = 0.0

    def share_of(self, kind: str) -> float:
        """How much of `load` such sensors give, 0 to 1."""
        parts = zip(self.kinds, (self.share_front, self.share_rear), strict=True)
        return sum(share for own, share in parts if own == kind)

    @property
    def size(self) -> int:
        """Rows."""
        return len(self.time_s)

    @property
    def dt(self) -> float:
        """Step in s."""
        return 1.0 / self.rate_hz

    def force(self) -> FloatArray:
        """Specific force along the road as the accelerometer gives it, else dv/dt + g sin(grade); m/s²."""
        if self.accel is not None:
            return self.accel
        assert self.speed is not None
        return np.asarray(self.speed_rate() + GRAVITY * np.sin(self.grade))

    def speed_rate(self) -> FloatArray:
        """dv/dt in m/s², zero-phase, run by run."""
        assert self.speed is not None
        out = np.zeros(self.size)
        for first, past in self.runs():
            if past - first > 3:
                # a derivative of noisy speed: only what is slow is of use
                smooth = lowpass(self.speed[first:past], self.rate_hz, min(1.0, 0.2 * self.rate_hz))
                out[first:past] = np.gradient(smooth) * self.rate_hz
        return out

    def runs(self) -> list[tuple[int, int]]:
        """(first, past the last) row of each run."""
        begin = np.flatnonzero(self.starts > 0.5)
        return [(int(i), int(j)) for i, j in zip(begin, [*begin[1:], self.size], strict=True)]


def _usable(
    prepared: Prepared, speed: FloatArray | None, needs_motion: bool, most_lateral: float
) -> BoolArray:
    """Rows inside segments, driving fairly straight, and moving where the speed's change is what is looked at."""
    good = np.zeros(len(prepared.time_s), dtype=bool)
    for segment in prepared.segments:
        good[segment.start : segment.stop] = True
    lateral = prepared.columns.get("accel_y")
    if lateral is None and speed is not None and "yaw_rate" in prepared.columns:
        lateral = speed * prepared.columns["yaw_rate"]
    if lateral is not None:
        good &= ~(np.abs(np.nan_to_num(lateral)) > most_lateral)
    if needs_motion and speed is not None:
        good &= np.nan_to_num(speed) > MOVING_MPS
    return good


def collect(
    prepared: Prepared, vehicle: Vehicle, *, by_speed: bool, most_lateral: float, one_axle: bool = False
) -> AxleData | None:
    """The balance's columns; None where nothing usable is left.

    by_speed: the form that integrates (needs a speed). one_axle: rear only where both are there (the published form).
    """
    prepared = without_small_holes(prepared)
    columns = prepared.columns
    front, rear = axle_load(columns, "front", vehicle), axle_load(columns, "rear", vehicle)
    if one_axle and rear is not None:
        front = None
    found = speed_of(columns, vehicle)
    speed = None if found is None else found[0]
    accel = columns.get("accel_x")
    if (front is None and rear is None) or (by_speed and speed is None) or (not by_speed and accel is None):
        return None
    grade = road_grade(prepared, speed, accel)
    good = _usable(prepared, speed, by_speed, most_lateral)
    spans = [(i, j) for i, j in runs(good) if j - i >= SHORTEST_RUN_S * prepared.rate_hz]
    if not spans:
        return None
    rows = np.concatenate([np.arange(i, j) for i, j in spans])
    loads = (front[0], rear[0]) if front is not None and rear is not None else None
    vertical = vertical_force(prepared, speed, accel, grade, good, loads)
    turning = pitch_acceleration(prepared)
    starts = np.zeros(len(rows))
    starts[np.concatenate(([0], np.cumsum([j - i for i, j in spans])[:-1]))] = 1.0
    share_front = 0.0 if front is None else (1.0 if rear is None else 0.5)
    parts = [p for p in (front, rear) if p is not None]
    load = np.zeros(len(rows))
    for part, share in ((front, -share_front), (rear, 1 - share_front)):
        load += 0.0 if part is None else share * part[0][rows]
    return AxleData(
        time_s=prepared.time_s[rows],
        rate_hz=prepared.rate_hz,
        load=load,
        share_front=share_front,
        share_rear=1 - share_front,
        front=None if front is None else float(np.mean(front[0][rows])),
        rear=None if rear is None else float(np.mean(rear[0][rows])),
        added_std=math.hypot(*(p[1] for p in parts)),
        accel=None if by_speed or accel is None else accel[rows],
        speed=None if speed is None else np.nan_to_num(speed[rows]),
        vertical=vertical.force[rows],
        vertical_words=vertical.how,
        vertical_leak=vertical.leak_std,
        pitch_accel=None if turning is None or not np.isfinite(turning[rows]).all() else turning[rows],
        grade=grade.angle[rows] if grade.kind in ("road_grade",) or by_speed else np.zeros(len(rows)),
        starts=starts,
        grade_source=grade,
        load_words="; ".join(p[2] for p in parts),
        speed_words="" if found is None else found[1],
        drive_rows=len(prepared.time_s),
        rows=rows,
        kinds=(kind_of(columns, "front") if front else None, kind_of(columns, "rear") if rear else None),
        added=(front[3] if front else 0.0, rear[3] if rear else 0.0),
        total_std=0.0 if loads is None else mean_error((loads[0] + loads[1])[rows], prepared.rate_hz),
    )
