"""An inertial unit that leans by more than a bracket does: its readings are turned until it stands level.

A unit that leans by an angle reads gravity's part along and across, its vertical axis lacks the cosine, and its gyros mix: 12 degrees
are 2 m/s², 2 % and a fifth of the yaw rate in roll. Taken for an offset it puts the CG's place off by a tenth of the height. What leans
and what has an offset differ in the vertical axis: a level unit with an offset along still reads all of gravity there.

Where the mean of the whole reading points, at rest and on the move, is turned upright by the shortest way; which way the unit looks
round the vertical axis is not changed. What a road slopes by in the mean is left to the estimators, as a unit's usual askewness.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from parsers.checks.grid import make_grid
from parsers.checks.leaning_units import LEANS, Reading, readings
from parsers.checks.motion import vehicle_speed
from parsers.checks.offsets import standing
from parsers.drive import Decision, Drive, Signal
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

LEAST_DEG = 4.5
"""Less is within what estimators take a unit to be askew by, and hardly shows in the vertical axis."""
MOST_DEG = 30.0
"""More is a unit that lies on its side, or another fault."""
TOLD = 0.1
"""m/s² that the vertical axis must lack or not for lean and offset to be told apart; below it, it leans: offsets are not that large."""
OFFSET = 0.25
"""Of what leaning would take from the vertical axis: one that lacks less than that share does not lean."""

ACCELS, GYROS = ("accel_x", "accel_y", "accel_z"), ("roll_rate", "pitch_rate", "yaw_rate")
SPEEDS = ("speed", "gps_speed_2d", "gps_speed_3d", "wheel_speed_rl", "wheel_speed_rr")
STATED = ("imu_roll_deg", "imu_pitch_deg")


def _triad(drive: Drive, names: tuple[str, str, str]) -> tuple[Signal, Signal, Signal] | None:
    """Three axes of one unit: sampled together, or None."""
    if not all(name in drive.signals for name in names):
        return None
    x, y, z = (drive.signals[name] for name in names)
    same = all(np.array_equal(x.time_ns, other.time_ns) for other in (y, z))
    return (x, y, z) if same and len(x.values) else None


def _upright(found: Mapping[str, Reading], at_rest: float) -> FloatArray | None:
    """(3,) where gravity's reading points in the unit's axes; None for a unit that does not lean. at_rest: of the vertical axis, m/s²."""
    x, y = (
        0.5 * (found[name].rest + found[name].moving) if name in found else 0.0
        for name in ("accel_x", "accel_y")
    )
    flat = math.hypot(x, y) / GRAVITY
    if not math.sin(math.radians(LEAST_DEG)) <= flat <= math.sin(math.radians(MOST_DEG)):
        return None
    up = math.sqrt(1 - flat**2)
    lacks = GRAVITY * (1 - up)
    if lacks > TOLD and GRAVITY - at_rest < OFFSET * lacks:
        return None
    return np.array([x / GRAVITY, y / GRAVITY, up])


def turned_up(gravity: FloatArray) -> FloatArray:
    """(3, 3) the shortest turn that brings a unit vector (3,) to (0, 0, 1)."""
    x, y, z = gravity
    axis = np.array([y, -x, 0.0])
    cross = np.array([[0.0, 0.0, axis[1]], [0.0, 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1 + z))


def with_level_unit(drive: Drive, vehicle: Vehicle, *, fix: bool = True) -> Drive:
    """The drive with its inertial unit's axes turned level where it leans, and that in its record in place of what the import said.

    As it is where the vehicle file says what the unit shows on level ground, where the three accelerations are not of one unit, and
    where `fix` is False.
    """
    if not fix or any(key in vehicle.sensors for key in STATED):
        return drive
    accels = _triad(drive, ACCELS)
    if accels is None:
        return drive
    grid = make_grid({n: drive.signals[n] for n in (*ACCELS, "yaw_rate", *SPEEDS) if n in drive.signals})
    speed = vehicle_speed(grid)
    still = standing(grid, speed)
    found = readings(grid, speed, still)
    column = grid.get("accel_z")
    if not found or column is None:
        return drive
    rest = column[still & np.isfinite(column)]
    gravity = _upright(found, float(np.median(rest))) if len(rest) else None
    if gravity is None:
        return drive
    turn = turned_up(gravity)
    signals = dict(drive.signals)
    gyros = _triad(drive, GYROS)
    for names, triad in ((ACCELS, accels), (GYROS, gyros)):
        if triad is not None:
            level = turn @ np.stack([signal.values for signal in triad])
            signals |= {n: replace(s, values=v) for n, s, v in zip(names, triad, level, strict=True)}
    kept = tuple(d for d in drive.record.decisions if LEANS not in d.found)
    said = (*kept, _decision(gravity, found, rates=gyros is not None))
    return replace(drive, signals=signals, record=replace(drive.record, decisions=said))


def _decision(gravity: FloatArray, found: Mapping[str, Reading], *, rates: bool) -> Decision:
    pitch, roll = (math.degrees(math.asin(part)) for part in (-gravity[0], gravity[1]))
    ways = [
        f"{abs(angle):.1f}° {way[angle > 0]}"
        for name, angle, way in (
            ("accel_x", pitch, ("nose up", "nose down")), ("accel_y", roll, ("left side down", "left side up"))
        )
        if name in found
    ]  # fmt: skip
    evidence = "; ".join(
        f"{name} reads {r.rest:.2f} m/s² at rest ({r.rest_s:.0f} s) and keeps {r.moving:.2f} on the move"
        for name, r in sorted(found.items())
    )
    alone = "" if rates else "; its rates are not all there, and stay as they are"
    return Decision(
        signal="accel_x" if "accel_x" in found else "accel_y",
        kind="mount",
        found=f"the inertial unit leans by {' and '.join(ways)}",
        action=f"turned level{alone}; to the estimators it is as askew as any other (imu_pitch_deg and imu_roll_deg state what it shows)",
        evidence=evidence,
        applied=True,
    )
