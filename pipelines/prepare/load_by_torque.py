"""Does the mass that torques move change from leg to leg? A leg is what is driven between two rests.

    f_x = (T_d - T_b) / (m R) + c_i + d v² + e f_y² + l T'

The accelerometer's specific force holds gravity's part, so that grades drop out. Wind, offsets and slopes are in the c of each leg, and
delays in l: what is left is the slope of f_x on the torques, 1 / (m R), to a few thousandths a leg. A torque's scale is open, but the same
all along; brakes that fade, or an engine that warms up, change one of two torques: both have to show a change of load.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parsers.checks.grid import CELL_S, BoolArray, Grid, make_grid
from parsers.checks.motion import smooth, vehicle_speed
from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.prepare.block_slope import BlockSlopes, block_slopes
from pipelines.prepare.load_change import LoadStep
from pipelines.prepare.spans import runs
from pipelines.prepare.steps import Levels, StepFit, fit_steps, make_levels, steps_beyond_doubt
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

BRAKES = ("brake_torque", "brake_pressure")
BY_WHEEL = tuple(f"{kind}_torque_{wheel}" for kind in ("drive", "brake") for wheel in WHEELS)
NAMES = (
    "accel_x", "accel_y", "speed", *(f"wheel_speed_{wheel}" for wheel in WHEELS), "drive_torque", *BRAKES, *BY_WHEEL,
)  # fmt: skip
STILL, STOP_S = 0.15, 4.0
"""m/s, and how long a stop is that somebody could get in at."""
MOVES, BENDS = 3.0, 3.0
"""m/s from which wheel speeds are fine; m/s² of lateral acceleration up to which tyres drag by its square."""
PULLS = 0.3
"""m/s², rms of what torques give in a leg that tells."""
TRUST = 0.01
"""What a leg's torque may be off by without any change of load, beside its noise: gears and pads. Drives of one load scatter by 0.005."""
LEAST = 0.04
"""Of the mass."""
AGREES = 0.5
"""Share of the change that driving and braking each have to show."""
SIZE = 0.1
"""What is open of the change in kg: the torque's scale and the wheel's radius."""
USUAL_RADIUS = 0.32
NO_CHANGE: tuple[LoadStep, ...] = ()


@dataclass(frozen=True)
class _Leg:
    """after_s, before_s: from where to where it is driven. whole, driven, braked: slopes of f_x on what all torques, and each of both,
    give by the whole drive's fit; None where the leg does not tell."""

    after_s: float
    before_s: float
    whole: BlockSlopes
    driven: BlockSlopes | None
    braked: BlockSlopes | None


def _torque(grid: Grid, kind: str) -> FloatArray | None:
    """Of all wheels, N·m."""
    parts = [grid.get(f"{kind}_torque_{wheel}") for wheel in WHEELS]
    if all(part is not None for part in parts):
        return np.asarray(sum(part for part in parts if part is not None))
    return grid.get(f"{kind}_torque")


def _between_rests(speed: FloatArray) -> list[tuple[int, int]]:
    """First row and row past the last of every leg."""
    still = np.nan_to_num(np.abs(speed), nan=math.inf) < STILL
    stops = [(a, b) for a, b in runs(still) if (b - a) * CELL_S >= STOP_S]
    firsts = [0, *(b for _, b in stops)]
    return list(zip(firsts, [*(a for a, _ in stops), len(speed)], strict=True))


@dataclass(frozen=True)
class _Balance:
    """Columns (n,): f_x, what each torque gives of it by the whole drive, and what else is in it (n, k). mass_radius: m R of the drive, kg m."""

    felt: FloatArray
    given: tuple[FloatArray, ...]
    others: FloatArray
    mass_radius: float


def _balance(grid: Grid, speed: FloatArray, drive: FloatArray) -> _Balance | None:
    """The whole drive's longitudinal balance; None where too little is there, or torques do not move the vehicle."""
    along, across = grid.get("accel_x"), grid.get("accel_y")
    if along is None:
        return None
    felt = smooth(along)
    side = np.zeros(len(felt)) if across is None else smooth(across)
    brakes = next((b for b in (_torque(grid, "brake"), grid.get("brake_pressure")) if b is not None), None)
    torques = [smooth(column) for column in (drive, brakes) if column is not None]
    others = np.column_stack([(speed / 20) ** 2, side**2])
    used: BoolArray = (np.abs(speed) > MOVES) & ~(np.abs(side) > BENDS)
    if brakes is None:
        # a brake that is not measured: only where the engine pulls is it surely off
        used &= torques[0] > 0.1 * float(np.nanquantile(torques[0], 0.98))
    table = np.column_stack([*torques, np.ones(len(felt)), others])
    used &= np.isfinite(table).all(axis=1) & np.isfinite(felt)
    if np.count_nonzero(used) < 10 * table.shape[1]:
        return None
    size = np.sqrt((table[used] ** 2).mean(axis=0))
    if not (np.isfinite(size).all() and (size[: len(torques)] > 0).all()):
        return None
    size = np.maximum(size, 1e-12)
    slopes = np.linalg.lstsq(table[used] / size, felt[used], rcond=None)[0] / size
    if not slopes[0] > 0:
        return None
    given = tuple(
        np.where(used, slope * torque, np.nan) for slope, torque in zip(slopes, torques, strict=False)
    )
    late = grid.rate(np.sum(given, axis=0))
    return _Balance(felt, given, np.column_stack([others, late]), 1 / float(slopes[0]))


def _legs(grid: Grid, speed: FloatArray, balance: _Balance) -> list[_Leg]:
    """The legs that tell a mass."""
    whole, found = np.sum(balance.given, axis=0), list[_Leg]()
    for a, b in _between_rests(speed):
        part = slice(a, b)
        felt, others = balance.felt[part], balance.others[part]
        slope = block_slopes(whole[part], (felt,), others, PULLS) if b > a else None
        if slope is None or not slope.values[0] > 0:
            continue
        apart: list[BlockSlopes | None] = [None, None]
        for k, own in enumerate(balance.given if len(balance.given) == 2 else ()):
            beside = np.column_stack([others, balance.given[1 - k][part]])
            apart[k] = block_slopes(own[part], (felt,), beside, PULLS / 2)
        found.append(_Leg(float(grid.time_s[a]), float(grid.time_s[b - 1]), slope, apart[0], apart[1]))
    return found


def _levels(slopes: Sequence[BlockSlopes]) -> Levels:
    """Masses over that of the whole drive."""
    mass = np.array([1 / slope.values[0] for slope in slopes])
    std = np.hypot(TRUST, mass * [slope.std / slope.values[0] for slope in slopes])
    rms = float(np.sqrt(np.mean(std**2)))
    return make_levels(mass[:, None], np.arange(len(mass)), np.diag(std**2), np.zeros((len(mass), 0)), rms, 1)


def _shown(slopes: Sequence[BlockSlopes | None], fits: Sequence[StepFit]) -> bool:
    """Whether one torque by itself shows each of the steps, where it can."""
    there = [k for k, slope in enumerate(slopes) if slope is not None and slope.values[0] > 0]
    first = np.searchsorted(there, [fit.first for fit in fits])
    bounds = [0, *first.tolist(), len(there)]
    if any(b <= a for a, b in itertools.pairwise(bounds)):
        # no leg with this torque on one side of a step
        return False
    again = fit_steps(_levels([s for k in there if (s := slopes[k]) is not None]), first.tolist())
    return all(
        a.total * np.sign(fit.total) > AGREES * abs(fit.total) for a, fit in zip(again, fits, strict=True)
    )


def changes_by_torque(drive: Drive, vehicle: Vehicle) -> tuple[LoadStep, ...]:
    """The changes of load between legs, in the order of time; none without a drive torque, or where it does not tell."""
    signals = {n: drive.signals[n] for n in NAMES if n in drive.signals and len(drive.signals[n].values)}
    grid = make_grid(signals)
    speed, pulled = vehicle_speed(grid), _torque(grid, "drive")
    balance = None if speed is None or pulled is None else _balance(grid, speed, pulled)
    legs = [] if balance is None or speed is None else _legs(grid, speed, balance)
    if balance is None or len(legs) < 2:
        return NO_CHANGE
    fits = steps_beyond_doubt(_levels([leg.whole for leg in legs]), LEAST, lambda _: True)
    if fits and len(balance.given) == 2:
        both = ([leg.driven for leg in legs], [leg.braked for leg in legs])
        if not all(_shown(slopes, fits) for slopes in both):
            return NO_CHANGE
    radius = vehicle.get("wheel_radius_m")
    mass = balance.mass_radius / (USUAL_RADIUS if radius is None else radius.value)
    return tuple(_told(fit, legs, mass, len(balance.given) == 2) for fit in fits)


def _told(fit: StepFit, legs: Sequence[_Leg], mass: float, braked: bool) -> LoadStep:
    """A step in kg; where it lies torques do not tell."""
    return LoadStep(
        after_s=legs[fit.first - 1].before_s,
        before_s=legs[fit.first].after_s,
        change_kg=fit.total * mass,
        std_kg=mass * math.hypot(fit.std, SIZE * fit.total),
        rear=None,
        left=None,
        source="drive and brake torques" if braked else "drive torque",
    )
