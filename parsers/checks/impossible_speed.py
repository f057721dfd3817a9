"""A speed that brakes or speeds up as no tyre lets a vehicle: km/h or mph in a log that states no unit, with nothing beside that would tell which."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import CELL_S, Grid
from parsers.checks.motion import smooth
from parsers.drive import Decision

NAMES = ("speed", "gps_speed_2d")

MOST_MPS2 = 11.0
"""What road tyres come to. Racing cars, which come to more, have an accelerometer, and then that tells the unit."""

PART_S, PARTS = 0.5, 4
"""It must last through that many such parts one after the other: a receiver's jump is over in one."""


def impossible_speed(grid: Grid, stated: Mapping[str, bool], told: Collection[str]) -> list[Decision]:
    """Speeds without a stated unit that are left out. grid: with all units repaired; told: signals whose unit turned out to be another."""
    found: list[Decision] = []
    if grid.get("accel_x") is not None:
        return found
    for name in NAMES:
        speed = grid.get(name)
        if speed is None or stated.get(name, True) or name in told:
            continue
        lasting = _lasting(grid, speed)
        if lasting > MOST_MPS2:
            text = f"{name} is in km/h or mph, not in m/s: no vehicle brakes or speeds up like that"
            evidence = (
                f"it changes by more than {lasting:.3g} m/s in each second for {PART_S * PARTS:g} s, "
                f"tyres come to {MOST_MPS2:g}"
            )
            action = "left out: say the unit in a mapping file"
            found.append(Decision(name, "range", text, action, evidence, applied=True))
    return found


def _lasting(grid: Grid, speed: FloatArray) -> float:
    """The largest change a second that lasts, m/s²; 0 where there is none."""
    step = round(PART_S / CELL_S)
    if len(speed) <= step * PARTS:
        return 0.0
    even, span = smooth(speed), grid.time_s[step:] - grid.time_s[:-step]
    change = np.where(np.abs(span - PART_S) < CELL_S / 2, (even[step:] - even[:-step]) / PART_S, np.nan)
    rows = np.arange(len(change) - step * (PARTS - 1))[:, None] + step * np.arange(PARTS)
    parts = change[rows]
    alike = np.isfinite(parts).all(axis=1) & (np.abs(np.sign(parts).sum(axis=1)) == PARTS)
    return float(np.abs(parts[alike]).min(axis=1).max(initial=0.0))
