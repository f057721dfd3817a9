"""Accelerations that hold no gravity: found by speed, yaw rate and the body's lean, and given it back.

An accelerometer in a leaning body reads f_y = v r + v_y' + g sin(roll) and f_x = v' - r v_y - g sin(pitch). Simulators, and
units that level their output, often log the first terms alone. Taken for what an accelerometer reads they make every moment
arm some 5 to 20 % too large, and nothing else in the log looks odd. So the rest, f_y - v r or f_x - v', is compared with what
gravity would add: its share is 1 or 0, or the log does not tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Set
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from parsers.checks.grid import Grid, make_grid
from parsers.checks.motion import smooth, vehicle_speed
from parsers.checks.springs import DEFLECTIONS
from parsers.drive import Decision, Drive, Signal
from pipelines.models.roll import GRAVITY
from pipelines.prepare.block_slope import block_slopes
from pipelines.prepare.decided import decided
from pipelines.prepare.gravity_by_gyro import lean_by_gyro, share_by_gyro
from pipelines.prepare.roll_angle import TYPICAL_TRACK
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

BETWEEN = 0.5
"""Share of gravity between none and all of it."""

NONE = 0.3
"""Share up to which it may be none: sideslip in hard bends takes half of it away in places."""

NOTHING = 0.12
"""The same where nothing but the springs shows the lean, as roads that bank take as much away: what a level unit reads has none at all."""

SURE = 2.5
"""Standard deviations from BETWEEN that a share must be off."""

SCALES = 0.01
"""By what the scales of accelerometer, speed and gyro may differ: it looks like gravity's share, as a body leans with the load."""

SLOW_MPS = (10.0, 16.0)
"""Bends below these speeds are banked by little: in them a true accelerometer shows gravity's part, where fast roads' bank cancels the lean."""

UNSURE = 0.2
"""Standard deviation of a share by the gyro from which on it does not tell."""

LEAST_MPS = 5.0
LEAST_TILT = 0.012
"""rad, rms: below it gravity's share is no more than offsets and noise."""

TYPICAL_WHEELBASE = 2.7
MIN_SAMPLES = 2
FARTHEST_NS = 500_000_000
"""Between two samples of a deflection that are further apart nobody knows what the wheel did."""
GRAVITY_ADDED = "gravity's part added"
LACKS = "has no part of gravity in it as the body leans: it is no accelerometer's reading, or its scale or delay is wrong"
NAMES = (
    "accel_y",
    "accel_x",
    "yaw_rate",
    "roll_rate",
    "roll",
    "pitch",
    "speed",
    "gps_speed_2d",
    *DEFLECTIONS,
)


@dataclass(frozen=True)
class Share:
    """Of gravity in an acceleration: 1 where all of it is there. std: with what differing scales are worth."""

    value: float
    std: float
    seconds: float

    @property
    def missing(self) -> bool:
        """Whether it is surely nearer to none than to all of it."""
        return abs(self.value) < NONE and self.value + SURE * self.std < BETWEEN


def tilt_of(signals: Mapping[str, Signal], axis: str, vehicle: Vehicle) -> Signal | None:
    """Roll or pitch of the body in rad: measured, else by the springs."""
    measured = signals.get(axis)
    if measured is not None and len(measured.values):
        return measured
    wheels = [signals.get(name) for name in DEFLECTIONS]
    first = wheels[0]
    if first is None or any(w is None or len(w.values) < MIN_SAMPLES for w in wheels):
        return None
    fl, fr, rl, rr = (_at(first.time_ns, w) for w in wheels if w is not None)
    tracks = [vehicle.get(f"track_{axle}_m") for axle in ("front", "rear")]
    known = [t.value for t in tracks if t is not None]
    length = vehicle.get("wheelbase_m")
    if axis == "roll":
        values = (fr + rr - fl - rl) / (2 * (float(np.mean(known)) if known else TYPICAL_TRACK[0]))
    else:
        values = (fl + fr - rl - rr) / (2 * (TYPICAL_WHEELBASE if length is None else length.value))
    there = np.isfinite(values)
    if int(there.sum()) < MIN_SAMPLES:
        return None
    level = values[there] - float(np.median(values[there]))
    return Signal(axis, first.time_ns[there], level, "derived: suspension deflections")


def _at(time_ns: IntArray, wheel: Signal) -> FloatArray:
    """A wheel's deflection at stamps of another one, whose messages come at their own moments; NaN where it is missing."""
    if np.array_equal(wheel.time_ns, time_ns):
        return wheel.values
    after = np.clip(np.searchsorted(wheel.time_ns, time_ns), 1, len(wheel.time_ns) - 1)
    before_ns, after_ns = wheel.time_ns[after - 1], wheel.time_ns[after]
    held = (before_ns <= time_ns) & (time_ns <= after_ns) & (after_ns - before_ns < FARTHEST_NS)
    found = np.interp(time_ns.astype(np.float64), wheel.time_ns.astype(np.float64), wheel.values)
    return np.where(held, found, np.nan)


def share_of(rest: FloatArray, gravity: FloatArray, load: FloatArray, others: FloatArray) -> Share | None:
    """Slope of `rest` (n,) on what gravity adds (n,), beside a constant and `others` (n, k); from whole blocks' scatter.

    load: (n,) the acceleration itself, by which differing scales would look like gravity. None where there is too little.
    """
    found = block_slopes(gravity, (rest, load), others, LEAST_TILT * GRAVITY)
    if found is None:
        return None
    value, swing = found.values
    return Share(value, math.hypot(found.std, SCALES * abs(swing)), found.seconds)


@dataclass(frozen=True)
class _Rests:
    """What accelerations hold beyond the motion in the plane: grid; name -> (axis, sign, rest, load, others) as `share_of` takes them."""

    grid: Grid
    of: Mapping[str, tuple[str, float, FloatArray, FloatArray, FloatArray]]


def _rests(drive: Drive, tilts: Mapping[str, Signal | None], fastest: float) -> _Rests | None:
    """None where the drive has no yaw rate, speed or acceleration. fastest: m/s that are looked at."""
    known = {n: drive.signals[n] for n in NAMES if n in drive.signals and len(drive.signals[n].values)}
    if "yaw_rate" not in known or not {"accel_x", "accel_y"} & known.keys():
        return None
    grid = make_grid(known | {axis: tilt for axis, tilt in tilts.items() if tilt is not None})
    speed, yaw = vehicle_speed(grid), grid.get("yaw_rate")
    if speed is None or yaw is None:
        return None
    turning, change = smooth(speed * yaw), grid.rate(smooth(speed))
    moving = (speed > LEAST_MPS) & (speed < fastest)
    # the sideslip lags behind the steering: its change v_y' has a part in step with the yaw rate's second derivative, which in
    # steady weaving is in step with the lean as well, and then the log does not tell gravity's share
    turn = grid.rate(smooth(yaw))
    sums = {
        "accel_y": ("roll", 1.0, turning, np.column_stack([grid.rate(turning), turn, grid.rate(turn)])),
        "accel_x": ("pitch", -1.0, change, np.column_stack([smooth(yaw) ** 2, grid.rate(change)])),
    }
    found = {}
    for name, (axis, sign, load, others) in sums.items():
        felt = grid.get(name)
        if felt is not None:
            rest = np.where(moving, smooth(felt) - load, np.nan)
            found[name] = (axis, sign, rest, load, others)
    return _Rests(grid, found)


def shares(drive: Drive, vehicle: Vehicle, fastest: float = math.inf) -> dict[str, tuple[Share, Signal]]:
    """Gravity's share in accel_y and accel_x where the log tells it, and the angle that it was seen by. fastest: m/s that are looked at."""
    tilts = {axis: tilt_of(drive.signals, axis, vehicle) for axis in ("roll", "pitch")}
    rests = _rests(drive, tilts, fastest) if any(tilts.values()) else None
    found = {}
    for name, (axis, sign, rest, load, others) in ({} if rests is None else rests.of).items():
        angle, tilt = rests.grid.get(axis) if rests else None, tilts[axis]
        if angle is None or tilt is None:
            continue
        share = share_of(rest, sign * GRAVITY * np.sin(smooth(angle)), load, others)
        if share is not None:
            found[name] = (share, tilt)
    return found


def turned_share(drive: Drive) -> Share | None:
    """Gravity's share in accel_y by a gyro's roll rate, which turns with the road as well (`gravity_by_gyro`); None where it does not tell."""
    rests = _rests(drive, {}, math.inf)
    if rests is None or "accel_y" not in rests.of:
        return None
    _, _, rest, load, others = rests.of["accel_y"]
    found = share_by_gyro(rests.grid, rest, load, others)
    if found is None:
        return None
    share = Share(found.values[0], math.hypot(found.std, SCALES * abs(found.values[1])), found.seconds)
    return share if share.std < UNSURE else None


def lacks_gravity(drive: Drive, vehicle: Vehicle) -> bool:
    """Whether `accel_y` surely has no part of gravity in it, by its bends or by a gyro."""
    share, _ = shares(drive, vehicle).get("accel_y", (turned_share(drive), None))
    return share is not None and share.missing


def _banked(drive: Drive, vehicle: Vehicle, tilt: Signal) -> tuple[Share, str] | None:
    """Gravity's share where it is there, and where that was seen: by a gyro, else in slow bends. None where it is not, or the log does not tell.

    The springs show the lean against the road, and an accelerometer that against the horizon.
    """
    if not tilt.source.startswith("derived"):
        return None
    turned = turned_share(drive)
    if turned is not None:
        return None if turned.missing else (turned, "by the gyro's roll rate, which turns with the road")
    for fastest in SLOW_MPS:
        found = shares(drive, vehicle, fastest).get("accel_y")
        if found is not None:
            return (found[0], "in slow bends") if found[0].value > BETWEEN else None
    return None


def _leans_with_the_road(drive: Drive, tilt: Signal) -> float | None:
    """By what part of its lean on the springs the body turns against the horizon, where a gyro shows that it is not surely most of it."""
    rests = _rests(drive, {"roll": tilt}, math.inf) if tilt.source.startswith("derived") else None
    angle = None if rests is None else rests.grid.get("roll")
    turned = None if rests is None or angle is None else lean_by_gyro(rests.grid, angle)
    return None if turned is None or turned.values[0] - SURE * turned.std > BETWEEN else turned.values[0]


def _by_springs_alone(drive: Drive, vehicle: Vehicle, tilt: Signal) -> bool:
    """Whether neither the horizon, a gyro nor bends so slow that no road banks for them show gravity's part."""
    by_springs = tilt.source.startswith("derived") and turned_share(drive) is None
    return by_springs and shares(drive, vehicle, SLOW_MPS[0]).get("accel_y") is None


def _left_as_it_is(drive: Drive, vehicle: Vehicle, share: Share, tilt: Signal) -> Decision | None:
    """Why `accel_y` is right although it shows little of gravity, or may be; None where it surely lacks it."""
    banks = (
        "accel_y has little of gravity in it as the body leans on its springs: the road banks into its bends"
    )
    seen = f"{share.value:.2f} ± {share.std:.2f} of it is there"
    long = f"{seen}, over {share.seconds:.0f} s"
    banked = _banked(drive, vehicle, tilt)
    if banked is not None:
        other, where = banked
        evidence = f"{seen}, {other.value:.2f} ± {other.std:.2f} {where}"
        return Decision("accel_y", "choice", banks, "left as it is", evidence, applied=False)
    turns = _leans_with_the_road(drive, tilt) if turned_share(drive) is None else None
    if turns is not None:
        action = f"left as it is: by the gyro the body turns by {max(turns, 0.0):.0%} of that lean"
        return Decision("accel_y", "choice", banks, action, long, applied=False)
    if abs(share.value) > NOTHING and _by_springs_alone(drive, vehicle, tilt):
        found = f"{banks}, or it is no accelerometer's reading"
        action = "left as it is: neither a gyro nor slow bends tell which"
        return Decision("accel_y", "choice", found, action, long, applied=False)
    return None


def with_gravity(drive: Drive, vehicle: Vehicle, *, fix: bool = True, known: Set[str] = frozenset()) -> Drive:
    """The drive with gravity's part added to accelerations that surely lack it, and a decision for each in the record.

    fix=False: only said. known: accelerations that something else is wrong with, of which this tells nothing.
    """
    signals, said = dict(drive.signals), []
    found = shares(drive, vehicle)
    for name, (share, tilt) in found.items():
        if not share.missing or name in known:
            continue
        right = _left_as_it_is(drive, vehicle, share, tilt) if name == "accel_y" else None
        if right is not None:
            said.append(right)
            continue
        seen = f"{share.value:.2f} ± {share.std:.2f} of it is there, over {share.seconds:.0f} s"
        signals[name], decision = _given_back(signals[name], tilt, seen, fix=fix)
        said.append(decision)
    if "accel_y" in signals and "accel_y" not in {*found, *known}:
        signals, said = _told_otherwise(drive, vehicle, found, (signals, said), fix=fix)
    return decided(drive, said, signals)


def _given_back(old: Signal, tilt: Signal, seen: str, *, fix: bool) -> tuple[Signal, Decision]:
    """An acceleration with gravity's part by an angle, or as it was (fix=False), and what is said of it. seen: how it was found."""
    sign = 1.0 if old.name == "accel_y" else -1.0
    angle = np.interp(old.time_ns.astype(np.float64), tilt.time_ns.astype(np.float64), tilt.values)
    by = "the springs' travel" if tilt.source.startswith("derived") else tilt.name
    action = f"{GRAVITY_ADDED}, by {by}" if fix else "left as it is (--no-fix)"
    new = replace(old, values=old.values + sign * GRAVITY * np.sin(angle)) if fix else old
    return new, Decision(old.name, "choice", f"{old.name} {LACKS}", action, seen, applied=fix)


def _told_otherwise(
    drive: Drive,
    vehicle: Vehicle,
    found: Mapping[str, tuple[Share, Signal]],
    so_far: tuple[dict[str, Signal], list[Decision]],
    *,
    fix: bool,
) -> tuple[dict[str, Signal], list[Decision]]:
    """`accel_y`, where its own bends do not tell gravity's share: a gyro does, or the accelerometer across it which lacks it.

    found: the shares that are known; so_far: signals and decisions, which come back with what is found here.
    """
    signals, said = so_far
    tilt, turned, along = tilt_of(drive.signals, "roll", vehicle), turned_share(drive), found.get("accel_x")
    if turned is not None:
        if not turned.missing:
            return so_far
        seen = f"{turned.value:.2f} ± {turned.std:.2f} of it is there by the gyro's roll rate, over {turned.seconds:.0f} s"
    elif along is not None and along[0].missing and not along[1].source.startswith("derived"):
        # one unit levels both or none of them, and bends of one rhythm do not tell
        seen = "accel_x has none, and this drive's bends do not tell"
    else:
        return so_far
    if tilt is None:
        # what a gyro shows of the lean is not that of a steady bend
        action = "left as it is: neither a roll angle nor suspension deflections tell the lean"
        return signals, [
            *said,
            Decision("accel_y", "choice", f"accel_y {LACKS}", action, seen, applied=False),
        ]
    new, decision = _given_back(signals["accel_y"], tilt, seen, fix=fix)
    return {**signals, "accel_y": new}, [*said, decision]
