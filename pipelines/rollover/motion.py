"""The drive as its rollover needs it: lateral specific force along the road, body roll against the road, roll acceleration.

All low-passed alike at 3 Hz (zero phase): a vehicle needs some tenths of a second to leave its wheels, steering is below 2 Hz,
the roll motion at 1-2.5 Hz; what is above is wheel hop, engine and noise, and its peaks lift nothing for long.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from parsers.drive import Drive
from pipelines.models.roll import GRAVITY
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.prepare.roll_angle import rank_roll
from pipelines.prepare.signals import prepare_signals
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray
from pipelines.rollover.body import Body
from pipelines.rollover.lean import USUAL_TIRE_SHARE, deflected, lean_of
from pipelines.rollover.limits import level
from pipelines.rollover.zero import accel_zero
from pipelines.rollover_results import TurnSide
from pipelines.vehicles.vehicle import Quantity, Vehicle

CUTOFF_HZ = 3.0
RATE_HZ = 40.0
SCALE_STD = 0.007
SLOW_HZ = 0.5
"""Below this a line through roll and acceleration is the roll gradient: slower than the roll motion."""
CLEAR_G = 0.3
FELL_RAD, FELL_S, FALLING_S, BEFORE_S = 0.5, 0.15, 3.0, 0.5
"""Body roll from which, if it lasts, the vehicle has fallen over: no suspension gives so much. By a gyro: what comes within
FALLING_S. What is less than BEFORE_S earlier is left out too: the low-pass has the fall in it."""
"""Where the body's vertical specific force is below this there is no quasi-static roll to speak of."""


@dataclass(frozen=True)
class Fall:
    """When the vehicle fell over, and in a turn to which side it did: the wheels of that side lifted."""

    time_s: float
    turn: TurnSide


@dataclass(frozen=True)
class Motion:
    """Columns on one grid, rows of gap-free segments only, one after another. All (n,).

    lateral: f_y / f_z along the road at the CG's place, in g. roll: body against the road, rad, 0 at rest. roll_gain:
    relative error of its scale; it follows the gradient where `steady`. roll_acceleration, yaw_acceleration over f_z
    [1/m]; zero where not known. swing: the part of the roll that is guessed, swing_acceleration of that of roll_acceleration. bias_g, roll_std: of the offsets. segment: (n,) its number. fell: where the
    vehicle fell over; nothing after that is held.
    """

    time_s: FloatArray
    lateral: FloatArray
    roll: FloatArray
    roll_acceleration: FloatArray
    yaw_acceleration: FloatArray
    segment: FloatArray
    swing: FloatArray
    swing_acceleration: FloatArray
    steady: bool
    roll_gain: float
    roll_std: float
    bias_g: float
    how: tuple[str, ...]
    fell: Fall | None = None


def _rows(prepared: Prepared) -> FloatArray:
    """Number of each row's segment; NaN outside."""
    number = np.full(len(prepared.time_s), np.nan)
    for place, segment in enumerate(prepared.segments):
        number[segment.start : segment.stop] = place
    return number


def _slope(prepared: Prepared, values: FloatArray) -> FloatArray:
    """d/dt within segments; 0 where values are missing."""
    found = np.zeros(len(values))
    for s in prepared.segments:
        found[s.start : s.stop] = np.gradient(values[s.start : s.stop]) * prepared.rate_hz
    return np.where(np.isfinite(found), found, 0.0)


def _accel(prepared: Prepared) -> tuple[FloatArray, float, str]:
    """Lateral reading less its offset, what the offset may still be in g, and how it was found."""
    zero, error, text = accel_zero(prepared)
    return prepared.columns["accel_y"] - zero, error, text


def _vertical(prepared: Prepared) -> tuple[FloatArray, str]:
    """Vertical specific force of the body; g where it is not measured, or not with gravity."""
    values = prepared.columns.get("accel_z")
    plain = np.full(len(prepared.time_s), GRAVITY)
    if values is None or not np.isfinite(values).any():
        return plain, "vertical specific force taken as g"
    scale = prepared.standstill_offset.get("accel_z", (float(np.nanmedian(values)), 0.0))[0] / GRAVITY
    if not 0.85 < scale < 1.15:
        return plain, "vertical acceleration without gravity: specific force taken as g"
    return np.where(
        np.isfinite(values), np.maximum(values / scale, CLEAR_G * GRAVITY), GRAVITY
    ), "vertical specific force measured"


def prepare_motion(drive: Drive) -> Prepared:
    """All that the drive has of the lateral motion, on one grid."""
    deflections = [n for n in drive.signals if n.startswith("suspension_deflection_")]
    return prepare_signals(
        drive, ["accel_y"], rate_hz=RATE_HZ, cutoff_hz=CUTOFF_HZ,
        optional=["accel_z", "roll", "roll_rate", "yaw_rate", "speed", *deflections],
    )  # fmt: skip


def _toppling(prepared: Prepared) -> FloatArray:
    """(n,) roll that can only be a fall: the measured angle, else what the gyro gathered over the last FALLING_S."""
    angle, rate = prepared.columns.get("roll"), prepared.columns.get("roll_rate")
    found = np.zeros(len(prepared.time_s))
    width = round(FALLING_S * prepared.rate_hz)
    for s in prepared.segments:
        part = slice(s.start, s.stop)
        if angle is not None:
            found[part] = np.where(np.isfinite(angle[part]), angle[part], 0.0)
        elif rate is not None:
            turned = np.cumsum(np.where(np.isfinite(rate[part]), rate[part], 0.0)) / prepared.rate_hz
            found[part] = (
                turned - np.concatenate((np.full(min(width, len(turned)), turned[0]), turned))[: len(turned)]
            )
    return found


def until_fall(prepared: Prepared) -> tuple[Prepared, Fall | None]:
    """The drive up to where the vehicle fell over; and that fall, where there was one."""
    roll = _toppling(prepared)
    fallen = [a for a, b in runs(np.abs(roll) > FELL_RAD) if b - a >= FELL_S * prepared.rate_hz]
    if not fallen:
        return prepared, None
    last = fallen[0] - round(BEFORE_S * prepared.rate_hz)
    kept = tuple(Segment(s.start, min(s.stop, last)) for s in prepared.segments if s.start + 8 < last)
    # falling to the right, the left wheels are in the air
    side: TurnSide = "left" if roll[fallen[0]] > 0 else "right"
    return replace(prepared, segments=kept), Fall(float(prepared.time_s[fallen[0]]), side)


def fitted_gradient(prepared: Prepared, vehicle: Vehicle) -> Quantity | None:
    """Roll gradient in deg a sensed g by a line through slow roll and slow acceleration; None where there is no such turn.

    A stand-in for a verdict that has none: the line's own error is small beside the 10 % that friction, stops and bank leave.
    """
    prepared, _ = until_fall(prepared)
    if not prepared.segments:
        return None
    accel, _, _ = _accel(prepared)
    source = next((s for s in rank_roll(prepared, vehicle) if s.kind in ("deflections", "measured")), None)
    if source is None:
        return None
    share = USUAL_TIRE_SHARE if source.kind == "deflections" else 1.0
    angle, _ = deflected(prepared, accel, source, share)
    moments = np.zeros(3)
    for s in prepared.segments:
        part = slice(s.start, s.stop)
        if not np.isfinite(angle[part]).all():
            continue
        slow = lowpass(accel[part], prepared.rate_hz, SLOW_HZ) / GRAVITY
        lean = lowpass(angle[part], prepared.rate_hz, SLOW_HZ)
        rows = (np.abs(slow) > 0.1) & (np.abs(slow) < 0.7)
        moments += [rows.sum(), slow[rows] @ slow[rows], slow[rows] @ lean[rows]]
    if moments[0] < 2.0 * prepared.rate_hz:
        return None
    value = math.degrees(float(moments[2] / moments[1]))
    how = "a line through this drive's slow roll and sensed acceleration"
    return Quantity(value, 0.1 * value, how) if 0.5 < value < 14.0 else None


def read_motion(
    prepared: Prepared, vehicle: Vehicle, body: Body | None, mass_kg: float | None
) -> Motion | None:
    """The drive's motion; None without a stretch of lateral acceleration. body None: the vehicle is not known."""
    prepared, fell = until_fall(prepared)
    if not prepared.segments:
        return None
    accel, bias, how_bias = _accel(prepared)
    vertical, how_z = _vertical(prepared)
    lean = lean_of(prepared, vehicle, accel, body, mass_kg)
    roll = lean.angle
    rate = prepared.columns.get("roll_rate")
    has_rate = rate is not None and bool(np.isfinite(rate).any())
    turned = (
        _slope(prepared, rate) if rate is not None and has_rate else _slope(prepared, _slope(prepared, roll))
    )
    yaw = prepared.columns.get("yaw_rate")
    swerve = np.zeros(len(accel)) if yaw is None else _slope(prepared, yaw)
    at_cg = accel.copy()
    if body is not None:
        ahead, above, lever = (float(np.median(x)) for x in (body.imu_ahead, body.imu_above, body.lever))
        spin2 = np.zeros(len(accel)) if yaw is None else np.where(np.isfinite(yaw), yaw, 0.0) ** 2
        at_cg += (above - lever) * turned - ahead * swerve + body.imu_left * spin2
    number = _rows(prepared)
    rows = np.isfinite(number)
    lateral = level(at_cg, vertical, roll)
    words = (
        (lean.how, how_bias, how_z)
        if has_rate
        else (lean.how, how_bias, how_z, "roll acceleration from the roll angle")
    )
    return Motion(
        prepared.time_s[rows], lateral[rows], roll[rows], (turned / vertical)[rows], (swerve / vertical)[rows],
        number[rows], lean.swing[rows], _slope(prepared, _slope(prepared, lean.swing))[rows] / vertical[rows], lean.steady, lean.gain, lean.std, bias, words, fell,
    )  # fmt: skip
