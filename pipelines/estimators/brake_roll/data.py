"""A prepared drive as the braking and roll estimators need it: torques by axle, wheel speeds by axle, a true speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEEL_SPEEDS, WHEELS
from pipelines.estimators.brake_roll.rows import window_mean
from pipelines.estimators.brake_roll.speed import (
    STIFFEST,
    TrueSpeed,
    choose_speed,
    fill,
    slip_slope,
)
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle
from pipelines.models.braking import drag
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.prepare.signals import prepare_signals
from pipelines.prepare.spans import usual_period_s
from pipelines.results import FloatArray

MOTION = ("accel_x", "accel_y", "roll_rate", "yaw_rate")
OPTIONAL = (
    "speed", "gps_speed_2d", "gps_speed_3d", "satellites", "hdop", "steering_wheel_angle", "brake_pressure",
    "brake_torque", "drive_torque", "road_grade", "roll",
    *(f"brake_torque_{w}" for w in WHEELS), *(f"drive_torque_{w}" for w in WHEELS),
)  # fmt: skip
SLOWEST_HZ = 5.0
"""A signal that comes more slowly does not bind the filter of all: it is taken where it is, without its quick part."""

FEWEST_SATELLITES, WORST_HDOP = 4, 5.0
STEEPEST_RAD = 0.03


def prepare_drive(drive: Drive, rate_hz: float, cutoff_hz: float) -> Prepared:
    """Motion and wheel speeds on one clock, low-passed alike; all else where it is there."""
    wanted: list[str] = []
    for name in (*MOTION, *WHEEL_SPEEDS):
        signal = drive.signals.get(name)
        if signal is None or len(signal.time_ns) < 2:
            continue
        period = usual_period_s(signal.time_ns)
        if 0 < period <= 1 / SLOWEST_HZ:
            wanted.append(name)
    optional = [*OPTIONAL, *(n for n in (*MOTION, *WHEEL_SPEEDS) if n not in wanted)]
    return prepare_signals(drive, wanted, rate_hz=rate_hz, cutoff_hz=cutoff_hz, optional=optional)


@dataclass(frozen=True)
class BrakeRollData:
    """Columns (n,) SI without NaN inside `rows`; what is missing is None, and `missing` says why in words.

    front, rear: mean wheel speeds of the axles; rolling: mean of the axles whose wheels are both there; apart: left-right difference less the turn's. front_torque,
    rear_torque: brake torque of both wheels (share_known: False where one figure was split by the brake_front_share; by_pressure: from brake pressure and gain).
    drive: drive torque of all wheels. rows: inside segments. allowed: flat road, good satellites.
    """

    rate_hz: float
    time_s: FloatArray
    rows: BoolArray
    true: TrueSpeed | None
    f_x: FloatArray | None
    f_y: FloatArray | None
    roll_rate: FloatArray | None
    yaw_rate: FloatArray | None
    front: FloatArray | None
    rear: FloatArray | None
    rolling: FloatArray | None
    apart: FloatArray
    front_torque: FloatArray | None
    rear_torque: FloatArray | None
    share_known: bool
    by_pressure: bool
    drive: FloatArray | None
    steering: FloatArray | None
    roll: FloatArray | None
    allowed: BoolArray
    missing: tuple[str, ...]
    notes: tuple[str, ...]


def inside(prepared: Prepared) -> BoolArray:
    """Rows inside segments."""
    mask = np.zeros(len(prepared.time_s), dtype=bool)
    for segment in prepared.segments:
        mask[segment.start : segment.stop] = True
    return mask


def _column(prepared: Prepared, name: str, *, offset: bool = False) -> FloatArray | None:
    """A column without NaN, less its standstill offset where asked for; None where it is hardly there."""
    values = prepared.columns.get(name)
    if values is None or prepared.share_of(values) < 0.5:
        return None
    known = prepared.standstill_offset.get(name)
    return fill(values) - (known[0] if offset and known is not None else 0.0)


def _sum(prepared: Prepared, names: Sequence[str]) -> FloatArray | None:
    parts = [_column(prepared, name) for name in names]
    if any(part is None for part in parts):
        return None
    return np.asarray(sum(part for part in parts if part is not None))


IDLE_MPS2 = 0.08
"""Braking below which the foot is off: noise of the sensor."""


def _pressed(values: FloatArray) -> FloatArray:
    """The column, positive when the brakes are on, without its zero error: what is there with the foot off.

    The foot is off for a fifth of a drive or more; a column that is never near zero then is left as it is.
    """
    signed = (
        values if abs(float(np.quantile(values, 0.98))) >= abs(float(np.quantile(values, 0.02))) else -values
    )
    rest = float(np.quantile(signed, 0.2))
    top = float(np.quantile(signed, 0.995))
    return np.asarray(np.maximum(signed - (rest if abs(rest) < 0.05 * top else 0.0), 0.0))


def _brakes(
    prepared: Prepared, known: BrakeRollVehicle, missing: list[str]
) -> tuple[FloatArray | None, FloatArray | None, bool]:
    """Brake torque of the front and of the rear axle; measured by wheel, or one figure split by the front share."""
    front = _sum(prepared, ("brake_torque_fl", "brake_torque_fr"))
    rear = _sum(prepared, ("brake_torque_rl", "brake_torque_rr"))
    still = IDLE_MPS2 * known.mass.value * known.radius.value
    if front is not None and rear is not None:
        ahead, behind = _pressed(front), _pressed(rear)
        on = ahead + behind > still
        return np.where(on, ahead, 0.0), np.where(on, behind, 0.0), True
    total = _column(prepared, "brake_torque")
    if total is not None:
        total = _pressed(total)
        total = np.where(total > still, total, 0.0)
    else:
        pressure = _column(prepared, "brake_pressure")
        if pressure is None:
            missing.append("no brake pressure or brake torque")
            return None, None, False
        if known.gain is None:
            missing.append("the brake gain is not known: give brake_gain_nmppa and brake_front_share")
            return None, None, False
        total = _pressed(pressure) * known.gain.value
        total = np.where(total > still, total, 0.0)
    share = known.brake_front.value
    return np.asarray(share * total), np.asarray((1 - share) * total), False


def _drive(prepared: Prepared) -> FloatArray | None:
    """Drive torque of all wheels."""
    by_wheel = _sum(prepared, [f"drive_torque_{w}" for w in WHEELS])
    return _column(prepared, "drive_torque") if by_wheel is None else by_wheel


def _allowed(prepared: Prepared, true: TrueSpeed | None, notes: list[str]) -> BoolArray:
    """Flat road by 2-D against 3-D speed and by a grade signal; satellites and HDOP where their speed is used."""
    columns = prepared.columns
    good = np.ones(len(prepared.time_s), dtype=bool)
    grade = columns.get("road_grade")
    if grade is not None:
        good &= ~(np.abs(np.nan_to_num(grade)) > STEEPEST_RAD)
    flat, space = columns.get("gps_speed_2d"), columns.get("gps_speed_3d")
    if flat is not None and space is not None:
        apart = fill(space - flat)
        mean = window_mean(apart, round(1.5 * prepared.rate_hz))
        noise = 1.4826 * float(np.median(np.abs(mean - np.median(mean))))
        steep = 0.5 * (2 * STEEPEST_RAD) ** 2 * np.maximum(fill(flat), 1.0)
        good &= ~(mean - float(np.median(mean)) > steep + 3 * noise)
    if true is not None and true.name.startswith("gps"):
        count, hdop = columns.get("satellites"), columns.get("hdop")
        if count is not None:
            good &= ~(count < FEWEST_SATELLITES - 0.5)
        if hdop is not None:
            good &= ~(hdop > WORST_HDOP)
    shut = 100 * (1 - float(good.mean())) if len(good) else 0.0
    if shut > 1:
        notes.append(f"{shut:.0f} % of the drive left out: slope, or few satellites")
    return np.asarray(good)


STRAIGHT_RADPS = 0.015


def _level(prepared: Prepared, true: TrueSpeed | None, notes: list[str]) -> tuple[float, float]:
    """Offsets of accel_x and accel_y in m/s², from the drive itself where it is long enough, else from standstill.

    Along: what is left of the accelerometer over the speed's own derivative in the mean (slopes up and down cancel
    over a drive). Across: its reading on straight road. A standstill's reading holds the slope of the place.
    """
    at_rest = [prepared.standstill_offset.get(name, (0.0, 0.0))[0] for name in ("accel_x", "accel_y")]
    along, across = _column(prepared, "accel_x"), _column(prepared, "accel_y")
    mask = inside(prepared)
    if true is None or mask.sum() < 30 * prepared.rate_hz:
        return at_rest[0], at_rest[1]
    moving = mask & (true.speed > 3.0)
    if along is not None and true.told and moving.sum() > 30 * prepared.rate_hz:
        kinematic = np.gradient(true.speed) * prepared.rate_hz * true.gain
        at_rest[0] = float(np.mean((along - kinematic)[moving]))
    yaw = _column(prepared, "yaw_rate", offset=True)
    if across is not None and yaw is not None:
        straight = moving & (np.abs(yaw) < STRAIGHT_RADPS)
        if straight.sum() > 10 * prepared.rate_hz:
            at_rest[1] = float(np.mean((across - yaw * true.speed)[straight]))
    notes.append(
        f"accelerometer offsets taken as {at_rest[0]:.2f} (along) and {at_rest[1]:.2f} m/s² (across)"
    )
    return at_rest[0], at_rest[1]


def _gyro(prepared: Prepared) -> FloatArray | None:
    """Roll rate without its offset: at standstill, else its mean over half a minute or more (the body comes back)."""
    rate = _column(prepared, "roll_rate", offset=True)
    mask = inside(prepared)
    if rate is None or "roll_rate" in prepared.standstill_offset or mask.sum() < 30 * prepared.rate_hz:
        return rate
    return rate - float(np.mean(rate[mask]))


def collect_data(prepared: Prepared, known: BrakeRollVehicle) -> BrakeRollData:
    """The columns, and why parts of them are missing."""
    missing: list[str] = []
    notes: list[str] = []
    wheels = {w: _column(prepared, f"wheel_speed_{w}") for w in WHEELS}
    whole = all(column is not None for column in wheels.values())
    yaw = _column(prepared, "yaw_rate", offset=True)
    f_x = _column(prepared, "accel_x")
    sums = [_sum(prepared, pair) for pair in (WHEEL_SPEEDS[:2], WHEEL_SPEEDS[2:])]
    axles = [None if each is None else each / 2 for each in sums]
    there = [each for each in axles if each is not None]
    rolling = np.asarray(np.mean(there, axis=0)) if there else None
    front, rear = axles if whole else (None, None)
    apart = np.zeros(len(prepared.time_s))
    if whole:
        turn = 0.0 if yaw is None else yaw * known.track.value
        for left, right in (("fl", "fr"), ("rl", "rr")):
            a, b = wheels[left], wheels[right]
            assert a is not None
            assert b is not None
            apart = np.maximum(apart, np.abs(b - a - turn))
    else:
        missing.append("no speeds of all four wheels")
    mean = None if front is None or rear is None else 0.5 * (front + rear)
    true = choose_speed(prepared, mean, f_x)
    if true is None:
        missing.append("no vehicle speed")
    front_torque, rear_torque, share_known = _brakes(prepared, known, missing)
    if true is not None and mean is not None and front_torque is not None and f_x is not None:
        braking = (front_torque > 0.3 * known.mass.value * known.radius.value).astype(np.float64)
        slope = slip_slope(true.speed, mean, f_x, braking)
        if true.own or (math.isfinite(slope) and slope < 1 / STIFFEST):
            missing.append(
                "the speed shows no slip of the wheels: it is taken from them (slip needs satellite speed)"
            )
    by_pressure = not share_known and _column(prepared, "brake_torque") is None
    drive = _drive(prepared)
    along, across = _level(prepared, true, notes)
    f_y = _column(prepared, "accel_y")
    return BrakeRollData(
        prepared.rate_hz, prepared.time_s, inside(prepared), true,
        None if f_x is None else f_x - along, None if f_y is None else f_y - across, _gyro(prepared), yaw, front, rear,
        rolling, apart, front_torque, rear_torque, share_known, by_pressure, drive, _column(prepared, "steering_wheel_angle"),
        _column(prepared, "roll"), _allowed(prepared, true, notes), tuple(missing), tuple(notes),
    )  # fmt: skip


@dataclass(frozen=True)
class WheelScale:
    """Wheel speed over true speed of an axle that rolls freely, with its standard deviation."""

    front: float
    rear: float
    std: float
    told: bool


def wheel_scales(data: BrakeRollData, known: BrakeRollVehicle) -> WheelScale:
    """From rows with the foot off the brake on straight road: the ratio where no force acts on the axle.

    Drive slip is proportional to force: the ratio is fitted over the force and read at none.
    """
    usual = WheelScale(1.0, 1.0, 0.01, False)
    if data.true is None or data.front is None or data.rear is None or data.f_x is None:
        return usual
    v = data.true.speed
    braked = np.zeros(len(v), dtype=bool)
    if data.front_torque is not None and data.rear_torque is not None:
        braked = (data.front_torque + data.rear_torque) > 0.1 * known.mass.value * known.radius.value
    yaw = np.zeros(len(v)) if data.yaw_rate is None else data.yaw_rate
    use = data.rows & data.allowed & ~braked & (v > 6.0) & (np.abs(yaw) < 0.05) & (np.abs(data.f_x) < 2.5)
    if use.sum() < 2 * data.rate_hz:
        return usual
    pull = data.f_x / data.true.gain + drag(v, known.drag_area.value) / known.mass.value
    design = np.stack([np.ones(int(use.sum())), pull[use]], axis=1)
    found: list[float] = []
    spread = 0.0
    for wheel in (data.front, data.rear):
        ratio = wheel[use] / v[use]
        keep = np.abs(ratio - np.median(ratio)) < 0.05
        gram = np.linalg.inv(design[keep].T @ design[keep] + np.diag([1e-9, 1e-3]))
        beta = gram @ (design[keep].T @ ratio[keep])
        residual = ratio[keep] - design[keep] @ beta
        found.append(float(beta[0]))
        spread = max(spread, float(np.std(residual)) * math.sqrt(data.rate_hz * float(gram[0, 0])))
    return WheelScale(found[0], found[1], max(spread, 5e-4), True)
