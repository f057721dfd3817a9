"""Strut forces, specific forces and angular accelerations of one drive as the columns of the balances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from parsers.signals import SUSPENSION_DEFLECTIONS, WHEELS
from pipelines.estimators.base import Need
from pipelines.models.pitch_plane import pitch_acceleration, strut_pitch_moment
from pipelines.models.roll import GRAVITY
from pipelines.models.roll_plane import roll_acceleration, strut_roll_moment
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.results import FloatArray

FORCES: tuple[str, ...] = tuple(f"suspension_force_{w}" for w in WHEELS)
CORNERS: tuple[str, ...] = tuple(f"accel_z_sprung_{w}" for w in WHEELS)
OPTIONAL: tuple[str, ...] = (
    *CORNERS, "accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate", "speed", "brake_pressure", "brake_torque",
    *SUSPENSION_DEFLECTIONS,
)  # fmt: skip
FORCE_NEEDS: tuple[Need, ...] = tuple(Need((name,), "the force of each strut on the body") for name in FORCES)

RATE_A_CUTOFF = 10.0
"""Rows a period of the cutoff: differentiated gyros need a fine grid."""
ROWS_A_CUTOFF = 4.0
BLOCK_S = 4.0
FRICTION_MPS = 0.01
STILL_MPS = 0.5
CALM_MPS2, LEAST_CALM = 1.0, 0.1
BRAKE_PA, BRAKE_NM, BRAKING_MPS2 = 1e5, 60.0, 0.7
"""From where on the brakes are on: pressure, torque, or, with neither, deceleration."""
GYRO_NOISE = 0.003
"""rad/s a sample, of a gyro whose noise the drive does not show at rest."""


@dataclass(frozen=True)
class Planes:
    """Columns (n,) at `rate_hz`, thinned to what the cutoff holds; rows with a hole are not there.

    columns: total, roll_moment, pitch_moment [N, N m about the middle of track and wheelbase], fx, fy, fz, roll_acc,
    pitch_acc, yaw_acc, v2, vyaw; where deflections are there roll_friction, pitch_friction, total_friction [lever times
    sign of the struts' motion], lean and nod [rad]; where rates are, yaw_square and roll_yaw [rad²/s²].
    noise: variance of the noise on roll_acc and pitch_acc. block: which BLOCK_S a row lies in. braking: rows with the
    brakes on. loads: (4,) mean strut forces. how: source of the angular accelerations in words. missing: of fx, fy, fz,
    yaw_acc, v2, vyaw those that stand for a signal that the log has not. drive_rows: rows before holes were left out.
    """

    columns: Mapping[str, FloatArray]
    noise: Mapping[str, float]
    time_s: FloatArray
    block: IntArray
    braking: BoolArray
    loads: FloatArray
    rate_hz: float
    how: Mapping[str, str]
    missing: frozenset[str]
    drive_rows: int

    def first(self, rows: int) -> Planes:
        """The drive's beginning, for how an estimate grew."""
        return replace(
            self, columns={name: c[:rows] for name, c in self.columns.items()}, time_s=self.time_s[:rows],
            block=self.block[:rows], braking=self.braking[:rows],
        )  # fmt: skip


def slope(values: FloatArray, rate_hz: float) -> FloatArray:
    """Time derivative of fourth order, (n,): true to 0.3 % at a fifth of the rate of `RATE_A_CUTOFF`."""
    out = np.gradient(values)
    if len(values) >= 5:
        out[2:-2] = (8 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / 12
    return np.asarray(out * rate_hz)


def _by_segment(prepared: Prepared, values: FloatArray) -> FloatArray:
    out = np.full(len(values), np.nan)
    for s in prepared.segments:
        out[s.start : s.stop] = slope(values[s.start : s.stop], prepared.rate_hz)
    return out


def _there(prepared: Prepared, names: tuple[str, ...]) -> bool:
    """Whether all are there on most rows."""
    columns = prepared.columns
    return all(n in columns and prepared.share_of(columns[n]) > 0.5 for n in names)


def _stack(prepared: Prepared, names: tuple[str, ...]) -> FloatArray:
    return np.column_stack([prepared.columns[n] for n in names])


def _corner_noise(prepared: Prepared, corners: FloatArray) -> float:
    """Variance of one corner accelerometer's noise: a rigid body has three motions, the fourth combination is noise."""
    twist = corners @ np.array([1.0, -1.0, -1.0, 1.0])
    # of steps, so that offsets and a slow twist of the body do not count; so far apart that low-passed noise is independent
    apart = max(1, round(prepared.rate_hz / prepared.cutoff_hz))
    steps = twist[apart:] - twist[:-apart]
    steps = steps[np.isfinite(steps)]
    return float(np.mean(steps**2)) / 8 if len(steps) else 0.0


def _gyro_noise(prepared: Prepared, name: str, rate: FloatArray) -> tuple[float, str]:
    """Variance of the derivative's noise, and where it is known from: at rest, or as usual gyros have it."""
    rest = prepared.standstill & np.isfinite(rate)
    if rest.sum() > 2 * prepared.rate_hz:
        values = rate[rest]
        # the median is blind to the start and the end of a rest
        return float((np.median(np.abs(values - np.median(values))) / 0.6745) ** 2), "noise as at rest"
    own = prepared.raw_rate_hz.get(name, prepared.rate_hz)
    band = prepared.cutoff_hz
    share = min(1.0, 2 * band / max(own, 1e-9))
    return (GYRO_NOISE * 2 * np.pi * band) ** 2 * share / 3, "noise of a usual gyro"


def _angular(
    prepared: Prepared, tracks: tuple[float, float], wheelbase: float
) -> tuple[dict[str, FloatArray], dict[str, float], dict[str, str]]:
    """Roll and pitch acceleration, their noise and source: corner accelerometers, else differentiated gyros."""
    found: dict[str, FloatArray] = {}
    noise: dict[str, float] = {}
    how: dict[str, str] = {}
    if _there(prepared, CORNERS):
        corners = _stack(prepared, CORNERS)
        variance = _corner_noise(prepared, corners)
        found = {
            "roll_acc": roll_acceleration(corners, tracks),
            "pitch_acc": pitch_acceleration(corners, wheelbase),
        }
        noise = {
            "roll_acc": variance * 0.5 * (tracks[0] ** -2 + tracks[1] ** -2),
            "pitch_acc": variance / wheelbase**2,
        }
        words = "four accelerometers on the body over the wheels, (102) and (104); noise from their fourth combination"
        return found, noise, dict.fromkeys(found, words)
    for name in ("roll", "pitch"):
        gyro = f"{name}_rate"
        if _there(prepared, (gyro,)):
            key = f"{name}_acc"
            found[key] = _by_segment(prepared, prepared.columns[gyro])
            noise[key], words = _gyro_noise(prepared, gyro, found[key])
            how[key] = f"{gyro}, differentiated without delay; {words}"
    return found, noise, how


def _from_deflections(
    prepared: Prepared, tracks: tuple[float, float], wheelbase: float
) -> dict[str, FloatArray]:
    """The body's lean and nod; levers times the sign of the struts' motion: what friction does that force sensors do not see."""
    if not _there(prepared, SUSPENSION_DEFLECTIONS):
        return {}
    d = _stack(prepared, SUSPENSION_DEFLECTIONS)
    sign = np.tanh(np.column_stack([_by_segment(prepared, d[:, i]) for i in range(4)]) / FRICTION_MPS)
    return {
        "roll_friction": strut_roll_moment(sign, tracks),
        "pitch_friction": strut_pitch_moment(sign, 1.0),
        "total_friction": sign.sum(axis=1),
        # of the body against its axles, right side down
        "lean": 0.5 * ((d[:, 1] - d[:, 0]) / tracks[0] + (d[:, 3] - d[:, 2]) / tracks[1]),
        # against the line of the hubs, nose down
        "nod": 0.5 * (d[:, 0] + d[:, 1] - d[:, 2] - d[:, 3]) / wheelbase,
    }


def _braking(prepared: Prepared, fx: FloatArray) -> BoolArray:
    for name, limit in (("brake_pressure", BRAKE_PA), ("brake_torque", BRAKE_NM)):
        if _there(prepared, (name,)):
            return np.asarray(np.abs(np.nan_to_num(prepared.columns[name])) > limit)
    return np.asarray(fx < -BRAKING_MPS2)


def _levelled(fz: FloatArray, fx: FloatArray, fy: FloatArray) -> FloatArray:
    """Vertical specific force whose mean on calm rows is gravity: a vehicle does not rise for ever.

    Takes out offset and scale error of the accelerometer. A leaning body turns the cornering force into its own
    vertical, so that only rows without much of it are asked.
    """
    there = np.isfinite(fz) & np.isfinite(fx) & np.isfinite(fy)
    calm = there & (np.hypot(fx, fy) < CALM_MPS2)
    rows = calm if calm.sum() > LEAST_CALM * there.sum() else there
    return fz + (GRAVITY - float(np.mean(fz[rows]))) if rows.any() else np.full(len(fz), GRAVITY)


def collect(prepared: Prepared, tracks: tuple[float, float], wheelbase: float) -> Planes | None:
    """The columns; None where no row holds all of them."""
    n = len(prepared.time_s)
    if not prepared.segments or not _there(prepared, FORCES):
        return None
    forces = _stack(prepared, FORCES)
    found, noise, how = _angular(prepared, tracks, wheelbase)
    missing = set()
    for axis in "xyz":
        name = f"accel_{axis}"
        if _there(prepared, (name,)):
            found[f"f{axis}"] = prepared.columns[name]
        else:
            missing.add(f"f{axis}")
            found[f"f{axis}"] = np.full(n, GRAVITY if axis == "z" else 0.0)
    found["fz"] = _levelled(found["fz"], found["fx"], found["fy"])
    zero = np.zeros(n)
    speed = prepared.columns["speed"] if _there(prepared, ("speed",)) else None
    yaw = prepared.columns["yaw_rate"] if _there(prepared, ("yaw_rate",)) else None
    found["v2"] = zero if speed is None else speed**2
    found["yaw_acc"] = zero if yaw is None else _by_segment(prepared, yaw)
    if yaw is not None:
        found["yaw_square"] = yaw**2
        if _there(prepared, ("roll_rate",)):
            found["roll_yaw"] = prepared.columns["roll_rate"] * yaw
    found["vyaw"] = zero if speed is None or yaw is None else speed * yaw
    missing |= {
        name
        for name, lost in (
            ("v2", speed is None),
            ("yaw_acc", yaw is None),
            ("vyaw", speed is None or yaw is None),
        )
        if lost
    }
    found["total"] = forces.sum(axis=1)
    found["roll_moment"] = strut_roll_moment(forces, tracks)
    found["pitch_moment"] = strut_pitch_moment(forces, wheelbase)
    found |= _from_deflections(prepared, tracks, wheelbase)
    return _thinned(prepared, found, noise, how, forces, frozenset(missing))


def _thinned(
    prepared: Prepared,
    found: dict[str, FloatArray],
    noise: dict[str, float],
    how: dict[str, str],
    forces: FloatArray,
    missing: frozenset[str],
) -> Planes | None:
    step = max(1, int(prepared.rate_hz / (ROWS_A_CUTOFF * prepared.cutoff_hz)))
    rows = np.concatenate([np.arange(s.start, s.stop, step) for s in prepared.segments])
    good = np.isfinite(np.column_stack([c[rows] for c in found.values()])).all(axis=1)
    if "v2" not in missing:
        # a standing vehicle's held wheels strain the links against each other, and friction keeps what the stop left
        moving = found["v2"][rows] > STILL_MPS**2
        good &= moving | ~moving.any()
    rows = rows[good]
    if len(rows) < 2:
        return None
    time_s = prepared.time_s[rows]
    return Planes(
        columns={name: np.ascontiguousarray(c[rows]) for name, c in found.items()},
        noise=noise,
        time_s=time_s,
        block=np.floor((time_s - time_s[0]) / BLOCK_S).astype(np.int64),
        braking=_braking(prepared, found["fx"])[rows],
        loads=np.asarray(forces[rows].mean(axis=0)),
        rate_hz=prepared.rate_hz / step,
        how=how,
        missing=missing,
        drive_rows=len(good),
    )
