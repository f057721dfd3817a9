"""The vehicle's true speed, which slip is measured against: where it is from, its delay, and whether it is true.

A speed that is taken from the wheels shows no slip; one that comes late shows its delay times the deceleration, which
is as large as the slip itself (0.15 s at 0.6 g is 0.9 m/s). The delay is read from the accelerometer, which slip does
not disturb: the speed must follow the integral of the longitudinal acceleration.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray

CANDIDATES = ("speed", "gps_speed_2d", "gps_speed_3d")
BAND_HZ = (0.05, 1.0)
"""Where delay and scale are read: below it grade leans on the accelerometer, above it satellite speed is noise."""

LONGEST_DELAY_S = 0.6
STIFFEST = 80.0
"""Normalised slip stiffness beyond any tyre's (10-60): a speed that gives more is the wheels' own."""


@dataclass(frozen=True)
class TrueSpeed:
    """speed: (n,) m/s without its delay. name: signal. delay_s with its standard deviation (None: not told).

    gain: what the accelerometer reads per m/s² of true acceleration: body pitch and scale error (1 where not told). own: it
    is the wheels' speed.
    """

    speed: FloatArray
    name: str
    delay_s: float
    delay_std_s: float
    gain: float
    gain_std: float
    told: bool
    own: bool = False


def fill(values: FloatArray) -> FloatArray:
    """The column without NaN: straight lines across, ends held; zeros where nothing is there."""
    good = np.isfinite(values)
    if good.all():
        return values
    if not good.any():
        return np.zeros(len(values))
    rows = np.arange(len(values))
    return np.asarray(np.interp(rows, rows[good], values[good]))


def _band(values: FloatArray, rate_hz: float) -> FloatArray:
    return lowpass(values, rate_hz, BAND_HZ[1]) - lowpass(values, rate_hz, BAND_HZ[0])


def _rows(speed: FloatArray, f_x: FloatArray, segments: tuple[Segment, ...], rate_hz: float) -> list[slice]:
    """Stretches inside segments where both are there, of ten seconds or more: shorter ones are all ends to the band's
    filters."""
    there = np.zeros(len(speed), dtype=bool)
    for segment in segments:
        # a row of False between segments keeps them apart
        there[segment.start : max(segment.stop - 1, segment.start)] = True
    there &= np.isfinite(speed) & np.isfinite(f_x)
    return [slice(a, b) for a, b in runs(there) if b - a >= 10 * rate_hz]


def _integral(values: FloatArray, rate_hz: float) -> FloatArray:
    """Running integral by the trapezoid: a plain sum would be half a sample ahead."""
    return np.asarray((np.cumsum(values) - 0.5 * (values + values[0])) / rate_hz)


def alignment(
    speed: FloatArray,
    f_x: FloatArray,
    segments: tuple[Segment, ...],
    rate_hz: float,
    turning: tuple[FloatArray, FloatArray] | None = None,
) -> tuple[float, float, float, float] | None:
    """Delay of `speed` in s, its standard deviation, the accelerometer's gain and its; None where the drive says nothing.

    speed, f_x: (n,). The band-passed speed is the band-passed integral of f_x / gain, delay_s later. turning: (n,) r² and
    r v f_y without NaN: in a corner v' is f_x + r v_y, with v_y of a single-track car in proportion to these two.
    """
    parts: list[tuple[FloatArray, FloatArray, FloatArray, list[FloatArray]]] = []
    for rows in _rows(speed, f_x, segments, rate_hz):
        pushed = f_x[rows] - float(np.mean(f_x[rows]))
        extra = (
            []
            if turning is None
            else [_band(_integral(column[rows], rate_hz), rate_hz) for column in turning]
        )
        parts.append((_band(speed[rows], rate_hz), _integral(pushed, rate_hz), pushed, extra))
    if not parts:
        return None
    delay, gain = 0.0, 1.0
    delay_std = gain_std = math.inf
    for _ in range(4):
        left, columns = [], []
        for wanted, turned, pushed, extra in parts:
            rows_s = np.arange(len(turned)) / rate_hz
            late = rows_s - delay
            moved = np.interp(late, rows_s, turned)
            left.append(wanted)
            moves = _band(np.interp(late, rows_s, pushed), rate_hz)
            columns.append(np.stack([_band(moved, rate_hz), moves, *extra], axis=1))
        y, x = np.concatenate(left), np.concatenate(columns)
        power = float(np.mean(x[:, 1] ** 2))
        if power < 0.05**2:
            return None
        gram = np.linalg.pinv(x.T @ x, rcond=1e-10)
        beta = gram @ (x.T @ y)
        scale, moved_by = float(beta[0]), float(beta[1])
        if not 0.5 < scale < 2.0:
            return None
        residual = y - x @ beta
        # a band of 1 Hz holds two independent values a second
        effective = float(residual @ residual) / len(y) * rate_hz / (2 * BAND_HZ[1])
        delay_std, gain_std = (float(v) for v in np.sqrt(effective * np.diag(gram)[[1, 0]]))
        delay_std /= float(scale)
        gain_std /= float(scale) ** 2
        gain = 1 / float(scale)
        step = -float(moved_by) / float(scale)
        delay = min(max(delay + step, -LONGEST_DELAY_S), LONGEST_DELAY_S)
        if abs(step) < 1e-4:
            break
    return delay, max(delay_std, 0.005), gain, max(gain_std, 0.002)


def shifted(values: FloatArray, seconds: float, rate_hz: float) -> FloatArray:
    """The column read `seconds` later: what a channel that comes late said when it should have. Ends held."""
    rows = np.arange(len(values), dtype=np.float64)
    return np.asarray(np.interp(rows + seconds * rate_hz, rows, values))


def slip_slope(speed: FloatArray, wheels: FloatArray, f_x: FloatArray, braking: FloatArray) -> float:
    """Slip per g of braking: 1 / C_x,n of the whole vehicle; about 0 where the speed is the wheels' own.

    All (n,); braking: 1 where the brakes are on. Rows without brakes tell the wheels' radius, and what is left of a
    delay goes with f_x alone. NaN without braking.
    """
    on = (braking > 0.5) & (f_x < -0.5)
    use = (speed > 3.0) & (on | (braking < 0.5))
    if (on & use).sum() < 20:
        return math.nan
    slip = np.where(on, -f_x / 9.80665 * speed, 0.0)
    design = np.stack([slip, speed, f_x], axis=1)[use]
    return float(np.linalg.lstsq(design, (speed - wheels)[use], rcond=None)[0][0])


def _turning(prepared: Prepared, speed: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """r² and r v f_y, where yaw rate and lateral acceleration are there."""
    yaw, across = prepared.columns.get("yaw_rate"), prepared.columns.get("accel_y")
    if yaw is None or across is None:
        return None
    r, f, v = np.nan_to_num(yaw), np.nan_to_num(across), np.nan_to_num(speed)
    return np.asarray(r**2), np.asarray(r * v * f)


def choose_speed(prepared: Prepared, wheels: FloatArray | None, f_x: FloatArray | None) -> TrueSpeed | None:
    """The best true speed that the log has; None where there is none. wheels: mean wheel speed (n,).

    Of the candidates, one that equals the wheels' mean is passed over when another is there.
    """
    columns: Mapping[str, FloatArray] = prepared.columns
    found: list[tuple[bool, TrueSpeed]] = []
    for name in CANDIDATES:
        if name not in columns or prepared.share_of(columns[name]) < 0.5:
            continue
        speed = columns[name]
        aligned = (
            None
            if f_x is None
            else alignment(speed, f_x, prepared.segments, prepared.rate_hz, _turning(prepared, speed))
        )
        own = wheels is not None and equals_wheels(speed, wheels)
        if aligned is None:
            chosen = TrueSpeed(fill(speed), name, 0.0, 0.05, 1.0, 0.05, False, own)
        else:
            delay, delay_std, gain, gain_std = aligned
            moved = fill(shifted(fill(speed), delay, prepared.rate_hz))
            chosen = TrueSpeed(moved, name, delay, delay_std, gain, gain_std, True, own)
        found.append((own, chosen))
    true = [speed for own, speed in found if not own]
    return true[0] if true else (found[0][1] if found else None)


def equals_wheels(speed: FloatArray, wheels: FloatArray) -> bool:
    """Whether a speed (n,), as it was logged, is the wheels' own within 3 cm/s over 98 % of the moving rows."""
    moving = np.isfinite(wheels) & np.isfinite(speed) & (speed > 2.0)
    if moving.sum() <= 20:
        return False
    ratio = float(np.median(wheels[moving] / speed[moving]))
    return float(np.quantile(np.abs(speed[moving] * ratio - wheels[moving]), 0.98)) < 0.03
