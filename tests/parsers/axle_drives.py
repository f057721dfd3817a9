"""A body that leans on both axles, as four wheels' deflections and a lateral acceleration."""

from __future__ import annotations

import numpy as np

from parsers.drive import Signal

RATE_HZ = 50


def drive(
    rear: float, *, seconds: float = 120.0, tyres: float = 1.05, lean: float = 0.02, seed: int = 1
) -> dict[str, Signal]:
    """A body that leans in bends and heaves on a rough road. rear: scale of the rear sensors; lean: m of half a track's travel a g/10."""
    rng = np.random.default_rng(seed)
    n = round(seconds * RATE_HZ)
    time_ns = (np.arange(n) * (1e9 / RATE_HZ)).astype(np.int64)
    t = time_ns / 1e9
    side = 2.0 * np.sin(0.35 * t) + 0.8 * np.sin(1.1 * t + 1)
    columns = {"accel_y": side + 0.05 * rng.standard_normal(n)}
    for wheel in ("fl", "fr", "rl", "rr"):
        down = lean * 0.5 * side * (1 if wheel[1] == "r" else -1)
        if wheel[0] == "r":
            down = down * tyres
        road = 0.006 * rng.standard_normal(n) + 0.004 * np.sin(7.3 * t + ord(wheel[0]))
        columns[f"suspension_deflection_{wheel}"] = (down + road + 0.03) * (rear if wheel[0] == "r" else 1.0)
    return {name: Signal(name, time_ns, values, name) for name, values in columns.items()}
