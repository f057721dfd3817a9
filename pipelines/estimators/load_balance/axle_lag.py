"""Axle loads that come late: scales of air suspensions and weighing units that average for a second, or are renewed once in it.

They tell what the axles carry. What a brake or a bend does to them is over, or not yet there, when they show it.
"""

from __future__ import annotations

import numpy as np

from pipelines.prepare.prepared import Prepared

LATE_S = 0.24
"""From here on they are used at rest only. Load transfer itself comes a tenth of a second after the acceleration (0.07 s in a car, 0.13 to
0.19 s in vans, lorries and buses, with signals of 20 Hz)."""
MOST_S = 2.5
LEAST_ALIKE = 0.4
"""Correlation with the acceleration below which nothing is told."""


def axle_lag_s(prepared: Prepared) -> float:
    """By how much the difference of both axles' loads comes after the longitudinal acceleration, s; 0 where it cannot be told."""
    c = prepared.columns
    if not prepared.segments or not {"accel_x", "axle_load_front", "axle_load_rear"} <= c.keys():
        return 0.0
    transfer, pushed = c["axle_load_rear"] - c["axle_load_front"], c["accel_x"]
    reach = round(MOST_S * prepared.rate_hz)
    total = np.zeros(2 * reach + 1)
    power = np.zeros(2)
    for segment in prepared.segments:
        rows = slice(segment.start, segment.stop)
        a, b = transfer[rows], pushed[rows]
        if len(a) <= 4 * reach or not (np.isfinite(a).all() and np.isfinite(b).all()):
            continue
        a, b = a - a.mean(), b - b.mean()
        size = 1 << (2 * len(a) - 1).bit_length()
        crossed = np.fft.irfft(np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size)), size)
        total += np.concatenate([crossed[-reach:], crossed[: reach + 1]])
        power += a @ a, b @ b
    if not power.all():
        return 0.0
    best = int(np.argmax(total))
    alike = total[best] / np.sqrt(power[0] * power[1])
    return (best - reach) / prepared.rate_hz if alike >= LEAST_ALIKE else 0.0
