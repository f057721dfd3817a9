"""When the vehicle stands still, and what its sensors read then."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from parsers.drive import Drive, Signal
from parsers.signals import WHEEL_SPEEDS
from pipelines.prepare.prepared import BoolArray
from pipelines.prepare.resample import on_grid
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray

STILL_SPEED = 0.1
STILL_GYRO = 0.006
STILL_ACCEL = 0.09
SHORTEST_S = 1.0
ROCKS_S = 3.0
TRIM_S = 0.3
"""Limits: speed m/s; spread of rates rad/s and of accelerations m/s² over one second; s of standstill needed; s that
the body rocks after a stop; s left out before motion begins."""

SPEEDS: tuple[str, ...] = ("speed", *WHEEL_SPEEDS, "gps_speed_2d", "gps_speed_3d")
GYROS = ("roll_rate", "pitch_rate", "yaw_rate")
ACCELS = ("accel_x", "accel_y", "accel_z")


def _spread(column: FloatArray, rows: int) -> FloatArray:
    """Standard deviation over a window of `rows` around each row; NaN where data are missing."""
    if len(column) < rows:
        return np.full(len(column), np.nan)
    bad = ~np.isfinite(column)
    level = float(np.nanmean(column)) if not bad.all() else 0.0
    clean = np.where(bad, 0.0, column - level)
    window = np.ones(rows) / rows
    mean = np.convolve(clean, window, mode="same")
    square = np.convolve(clean * clean, window, mode="same")
    spread = np.sqrt(np.maximum(square - mean * mean, 0.0))
    spread[np.convolve(bad, window, mode="same") > 1e-9] = np.nan
    return np.asarray(spread)


def _by_speed(
    drive: Drive, start_ns: int, rows: int, rate_hz: float, max_gap_s: float | None
) -> BoolArray | None:
    """Rows at rest by the first speed signal that is there; wheel speeds must all be at rest."""
    wheels = [drive.signals[name] for name in WHEEL_SPEEDS if name in drive.signals]
    groups: list[list[Signal]] = [[drive.signals["speed"]]] if "speed" in drive.signals else []
    groups += [wheels] if wheels else []
    groups += [[drive.signals[name]] for name in SPEEDS[-2:] if name in drive.signals]
    if not groups:
        return None
    still = np.ones(rows, dtype=bool)
    # satellite speed at rest is noise of a few cm/s: it may not be zero to the digit
    limit = STILL_SPEED if groups[0][0].name not in SPEEDS[-2:] else 2 * STILL_SPEED
    for signal in groups[0]:
        column = on_grid(signal, start_ns, rows, rate_hz, 1, None, max_gap_s)
        still &= np.abs(np.where(np.isfinite(column), column, np.inf)) < limit
    return still


def _by_imu(drive: Drive, start_ns: int, rows: int, rate_hz: float) -> BoolArray:
    """Rows at rest by the quiet of the inertial sensors; needs at least a gyro and an accelerometer."""
    window = max(3, round(rate_hz))
    still = np.ones(rows, dtype=bool)
    seen = [0, 0]
    for kind, (names, limit) in enumerate(((GYROS, STILL_GYRO), (ACCELS, STILL_ACCEL))):
        for name in names:
            if name not in drive.signals:
                continue
            seen[kind] += 1
            column = on_grid(drive.signals[name], start_ns, rows, rate_hz, 1, None, None)
            spread = _spread(column, window)
            still &= np.where(np.isfinite(spread), spread, np.inf) < limit
    return still if min(seen) > 0 else np.zeros(rows, dtype=bool)


def find_standstill(
    drive: Drive, start_ns: int, rows: int, rate_hz: float, max_gap_s: float | None = None
) -> tuple[BoolArray, str]:
    """Rows of the grid at which the vehicle stands still, and how that was told.

    By speed where there is one (below 0.1 m/s), else by quiet inertial sensors. Only stretches of a second or more.
    """
    by_speed = _by_speed(drive, start_ns, rows, rate_hz, max_gap_s)
    if by_speed is None:
        still, how = _by_imu(drive, start_ns, rows, rate_hz), "quiet inertial sensors"
    else:
        still, how = by_speed, "speed"
    for first, past in runs(still):
        if past - first < SHORTEST_S * rate_hz:
            still[first:past] = False
    return still, how


def first_rest(still: BoolArray, rate_hz: float) -> tuple[int, int] | None:
    """Rows of the first standstill in which the body is at rest, or None.

    A standstill at the drive's beginning counts whole. After a stop the body still rocks: the first three seconds
    are left out, and nothing remains of a short one.
    """
    for first, past in runs(still):
        begin = first if first <= rate_hz else first + round(ROCKS_S * rate_hz)
        end = past if past == len(still) else past - round(TRIM_S * rate_hz)
        if end - begin >= SHORTEST_S * rate_hz:
            return begin, end
    return None


def _mean_and_error(values: FloatArray, rate_hz: float) -> tuple[float, float]:
    """Mean and its standard error; noise that is correlated over up to half a second is allowed for."""
    block = max(1, round(0.5 * rate_hz))
    blocks = len(values) // block
    white = float(values.std()) / math.sqrt(max(len(values), 1))
    if blocks < 2:
        return float(values.mean()), 3 * white
    means = values[: blocks * block].reshape(blocks, block).mean(axis=1)
    return float(values.mean()), max(white, float(means.std(ddof=1)) / math.sqrt(blocks))


def standstill_offsets(
    columns: Mapping[str, FloatArray], names: Sequence[str], rest: tuple[int, int] | None, rate_hz: float
) -> dict[str, tuple[float, float]]:
    """signal -> (mean reading at rest, standard error). Empty without a rest; a signal with holes there is left out."""
    if rest is None:
        return {}
    found: dict[str, tuple[float, float]] = {}
    for name in names:
        values = columns[name][rest[0] : rest[1]]
        values = values[np.isfinite(values)]
        if len(values) >= SHORTEST_S * rate_hz:
            found[name] = _mean_and_error(values, rate_hz)
    return found
