"""From prepared signals to the columns of the balances: low-passed alike, thinned, with their blocks of time.

What is not linear (damper halves, friction, squares) is made at the full band and low-passed afterwards, so that a
column holds the mean of the force and not the force of the mean.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.estimators.load_balance.axle_lag import IN_TIME, LATE_S, earlier, lateness
from pipelines.estimators.load_balance.lean import angles_of
from pipelines.estimators.load_balance.levelled import levelled, tilted
from pipelines.estimators.load_balance.nodding import nodding_columns
from pipelines.estimators.load_balance.pedals import pedals_of
from pipelines.estimators.load_balance.smoothing import (
    SIDE_MEMORY_M,
    STICK_HZ,
    Smoother,
    friction_state,
    held_by_tyres,
)
from pipelines.joint.vehicle.suspension import STOP_POWER
from pipelines.joint.vehicle.unknowns import AXLES, CORNERS, TYRE_SHARE, Known
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray
from pipelines.vehicles.kinds import Kind

BLOCK_S = 12.0
STICK_M, YIELD_M = 0.0007, 0.004
"""Travel within which dry friction turns round, of seals and joints and of what gives before it slides (bushings, leaves of springs,
tops of dampers): real friction has some of each."""

STOPS_M = 0.025
"""Travel from where the empty vehicle stands, below which no bump stop is touched."""

CRAWL = 0.3
"""m/s below which wheels are taken not to roll."""


@dataclass(frozen=True)
class Columns:
    """The drive as the balances see it. columns: name -> (n,), NaN where a signal is missing. time_s, block: (n,).

    block: number of the stretch of BLOCK_S that a row belongs to. rate_hz: of these rows. kinds: sources of vertical
    forces that are there ("deflection", "suspension", "tyre", "axle"). sag: how much lower
    the body stands than empty, m; None without deflections. axles_late: whether the axle loads were later than what they show.
    one_axle: the axle whose deflections alone are there, both of them; empty where all four are, or none.
    """

    columns: Mapping[str, FloatArray]
    time_s: FloatArray
    block: NDArray[np.int64]
    rate_hz: float
    kinds: tuple[str, ...]
    sag: float | None
    rest_s: float
    has_torque: tuple[bool, bool]
    axles_late: bool = False
    one_axle: tuple[str, ...] = ()

    def has(self, *names: str) -> bool:
        """Whether all of these columns hold something."""
        return all(n in self.columns and bool(np.isfinite(self.columns[n]).any()) for n in names)


def _rate_of(values: FloatArray, prepared: Prepared) -> FloatArray:
    """Time derivative at the full band, segment by segment."""
    out = np.full(len(values), np.nan)
    for s in prepared.segments:
        if s.stop - s.start >= 2:
            out[s.start : s.stop] = np.gradient(values[s.start : s.stop]) * prepared.rate_hz
    return out


def _corner_columns(
    prepared: Prepared,
    smooth: Smoother,
    axles: Sequence[str],
    free_m: Mapping[str, float],
    from_stand: bool,
    apart: Mapping[str, float],
) -> dict[str, FloatArray]:
    """Deflection at each wheel, and what follows from the travel of its spring: square and cube, damper halves, both kinds of friction; of
    each axle what standing tyres hold. apart: axle -> how far its springs stand apart, over the track."""
    found: dict[str, FloatArray] = {}
    calm = Smoother(prepared, STICK_HZ)
    for wheel in (w for w in CORNERS if _axle_of(w) in axles):
        at_wheel, ratio = prepared.columns[f"suspension_deflection_{wheel}"], apart[_axle_of(wheel)]
        across = prepared.columns[f"suspension_deflection_{wheel[0]}{'r' if wheel[1] == 'l' else 'l'}"]
        d = 0.5 * ((1 + ratio) * at_wheel + (1 - ratio) * across) if ratio != 1.0 else at_wheel
        rate = _rate_of(d, prepared)
        stop = _into_stops(d, prepared, free_m[_axle_of(wheel)], from_stand)
        parts = {
            "d": at_wheel, "d2": d * d, "d3": d**3, "stop": stop, "bump": np.maximum(rate, 0.0), "rebound": np.minimum(rate, 0.0),
            "stick": friction_state(calm.whole(d), prepared, STICK_M),
            "yield": friction_state(calm.whole(d), prepared, YIELD_M),
        }  # fmt: skip
        for name, column in parts.items():
            found[f"{name}_{wheel}"] = smooth(column)
    speed = speed_of(prepared)
    moves = np.full(len(prepared.time_s), np.nan) if speed is None else speed
    for axle in axles:
        pair = [prepared.columns[f"suspension_deflection_{axle[0]}{side}"] for side in "lr"]
        travel = calm.whole(0.5 * (pair[0] + pair[1]))
        found[f"scrub_{axle}"] = smooth(held_by_tyres(travel, prepared, moves, SIDE_MEMORY_M))
    return found


def _into_stops(d: FloatArray, prepared: Prepared, free_m: float, from_stand: bool) -> FloatArray:
    """(n,) how a bump stop's force rises with travel, over its coefficient: with from_stand the square of the travel beyond free_m and
    beyond where the wheel stands, in which one may be touched; else the STOP_POWER of that beyond free_m, where it begins."""
    if not from_stand:
        return np.asarray(np.maximum(d - free_m, 0.0) ** STOP_POWER)
    still = prepared.standstill
    stands = d[still] if len(still) and still.any() else d
    from_m = max(float(np.nanmedian(stands)) if np.isfinite(stands).any() else 0.0, free_m)
    return np.asarray(np.maximum(d - from_m, 0.0) ** 2)


def speed_of(prepared: Prepared) -> FloatArray | None:
    """(n,) m/s by the best signal that is there most of the time; None without one."""
    c = prepared.columns
    wheels = [c[f"wheel_speed_{w}"] for w in CORNERS if f"wheel_speed_{w}" in c]
    for column in (
        c.get("speed"),
        np.median(wheels, axis=0) if len(wheels) == 4 else None,
        c.get("gps_speed_2d"),
    ):
        if column is not None and prepared.share_of(column) > 0.5:
            return np.asarray(column)
    return None


def _inertial(
    prepared: Prepared, smooth: Smoother, angles: tuple[FloatArray, FloatArray], *, seen: bool
) -> dict[str, FloatArray]:
    """Accelerations, their rates, and angular accelerations (gyros, or the deflections' where there are none).

    seen: whether the angles are the deflections'. What the springs are taken to make of the accelerations, where they are not, goes by another name: it tells
    of an inertia no more than of the springs.
    """
    c, n = prepared.columns, len(prepared.time_s)
    found: dict[str, FloatArray] = {}
    level = {"z": levelled(prepared, angles, speed_of(prepared))} if "accel_z" in c else {}
    for axis in "xyz":
        if f"accel_{axis}" in c:
            column = level.get(axis, c[f"accel_{axis}"])
            found[f"f{axis}"] = smooth(column)
            found[f"df{axis}"] = smooth(column, 1)
            found[f"ddf{axis}"] = smooth(column, 2)
    rates = {}
    for name, angle in (("pitch", angles[0]), ("roll", angles[1]), ("yaw", None)):
        gyro = c.get(f"{name}_rate")
        if gyro is not None and prepared.share_of(gyro) > 0.9:
            rates[name] = gyro
        else:
            rates[name] = np.zeros(n) if angle is None else _rate_of(angle, prepared)
            if angle is not None and not seen:
                found[f"guessed_{name}_acc"] = smooth(rates[name], 1)
                continue
        found[f"{name}_acc"] = smooth(rates[name], 1)
    if "roll_acc" in found:
        found["droll_acc"] = smooth(rates["roll"], 2)
    found["yaw2"] = smooth(rates["yaw"] ** 2)
    found["yaw"] = smooth(rates["yaw"])
    return found


def _axle_of(wheel: str) -> str:
    return "front" if wheel[0] == "f" else "rear"


def _there(prepared: Prepared, names: Sequence[str]) -> bool:
    c = prepared.columns
    return all(n in c and bool(np.isfinite(c[n]).any()) for n in names)


def _axles_with_deflections(prepared: Prepared) -> tuple[str, ...]:
    """Axles whose two deflections are both there."""
    return tuple(
        axle for axle in AXLES if _there(prepared, [f"suspension_deflection_{axle[0]}{s}" for s in "lr"])
    )


def _kinds(prepared: Prepared) -> tuple[str, ...]:
    """Sources of vertical forces that are there at every wheel (or axle)."""
    found = []
    for kind, name in (
        ("deflection", "suspension_deflection"),
        ("suspension", "suspension_force"),
        ("tyre", "tire_normal_force"),
    ):
        if _there(prepared, [f"{name}_{w}" for w in CORNERS]):
            found.append(kind)
    if _there(prepared, ["axle_load_front", "axle_load_rear"]):
        found.append("axle")
    return tuple(found)


def _at_rest(prepared: Prepared, smooth: Smoother) -> FloatArray:
    """(n,) 1 at rest, 0 moving, NaN near the change of one into the other."""
    still = prepared.standstill
    if len(still) == 0:
        return np.zeros(len(smooth.rows))
    # the low-pass mixes both within this time
    width = max(1, round(0.7 * prepared.rate_hz / smooth.band_hz)) + smooth.half
    box = np.ones(2 * width + 1)
    share = np.convolve(still.astype(float), box, mode="same") / np.convolve(
        np.ones(len(still)), box, mode="same"
    )
    state = np.where(share > 0.999, 1.0, np.where(share < 0.001, 0.0, np.nan))
    return np.asarray(state[smooth.rows])


def _driven(
    prepared: Prepared,
    smooth: Smoother,
    pedals: Mapping[str, FloatArray],
    angles: tuple[FloatArray, FloatArray],
    found: dict[str, FloatArray],
) -> None:
    """Adds what braking, driving and bends make of the specific forces, and the speed. found: with the inertial columns."""
    c = prepared.columns
    if "accel_x" in c:
        found["fx_brake"] = smooth(c["accel_x"] * pedals["on"])
        found["fx_drive"] = found["fx"] - found["fx_brake"]
        found["fx_tilt"] = smooth(GRAVITY * angles[0])
        found["fx_tilt_brake"] = smooth(GRAVITY * angles[0] * pedals["on"])
        dipped = c["accel_x"] * angles[0]
        found["dip_brake"] = smooth(dipped * pedals["on"])
        found["dip_drive"] = smooth(dipped) - found["dip_brake"]
    if "accel_y" in c:
        found["fy2"] = smooth(c["accel_y"] ** 2)
        found["fy3"] = smooth(c["accel_y"] ** 3)
        found["fy_tilt"] = smooth(-GRAVITY * angles[1])
    found["fz_tilt"] = smooth(tilted(prepared, angles))
    v = speed_of(prepared)
    speed = np.zeros(len(prepared.time_s)) if v is None else v
    found["v"], found["v2"] = smooth(speed), smooth(speed * speed)
    found["vdot"] = smooth(speed, 1) if v is not None else found.get("fx", found["v"])
    found["vyaw"] = found["v"] * found["yaw"]
    found |= {n: smooth(pedals[n]) for n in ("brake", "drive", "on", "pushed") if n in pedals}
    found["on_rolling"] = smooth(pedals["on"] * (speed > CRAWL))
    if "drive" in pedals:
        found["drive_on"] = smooth(pedals["drive"] * pedals["on"] * (speed > CRAWL))
    else:
        found["held_on"] = found["on_rolling"]
        if "fx_brake" in found:
            found["held_fx"] = found["fx_brake"]
    found["v2_on"] = smooth(pedals["on"] * speed * speed)
    if v is not None:
        found |= nodding_columns(prepared, found, smooth, speed)
    if "by_pressure" in pedals:
        found["by_pressure"] = np.ones(len(smooth.rows))


def _axle_columns(
    prepared: Prepared, smooth: Smoother, rest: FloatArray, late: float
) -> dict[str, FloatArray]:
    """Axle loads where they belong, so much earlier [s]; from LATE_S on what the axles carry, and nothing of what moves it."""
    found = {a: smooth(earlier(prepared.columns[f"axle_load_{a}"], prepared, late)) for a in AXLES}
    if late > LATE_S:
        found = {a: np.where(rest == 1, load, np.nan) for a, load in found.items()}
    return {f"axle_{a}": load for a, load in found.items()}


def collect(
    prepared: Prepared,
    known: Known,
    band_hz: float,
    *,
    zero_loaded: bool = False,
    free_m: Mapping[str, float] | None = None,
    vehicle_kind: Kind = "car",
) -> Columns:
    """All columns of the balances from a prepared drive; empty where it has no segments.

    zero_loaded: deflections are nought where the loaded vehicle stands: how far the load lowers it is then not in them.
    free_m: axle -> deflection from which on its bump stops may be touched; None: nobody says.
    vehicle_kind: tells how late load transfer itself is.
    """
    kinds = _kinds(prepared) if prepared.segments else ()
    late = lateness(prepared, vehicle_kind) if "axle" in kinds else IN_TIME
    # what averages too long tells at rest alone
    smooth = Smoother(prepared, band_hz, 0.0 if late.late_s > LATE_S else late.mean_s)
    angles = angles_of(prepared, known, "deflection" in kinds)
    found = _inertial(prepared, smooth, angles, seen="deflection" in kinds)
    pedals, has_torque = pedals_of(prepared, known)
    rest = _at_rest(prepared, smooth)
    found |= {"rest": rest, "move": 1.0 - rest, "one": np.ones(len(rest))}
    _driven(prepared, smooth, pedals, angles, found)
    sag = None
    axles = _axles_with_deflections(prepared) if prepared.segments else ()
    if axles:
        free = free_m or dict.fromkeys(AXLES, 0.0 if zero_loaded else STOPS_M)
        apart = {a: float(known.mean[known.index(f"spring_base_{a}")]) for a in AXLES}
        found |= _corner_columns(prepared, smooth, axles, free, free_m is None, apart)
        if not zero_loaded and axles == AXLES:
            sag = TYRE_SHARE * float(np.nanmean([np.nanmean(found[f"d_{w}"]) for w in CORNERS]))
    for kind, name in (("suspension", "suspension_force"), ("tyre", "tire_normal_force")):
        if kind in kinds:
            found |= {f"{kind}_{w}": smooth(prepared.columns[f"{name}_{w}"]) for w in CORNERS}
    if "axle" in kinds:
        found |= _axle_columns(prepared, Smoother(prepared, band_hz), rest, late.late_s)
    time_s = prepared.time_s[smooth.rows]
    block = np.floor((time_s - (time_s[0] if len(time_s) else 0.0)) / BLOCK_S).astype(np.int64)
    rest_s = float(np.nansum(rest)) * smooth.step / prepared.rate_hz if prepared.rate_hz else 0.0
    return Columns(
        found,
        time_s,
        block,
        prepared.rate_hz / smooth.step if prepared.rate_hz else 0.0,
        kinds,
        sag,
        rest_s,
        has_torque,
        late.late_s > 0,
        () if axles == AXLES else axles,
    )
