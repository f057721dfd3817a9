"""Sensors that die or freeze: one wheel's that stands still while the others' move, a speed while the wheels turn, and noisy signals that
repeat one value for long.

A sensor that is dead takes its wheel's part out of every motion: with one of four deflections frozen at half time a height came out 10 %
low, and a roll gradient 20 %, at four to five standard deviations.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import CELL_S, BoolArray, Grid
from parsers.checks.motion import vehicle_speed
from parsers.checks.repeating import REPEATING, repeated
from parsers.checks.wording import show
from parsers.drive import Decision, Signal
from parsers.quantiles import median, medians
from parsers.signals import WHEELS

WINDOW_S = 5.0
PER_WINDOW = round(WINDOW_S / CELL_S)
LEAST_WINDOWS = 4
IDLE = 0.12
"""Spread of a sensor within a window over the middle one of the other wheels' below which it does not move with them: axles
differ by two or three times, and a dead sensor keeps its noise."""
LIVELY = {
    "suspension_deflection": 0.001,
    "suspension_force": 60.0,
    "tire_normal_force": 80.0,
    "wheel_speed": 0.3,
    "accel_z_unsprung": 0.1,
    "accel_z_sprung": 0.1,
}
"""Spread (SI, of cells' means) from which on the other wheels count as moving."""
SHARE = 0.1
"""Of the time in which the others move: one that is idle for longer is left out. Less does little harm."""

BY_THE_BODY = ("suspension_deflection", "suspension_force", "tire_normal_force")
"""What changes as the body is braked and turned."""
SHAKEN = 0.8
"""Spread within a window, m/s², from which on dry friction holds no spring."""
USUALLY = 0.75
"""Quantile of a sensor's spread for a shake that counts as what it shows of itself: the calmer half may be its frozen time."""

MOVING = 3.0
"""m/s."""
SPEEDS = ("speed", "gps_speed_2d", "gps_speed_3d")


def frozen(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """Channels that are idle for part of the drive, left out or (where it is short) named."""
    decisions: list[Decision] = []
    for kind, least in LIVELY.items():
        wheels = {wheel: f"{kind}_{wheel}" for wheel in WHEELS if f"{kind}_{wheel}" in signals}
        if len(wheels) == len(WHEELS):
            decisions += _idle_wheels(grid, list(wheels.values()), least) or _idle_all(
                grid, list(wheels.values()), least
            )
    decisions += _idle_speeds(grid)
    speed = vehicle_speed(grid)
    if speed is not None:
        for name in REPEATING:
            held = repeated(signals[name], grid, np.abs(speed) > MOVING) if name in signals else None
            if held is not None:
                decisions.append(_said(name, held.found, held.since_s, held.share, held.evidence))
    return decisions


def _spreads(column: FloatArray) -> FloatArray:
    """(windows,) standard deviation within each; NaN where a window is not whole."""
    count = len(column) // PER_WINDOW
    return np.asarray(np.std(column[: count * PER_WINDOW].reshape(count, PER_WINDOW), axis=1))


def _idle_wheels(grid: Grid, names: list[str], least: float) -> list[Decision]:
    """Wheels' sensors that stand still while those of the others move."""
    columns = [grid.get(name) for name in names]
    spread = np.array([_spreads(each) for each in columns if each is not None])
    decisions = []
    for number, name in enumerate(names):
        others = medians(np.delete(spread, number, axis=0))
        decisions += _idle(grid, name, spread[number], others, least, "the other wheels")
    return decisions


def _idle_all(grid: Grid, names: list[str], least: float) -> list[Decision]:
    """Wheels' sensors that all stand still at once while the body is braked and turned as hard as when they moved."""
    felt = [each for axis in "xy" if (each := grid.get(f"accel_{axis}")) is not None]
    if not felt or not names[0].startswith(BY_THE_BODY):
        return []
    shaken = np.sqrt(np.sum([_spreads(each) ** 2 for each in felt], axis=0))
    lively = shaken >= SHAKEN
    spread = np.array([_spreads(each) for name in names if (each := grid.get(name)) is not None])
    usual = np.full(len(names), np.nan)
    for number, own in enumerate(spread):
        there = lively & np.isfinite(own)
        if np.count_nonzero(there) >= 2 * LEAST_WINDOWS:
            # of a sensor that froze at half time, what it showed before
            usual[number] = float(np.quantile(own[there] / shaken[there], USUALLY))
    if not np.isfinite(usual).all():
        return []
    found = [
        _idle(grid, name, own, np.where(lively, share * shaken, np.nan), least, "the body")
        for name, own, share in zip(names, spread, usual, strict=True)
    ]
    # a single one was looked for among its like
    return [each for one in found for each in one] if all(found) else []


def _idle_speeds(grid: Grid) -> list[Decision]:
    """Speeds of the vehicle that stand still while the wheels' change."""
    wheels = [each for wheel in WHEELS if (each := grid.get(f"wheel_speed_{wheel}")) is not None]
    if len(wheels) < 2:
        return []
    turning = medians(np.array([_spreads(each) for each in wheels]))
    decisions = []
    for name in SPEEDS:
        if (column := grid.get(name)) is not None:
            decisions += _idle(grid, name, _spreads(column), turning, LIVELY["wheel_speed"], "the wheels")
    return decisions


def _idle(
    grid: Grid, name: str, own: FloatArray, others: FloatArray, least: float, who: str
) -> list[Decision]:
    """A sensor whose spread (windows,) stays far below that of others where these move."""
    lively = np.isfinite(others) & (others >= least) & np.isfinite(own)
    idle = lively & (own < IDLE * others)
    if np.count_nonzero(idle) < LEAST_WINDOWS or not _together(idle[lively]):
        return []
    share = float(np.mean(idle[lively]))
    since = grid.time_s[np.flatnonzero(idle)[0] * PER_WINDOW] - 0.5 * CELL_S
    rest, moving = median(own[idle]), median(others[idle])
    # the rounding of a mean is no motion
    rest = rest if rest > 1e-9 * moving else 0.0
    how = f"{show(name, rest)} against {show(name, moving)}"
    evidence = f"spread within {WINDOW_S:g} s: {how} of {who}, in {np.count_nonzero(idle)} of {np.count_nonzero(lively)} windows with motion"
    return [_said(name, f"does not move with {who}", float(since), share, evidence)]


def _together(idle: BoolArray) -> bool:
    """Whether the idle windows (n,), of those in which the others move, follow each other, but for a few."""
    edges = np.flatnonzero(np.diff(idle, prepend=False, append=False))
    longest = int(np.max(edges[1::2] - edges[::2], initial=0))
    return longest >= max(LEAST_WINDOWS, 0.5 * np.count_nonzero(idle))


def _said(name: str, what: str, since_s: float, share: float, evidence: str) -> Decision:
    out = share >= SHARE
    action = "left out: its sensor is dead, or froze" if out else "left in: it is too short to matter"
    return Decision(name, "range", f"{name} {what} from {since_s:.0f} s on", action, evidence, applied=out)
