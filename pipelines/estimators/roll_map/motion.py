"""What the model makes of the lateral acceleration: a linear body, on tyres or not, and what springs, dampers and friction hold besides."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.estimators.roll_map.data import RollData
from pipelines.models.driven import driven
from pipelines.models.roll import GRAVITY, RollCoefficients, dry_friction
from pipelines.models.roll_series import (
    AXLES_MOMENT,
    LEAST_SHARE,
    LinearRoll,
    plain_roll,
    series_roll,
    suspension_alone,
)
from pipelines.results import FloatArray

SLIP = 0.002
"""rad of roll (1.5 mm at a wheel) after which friction has turned round."""

KNEE_RATE = 0.17
"""rad/s of roll at which dampers' second slope begins: 0.13 m/s at half a track of 0.77 m (valves open at 0.05-0.25 m/s)."""

ROUNDED = 0.3
"""Over what share of the knee's rate one slope turns into the other."""


def tyres_share(p: Mapping[str, float]) -> float:
    """κ, how much of the roll against the horizon is the tyres'; 0 where they are not a part of the model."""
    share = p.get("series", 0.0)
    return share if share > LEAST_SHARE else 0.0


def apparent(p: Mapping[str, float]) -> RollCoefficients:
    """The motion's coefficients at low frequency, gravity's part included in a."""
    return RollCoefficients(p["a"], p["b"], p["c"])


def suspension_of_motion(data: RollData, p: Mapping[str, float]) -> RollCoefficients:
    """The coefficients of springs and dampers themselves, tyres taken off where they are a part of the model."""
    share = tyres_share(p)
    if share == 0.0:
        return apparent(p)
    return suspension_alone(apparent(p), share, AXLES_MOMENT, against_axles=data.against_axles)


def rate_gain(data: RollData, p: Mapping[str, float]) -> float:
    """The body's rate over that of the measured angle, at low frequency."""
    share = tyres_share(p)
    if share and data.against_axles:
        return (1 + AXLES_MOMENT * share) / (1 - share)
    return p.get("rate_gain", 1.0)


def linear_of(data: RollData, p: Mapping[str, float]) -> LinearRoll:
    """The linear model. Where the vehicle holds its course, the input is the path's acceleration: see `simulated`."""
    share = tyres_share(p)
    if share == 0.0:
        return plain_roll(apparent(p), gravity=data.holds_course, gain=p.get("rate_gain", 1.0))
    return series_roll(
        apparent(p), share, AXLES_MOMENT, against_axles=data.against_axles, gravity=data.holds_course
    )


def input_of(data: RollData, p: Mapping[str, float]) -> FloatArray:
    """(n,) the acceleration that goes into the linear model."""
    accel = data.shifter.delayed(p["delay"])
    if data.yaw_shifter is not None and "lever" in p:
        accel = accel - p["lever"] * data.yaw_shifter.slope(p["delay"])
    return np.asarray(accel - GRAVITY * data.whole_roll) if data.holds_course else accel


def later_rows(data: RollData, column: FloatArray) -> FloatArray:
    """Each row's next one; a segment's last row keeps its own."""
    later = np.concatenate((column[1:], column[-1:]))
    later[data.stops - 1] = column[data.stops - 1]
    return later


def _earlier_rows(data: RollData, column: FloatArray) -> FloatArray:
    earlier = np.concatenate((column[:1], column[:-1]))
    earlier[data.starts] = column[data.starts]
    return earlier


Hold = tuple[FloatArray, FloatArray, FloatArray]
"""A model's step of one row under inputs that run straight: `LinearRoll.held`."""


def _run(data: RollData, model: LinearRoll, hold: Hold, push: FloatArray, rows: FloatArray) -> FloatArray:
    """(n, k) outputs rows x of the model under inputs (n, 2), from rest at each segment's start; rows: (k, s)."""
    first = model.steady(push[data.starts])
    return driven(push, (data.starts, data.stops), hold, rows, first)


def suspension_motion(
    data: RollData, model: LinearRoll, accel: FloatArray, hold: Hold | None = None
) -> tuple[FloatArray, FloatArray]:
    """(n,) angle and rate of the body against what its springs stand on, in the linear model. hold: the model's, where it is made already."""
    push = np.column_stack((accel, np.zeros_like(accel)))
    row = model.between
    rate = row @ model.matrix
    hold = model.held(data.step_s) if hold is None else hold
    angle, moving = _run(data, model, hold, push, np.array([row, rate])).T
    # what the inputs add to the rate at once (tyres without inertia)
    return angle, np.asarray(moving + push @ (row @ model.feed))


def excess(rate: FloatArray) -> FloatArray:
    """By how much a rate lies beyond the dampers' knee, rounded, odd."""

    def beyond(x: FloatArray) -> FloatArray:
        return np.asarray(0.5 * (x + np.hypot(x, ROUNDED * KNEE_RATE)))

    return beyond(rate - KNEE_RATE) - beyond(-rate - KNEE_RATE)


def _held(data: RollData, p: Mapping[str, float], angle: FloatArray, rate: FloatArray) -> FloatArray | float:
    """(n,) what curved springs, K φ (1 + s φ²), dampers with a knee and dry friction hold, over m h.

    Springs that are 3 % stiffer at 0.1 rad would otherwise move a, and with it the height, by as much. Friction of
    0.1 m/s² left out moved b and c by 20-40 % in a sine with dwell: what turns round with the rate looks like damping
    that shrinks with the amplitude, and a delay takes up the rest.
    """
    own = suspension_of_motion(data, p)
    held: FloatArray | float = 0.0
    if p.get("stiffening"):
        held = held + own.a * p["stiffening"] * (angle * angle * angle)
    if p.get("friction"):
        held = held + p["friction"] * dry_friction(angle, data.starts, data.stops, SLIP)
    if p.get("knee"):
        held = held - own.b * p["knee"] * excess(rate)
    return held


def _of_friction(data: RollData, angle: FloatArray) -> float:
    """Linear damping that takes as much energy over the motion (n,) of the springs as a friction of 1, s/rad."""
    way = np.diff(angle)
    way[data.stops[:-1] - 1] = 0.0
    power = max(float(np.sum(way * way)) / data.step_s, 1e-12)
    held = dry_friction(angle, data.starts, data.stops, SLIP)
    return float(np.sum(held[1:] * way)) / power


def friction_damping(data: RollData, p: Mapping[str, float]) -> float:
    """What dry friction of 1 N m, in roll, adds to the roll damping of the suspension at this drive's own speeds, s/rad."""
    angle, _ = suspension_motion(data, linear_of(data, p), input_of(data, p))
    return _of_friction(data, angle)


def working_damping(data: RollData, p: Mapping[str, float]) -> tuple[float, float]:
    """What friction of 1 m/s², and a whole knee, add to the linear damping that takes as much energy over the drive, in units of b."""
    angle, rate = suspension_motion(data, linear_of(data, p), input_of(data, p))
    # against the horizon the tyres take off the dampers' part
    share = p["b"] / suspension_of_motion(data, p).b
    beyond = float(np.sum(excess(rate) * rate)) / max(float(np.sum(rate * rate)), 1e-12)
    return share * _of_friction(data, angle), -p["b"] * beyond


def _smoothed(data: RollData, angle: FloatArray, square_s: float) -> FloatArray:
    """A column seen through a filter whose response has the variance `square_s` in s², its delay left out: second order."""
    bend = later_rows(data, angle) - 2 * angle + _earlier_rows(data, angle)
    bend[data.starts] = bend[data.stops - 1] = 0.0
    return np.asarray(angle + 0.5 * square_s / data.step_s**2 * bend)


def simulated(data: RollData, p: Mapping[str, float]) -> FloatArray:
    """(n, m) measurement minus the motion that the model makes of the acceleration alone.

    A vehicle that holds its course on a banked road reads g times the bank: the accelerometer is not independent of
    what moves the angle without the springs, and slopes come out too large (the gradient by 24 % in slow circles on
    roads with 0.1-0.8 deg of bank). The path's acceleration f - g φ is independent of it: with an angle against the
    horizon, c φ'' + b φ' + (a - g) φ = f - g φ is simulated, the same equation with that input.
    """
    model, accel = linear_of(data, p), input_of(data, p)
    hold = model.held(data.step_s)
    push = np.column_stack((accel, np.zeros_like(accel)))
    if any(p.get(name) for name in ("stiffening", "friction", "knee")):
        push[:, 1] = _held(data, p, *suspension_motion(data, model, accel, hold))
    rows: list[FloatArray] = []
    feed: list[FloatArray | float] = []
    measured: list[FloatArray] = []
    if data.has_roll:
        rows.append(model.angle)
        feed.append(p["roll_offset"])
        measured.append(data.roll)
    if data.has_rate:
        # the rate comes `rate_lag` after the angle: the model's rate is read that much earlier, exactly
        late = p["rate_lag"] - data.rate_shift_s if "rate_lag" in p else 0.0
        moved, level, ramp = model.ramp(-late)
        slope = push - _earlier_rows(data, push) if late >= 0 else later_rows(data, push) - push
        offset = p["rate_offset"] + p.get("yaw_leak", 0.0) * data.yaw
        rows.append(model.rate @ moved)
        feed.append(offset + push @ (model.rate @ level) + slope @ (model.rate @ ramp) / data.step_s)
        measured.append(data.rate)
    found = _run(data, model, hold, push, np.array(rows))
    for column, added in enumerate(feed):
        found[:, column] += added
    if p.get("smoothing") and data.has_roll:
        found[:, 0] = _smoothed(data, found[:, 0], p["smoothing"])
    return np.column_stack(measured) - found


def offset_slope(data: RollData, name: str) -> FloatArray | None:
    """(n, m) what one of a parameter that only adds to the measurements adds to them (`simulated` loses it); None for others."""
    if name not in ("roll_offset", "rate_offset", "yaw_leak"):
        return None
    columns = []
    if data.has_roll:
        columns.append(np.full(data.size, float(name == "roll_offset")))
    if data.has_rate:
        columns.append(data.yaw if name == "yaw_leak" else np.full(data.size, float(name == "rate_offset")))
    return np.column_stack(columns)


def handed_on(
    data: RollData, p: Mapping[str, float], order: tuple[str, ...]
) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """Names (k), values (k,) and slopes (k, p) of a, b, c and the rate gain in the parameters named in `order`.

    Friction and knee count into b by the energy that they take over the drive: the log tells the sum well, and hardly
    which is which (b alone came out 25-45 % off). a stays without friction.
    """
    friction, knee = working_damping(data, p)
    damping = p["b"] + friction * p.get("friction", 0.0) + knee * p.get("knee", 0.0)
    slopes: dict[str, dict[str, float]] = {
        "a": {"a": 1.0},
        "b": {"b": 1.0 + knee * p.get("knee", 0.0) / p["b"], "friction": friction, "knee": knee},
        "c": {"c": 1.0},
    }
    values = [p["a"], damping, p["c"]]
    if data.against_axles and data.has_rate and data.has_roll:
        values.append(rate_gain(data, p))
        share = tyres_share(p)
        slopes["rate_gain"] = {"rate_gain": 1.0, "series": (1 + AXLES_MOMENT) / (1 - share) ** 2}
    rows = [[slope.get(name, 0.0) for name in order] for slope in slopes.values()]
    return tuple(slopes), np.array(values), np.array(rows)
