"""Wheel torques that hold the brakes' part already, beside a brake torque or pressure: braking would be counted twice.

"WheelTorque" is what drives the wheel in one log and what is left of that and the brakes in another. With the brakes off both are the same, and tell how
the torque goes with the acceleration; with the brakes on, a torque that still goes so is the net one, while one that drives alone falls short of it
by the brakes' torque. A motor that recuperates brakes as well, and looks alike: but it makes the brakes' own torque small, and does not reach 4 m/s².
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray, Grid
from parsers.checks.motion import seconds, smooth, vehicle_speed
from parsers.checks.pedals import change_of_speed
from parsers.drive import Decision, Signal
from parsers.quantiles import median, quantile
from parsers.signals import WHEELS

_MOVES = 2.0
"""m/s: slower than that brakes hold what they must."""
_RELEASED, _PRESSED = 0.03, 0.25
"""Share of the drive's hardest braking below which the brakes are off, and from which on they surely are on."""
_SLOWS, _HARD = 1.5, 4.0
"""m/s² of braking from which on it tells something, and that no motor's recuperation reaches."""
_LEAST_OFF_S, _LEAST_ON_S, _LEAST_HARD_S = 10.0, 2.0, 1.0
_FOLLOWS = 0.85
"""Least correlation, with the brakes off, of the torque with what the acceleration asks for."""
_WHOLE = (0.75, 1.3)
"""Torque over what the braking asks for, between which it is all of it."""
_ADDS = 0.3
"""Share of the logged brake torque that a net torque may be short by: the two agree but for scales and delays."""


@dataclass(frozen=True)
class _Braking:
    """What the brakes' rows say. whole: torque over what the acceleration asks for; adds: the share of the logged brake torque that is missing in
    it, NaN for a pressure; on_s, hard_s: how long."""

    whole: float
    adds: float
    on_s: float
    hard_s: float


def net_torque(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """The brakes left out where the drive torque surely holds them, a doubt where it likely does; nothing where both add up, or nothing tells."""
    drives, brakes = _named(signals, "drive_torque"), _named(signals, "brake_torque")
    pressed = brakes or [name for name in ("brake_pressure",) if name in signals]
    if not drives or not pressed:
        return []
    found = _braking(grid, _sum(grid, drives), _sum(grid, pressed), torque=bool(brakes))
    if found is None or not _WHOLE[0] < found.whole < _WHOLE[1] or found.adds > _ADDS:
        return []
    sure = found.hard_s >= _LEAST_HARD_S or bool(np.isfinite(found.adds))
    text = (
        f"{drives[0]} is that of the brakes as well"
        if sure
        else f"{drives[0]} may be that of the brakes as well"
    )
    evidence = f"{found.whole:.2f} times what the braking asks for over {found.on_s:.0f} s, of which brakes that it does not hold would leave next to nothing"
    action = (
        f"left out: braking would count twice with it (to keep it instead: [signals.{drives[0]}] with ignore = true in a mapping file)"
        if sure
        else f"left as it is: a motor may have braked; if not, leave out {' and '.join(pressed[:1])} in a mapping file (ignore = true)"
    )
    left = [*brakes, *(name for name in ("brake_pressure",) if name in signals)] if sure else drives[:1]
    return [Decision(name, "range", text, action, evidence, applied=sure) for name in left]


def _named(signals: Mapping[str, Signal], kind: str) -> list[str]:
    """The sum over the wheels, else the wheels that are there: all, or an axle's two."""
    if kind in signals:
        return [kind]
    wheels = [f"{kind}_{wheel}" for wheel in WHEELS if f"{kind}_{wheel}" in signals]
    return wheels if len(wheels) in (2, 4) else []


def _sum(grid: Grid, names: list[str]) -> FloatArray:
    return np.asarray(np.sum([grid.columns[name] for name in names], axis=0))


def _braking(grid: Grid, drive: FloatArray, brake: FloatArray, *, torque: bool) -> _Braking | None:
    """What braking says, None where the drive does not tell. drive, brake: (n,); torque: whether `brake` is one, of either sign."""
    felt, speed = grid.get("accel_x"), vehicle_speed(grid)
    # what is felt holds the grade, as torques do; the change of speed does not
    felt = smooth(felt) if felt is not None else change_of_speed(grid)
    if felt is None or speed is None:
        return None
    drive, brake = smooth(drive), smooth(brake)
    there = (
        np.isfinite(felt)
        & np.isfinite(speed)
        & np.isfinite(drive)
        & np.isfinite(brake)
        & (np.abs(speed) > _MOVES)
    )
    if seconds(there) < _LEAST_OFF_S + _LEAST_ON_S:
        return None
    idle = there & (felt > -_SLOWS / 3)
    if not idle.any():
        return None
    pushed = np.abs(brake - median(brake[idle]))
    most = quantile(pushed[there], 0.995)
    off, on = there & (pushed < _RELEASED * most), there & (pushed > _PRESSED * most) & (felt < -_SLOWS)
    if seconds(off) < _LEAST_OFF_S or seconds(on) < _LEAST_ON_S:
        return None
    asked = _asked(felt, speed, drive, off)
    if asked is None:
        return None
    on_drive, on_asked, on_pushed = drive[on], asked[on], pushed[on]
    weight = float(on_asked @ on_asked)
    if not weight > 0:
        return None
    short = (on_drive - on_asked) * -np.sign(on_asked)
    adds = abs(float(short @ on_pushed) / float(on_pushed @ on_pushed)) if torque else float("nan")
    hard_s = seconds(on & (felt < -_HARD))
    return _Braking(float(on_drive @ on_asked) / weight, adds, seconds(on), hard_s)


def _asked(felt: FloatArray, speed: FloatArray, drive: FloatArray, off: BoolArray) -> FloatArray | None:
    """(n,) torque that the acceleration asks for, by what it was with the brakes off; None where that does not tell."""
    columns = np.stack([felt, np.ones(len(felt)), speed * speed], axis=1)
    fitted, *_ = np.linalg.lstsq(columns[off], drive[off], rcond=None)
    asked = np.asarray(columns @ fitted)
    if not (np.std(drive[off]) > 0 and np.std(asked[off]) > 0):
        return None
    follows = float(np.corrcoef(asked[off], drive[off])[0, 1])
    # without the part of the air, which a wide range of speeds alone would make
    return (
        asked
        if follows >= _FOLLOWS and abs(fitted[0]) * float(np.std(felt[off])) > 0.3 * float(np.std(drive[off]))
        else None
    )
