"""Axle loads that come late: scales of air suspensions and weighing units that average for a second, or are renewed once in it.

They tell what the axles carry. What a brake or a bend does to them is over, or not yet there, when they show it.
"""

from __future__ import annotations

import numpy as np

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


def sensor_lag_s(prepared: Prepared, kind: Kind) -> float:
    """By how much axle loads are later than what they show, s; 0 up to LEAST_S. kind: of vehicle.

    A rough road tells it best, as force and acceleration of the heaving body are at once; else the load transfer in braking,
    which is itself a little late.
    """
    c = prepared.columns
    if not {"axle_load_front", "axle_load_rear"} <= c.keys():
        return 0.0
    late = None
    if "accel_z" in c:
        late = lag_s(prepared, c["axle_load_front"] + c["axle_load_rear"], c["accel_z"])
    if late is None and "accel_x" in c:
        braked = lag_s(prepared, c["axle_load_rear"] - c["axle_load_front"], c["accel_x"])
        late = None if braked is None else braked - OWN_LAG_S[kind]
    return 0.0 if late is None or late <= LEAST_S else late


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
