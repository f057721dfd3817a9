"""Are the file's tracks those of the vehicle? In a bend the wheels of an axle run at speeds that are a track times the yaw rate apart.

    v_right - v_left = T r + c v + d v² r

with c for radii that differ and d for tyres that squash under the load that goes across (and slip more where it left). A roll angle by
deflections is their difference over the track, and the springs' roll stiffness goes by its square: a track that is stated 10 % off
was in both with no contradiction from anywhere else.
"""

from __future__ import annotations

import math

import numpy as np

from parsers.checks.grid import make_grid
from parsers.checks.motion import smooth, vehicle_speed
from parsers.drive import Drive
from pipelines.prepare.block_slope import block_slopes
from pipelines.prepare.scale_doubt import ScaleDoubt
from pipelines.vehicles.vehicle import Vehicle

AXLES = {"rear": ("wheel_speed_rl", "wheel_speed_rr"), "front": ("wheel_speed_fl", "wheel_speed_fr")}
"""The rear wheels first, which are not steered."""

SLOW, FAST, LATERAL = 2.0, 20.0, 4.0
"""m/s between which wheels are looked at, and m/s² of v r up to which: below tyres grip alike."""

LEAST_RATE = 0.015
"""rad/s, rms of the yaw rate beside the other columns: below it next to nothing is turned."""

USUAL, SURE = 0.07, 3.5
"""Share of the file's, and standard deviations, that tracks by wheels must be off by: slips of driven axles are worth up to 3 %."""

SPREAD, SCALE = 0.015, 0.008
"""What one axle's may be off by beside the blocks' scatter, and the yaw rate's own scale."""

NO_TRACK = (0.6, 1.6)
"""Shares of the file's track beyond which the wheels' speeds show no bends: all alike, or of another unit."""

STIFFNESS = ("roll_stiffness_nmprad",)
"""What goes by the track's square, whatever shows the roll."""


def hanging_on_it(drive: Drive) -> tuple[str, ...]:
    """What goes by the track: a roll gradient, where the roll is that of the deflections."""
    by_deflections = "roll" not in drive.signals and "suspension_deflection_fl" in drive.signals
    return ("roll_gradient_degpg",) if by_deflections else ()


def track_by_wheels(drive: Drive, axle: str) -> tuple[float, float] | None:
    """An axle's track by the log, m, and its standard deviation; None where the log does not tell."""
    left, right = AXLES[axle]
    needed = (left, right, "yaw_rate")
    if not all(name in drive.signals and len(drive.signals[name].values) for name in needed):
        return None
    every = ("speed", "yaw_rate", *(name for pair in AXLES.values() for name in pair))
    beside = {n: s for n, s in drive.signals.items() if n in every and len(s.values)}
    grid = make_grid(beside)
    speed, yaw = vehicle_speed(grid), grid.get("yaw_rate")
    left_speed, right_speed = grid.get(left), grid.get(right)
    if speed is None or yaw is None or left_speed is None or right_speed is None:
        return None
    v, r, apart = smooth(speed), smooth(yaw), smooth(right_speed - left_speed)
    with np.errstate(invalid="ignore"):
        used = (v > SLOW) & (v < FAST) & (np.abs(v * r) < LATERAL)
    found = block_slopes(np.where(used, r, np.nan), (apart,), np.column_stack([v, v * v * r]), LEAST_RATE)
    return None if found is None else (found.values[0], found.std)


def track_doubt(drive: Drive, vehicle: Vehicle) -> ScaleDoubt | None:
    """That the wheels show other tracks than the vehicle file states; None where they do not, or nothing is stated.

    Both axles together: a file has both right, or its author took both from the same place.
    """
    shares: list[tuple[float, float, str]] = []
    for axle in AXLES:
        stated = vehicle.get(f"track_{axle}_m")
        told = track_by_wheels(drive, axle) if stated is not None else None
        if stated is not None and told is not None and NO_TRACK[0] < told[0] / stated.value < NO_TRACK[1]:
            spread = math.hypot(told[1], stated.std) / stated.value
            shares.append((told[0] / stated.value, math.hypot(spread, SPREAD), axle))
    if not shares:
        return None
    weights = np.array([spread**-2 for _, spread, _ in shares])
    share = float(weights @ np.array([each for each, _, _ in shares]) / weights.sum())
    # the yaw rate's scale is in both
    spread = math.hypot(weights.sum() ** -0.5, SCALE)
    if abs(share - 1) < max(USUAL, SURE * spread):
        return None
    whose = " and ".join(axle for _, _, axle in shares)
    return ScaleDoubt(
        abs(share - 1),
        f"the {whose} track is {share:.2f} of the vehicle file's by the wheels' speeds in bends",
        f"{share:.3f} ± {spread:.3f} of the file's; by axle "
        + ", ".join(f"{axle} {each:.3f} ± {own:.3f}" for each, own, axle in shares),
        AXLES[shares[0][2]][0],
        "rolling",
    )
