"""Axle loads that come late: scales of air suspensions and weighing units that average for a second, or are renewed once in it.

They tell what the axles carry. What a brake or a bend does to them is over, or not yet there, when they show it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.estimators.load_balance.smoothing import Smoother
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray
from pipelines.vehicles.kinds import Kind

LATE_S = 0.4
"""Lateness of the sensors from which on they are used at rest only."""
OWN_LAG_S = {"car": 0.07, "carrier": 0.13, "heavy": 0.15}
"""How much load transfer itself comes after the acceleration (0.13 to 0.19 s in vans, lorries and buses, with signals of 20 Hz)."""
LEAST_S = 0.05
"""Lateness up to which the balances' own unknown holds it."""
MOST_S = 2.5
LEAST_ALIKE = 0.4
"""Correlation with the acceleration below which nothing is told."""
SLOW_HZ = 3.0
"""Above it wheels and sensors have their say, below it the body."""


KEPT = 0.4
"""Share of what is quicker than a mean over twice their lateness that loads must lack to be such a mean: merely late ones have all of it."""

LEAST_MEAN_S = 0.35
"""A mean over less takes away next to nothing of a body's motion, and is not told from noise in the acceleration."""

LEAST_TOLD = 0.6
"""Correlation with both parts of the acceleration below which nothing is told of averaging."""


@dataclass(frozen=True)
class Lateness:
    """Of axle loads. late_s: by how much they come after what they show; mean_s: over how long they are a mean of it."""

    late_s: float
    mean_s: float


IN_TIME = Lateness(0.0, 0.0)


def lateness(prepared: Prepared, kind: Kind) -> Lateness:
    """How late the axle loads are, and over how long they average. kind: of vehicle.

    A rough road tells the lateness best, as force and acceleration of the heaving body are at once; else the load transfer in braking,
    which is itself a little late. A mean over so long is late by half of it, whatever braking says.
    """
    c = prepared.columns
    if not {"axle_load_front", "axle_load_rear"} <= c.keys():
        return IN_TIME
    late, own = None, 0.0
    if "accel_z" in c:
        late = lag_s(prepared, c["axle_load_front"] + c["axle_load_rear"], c["accel_z"])
    if late is None and "accel_x" in c:
        late, own = lag_s(prepared, c["axle_load_rear"] - c["axle_load_front"], c["accel_x"]), OWN_LAG_S[kind]
    if late is None or late <= LEAST_S:
        return IN_TIME
    mean = 2 * late if 2 * late > LEAST_MEAN_S and _averaged(prepared, late) else 0.0
    sure = max(late - own, 0.5 * mean)
    return Lateness(sure, mean) if sure > LEAST_S else IN_TIME


def _averaged(prepared: Prepared, late_s: float) -> bool:
    """Whether loads that are late are a mean over twice their lateness, and not merely sent late.

    By how much they go with what such a mean keeps of an acceleration, and with what it takes away.
    """
    c = prepared.columns
    pairs = [
        (c["axle_load_front"] + c["axle_load_rear"], "accel_z"),
        (c["axle_load_rear"] - c["axle_load_front"], "accel_x"),
    ]
    best, quick = LEAST_TOLD, 1.0
    smooth = Smoother(prepared, min(SLOW_HZ, 0.45 * prepared.rate_hz), 2 * late_s)
    plain = Smoother(prepared, smooth.band_hz)
    for load, name in pairs:
        if name not in c:
            continue
        # derivatives: what stays over many seconds is hills, and would outweigh the rest
        a, kept, whole = (
            plain.whole(earlier(load, prepared, late_s), 1),
            smooth.whole(c[name], 1),
            plain.whole(c[name], 1),
        )
        rows = np.isfinite(a) & np.isfinite(kept) & np.isfinite(whole)
        if rows.sum() < 10:
            continue
        parts = np.column_stack([kept[rows], whole[rows] - kept[rows]])
        gains = np.linalg.lstsq(parts, a[rows], rcond=None)[0]
        power = float(a[rows] @ a[rows])
        alike = float(
            np.sqrt(max(1 - float(np.sum((a[rows] - parts @ gains) ** 2)) / max(power, 1e-12), 0.0))
        )
        if alike > best and gains[0] != 0:
            best, quick = alike, float(gains[1] / gains[0])
    return abs(quick) < KEPT


def earlier(values: FloatArray, prepared: Prepared, seconds: float) -> FloatArray:
    """(n,) a column that came so much too late, where it belongs; NaN at the ends of segments, from where nothing came any more."""
    rows = round(seconds * prepared.rate_hz)
    out = np.full(len(values), np.nan)
    for s in prepared.segments:
        if s.stop - s.start > rows:
            out[s.start : s.stop - rows] = values[s.start + rows : s.stop]
    return out


def lag_s(prepared: Prepared, late: FloatArray, first: FloatArray) -> float | None:
    """By how much one column (n,) comes after another, s, both below SLOW_HZ; None where they are not alike enough to tell."""
    if not prepared.segments:
        return None
    reach = round(MOST_S * prepared.rate_hz)
    total = np.zeros(2 * reach + 1)
    power = np.zeros(2)
    for segment in prepared.segments:
        rows = slice(segment.start, segment.stop)
        a, b = late[rows], first[rows]
        if len(a) <= 4 * reach or not (np.isfinite(a).all() and np.isfinite(b).all()):
            continue
        a, b = (lowpass(x - x.mean(), prepared.rate_hz, SLOW_HZ) for x in (a, b))
        size = 1 << (2 * len(a) - 1).bit_length()
        crossed = np.fft.irfft(np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size)), size)
        total += np.concatenate([crossed[-reach:], crossed[: reach + 1]])
        power += a @ a, b @ b
    if not power.all():
        return None
    best = int(np.argmax(total))
    alike = total[best] / np.sqrt(power[0] * power[1])
    return (best - reach) / prepared.rate_hz if alike >= LEAST_ALIKE else None
