"""Zero offsets, stuck channels and coarse steps: reported, and left to the estimators (a stuck channel is left out)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray, Grid, compare
from parsers.checks.leaning_units import leaning_units
from parsers.checks.motion import path_turn_rate, seconds, vehicle_speed
from parsers.checks.wording import show
from parsers.drive import Decision, Signal
from parsers.quantiles import distinct, median, quantile

STANDSTILL = 0.1
_MIN_STANDSTILL_S = 3.0
_MIN_OFFSET = {"rate": 0.0017, "angle": 0.0052}
_STRAIGHT = 0.4
_MIN_STRAIGHT_S = 10.0
_LEVELS = 64
_MANY = 2048
_MOST_WEIGHTLESS = 0.3
_KEPT = "left in: estimators take it as a parameter"


def standing(grid: Grid, speed: FloatArray | None) -> BoolArray:
    """(n,) where the vehicle stands; nowhere without a speed."""
    return np.zeros(len(grid.time_s), dtype=np.bool_) if speed is None else np.abs(speed) < STANDSTILL


def offsets(grid: Grid) -> list[Decision]:
    """Offsets of the rates and of the roll angle, and of accelerations where they are larger than roads make them."""
    decisions: list[Decision] = []
    speed = vehicle_speed(grid)
    still = standing(grid, speed)
    turning = path_turn_rate(grid)
    references: dict[str, FloatArray | None] = {"yaw_rate": turning}
    for rate, angle in (("roll_rate", "roll"), ("pitch_rate", "pitch")):
        tilt = grid.get(angle)
        references[rate] = None if tilt is None or _flat(tilt) else grid.rate(tilt)
    for name in ("roll_rate", "pitch_rate", "yaw_rate"):
        column = grid.get(name)
        if column is not None:
            decisions += _rate_offset(name, column, still, references[name])
    roll = grid.get("roll")
    if roll is not None:
        decisions += _roll_offset(grid, roll, still)
    return decisions + leaning_units(grid, speed, still)


def _rate_offset(
    name: str, column: FloatArray, still: BoolArray, reference: FloatArray | None
) -> list[Decision]:
    """At standstill, else against the change of the angle, else (roll and pitch) over the whole drive."""
    here = still & np.isfinite(column)
    if seconds(here) >= _MIN_STANDSTILL_S:
        return _offset(name, column[here], f"at standstill ({seconds(here):.0f} s)", 0.0)
    if reference is not None:
        both = np.isfinite(column) & np.isfinite(reference)
        if seconds(both) >= 10:
            what = "the path's turn rate" if name == "yaw_rate" else "the change of the angle"
            rest = column[both] - reference[both]
            return _offset(name, rest, f"against {what} ({seconds(both):.0f} s)", 0.0)
    there = np.isfinite(column)
    span = seconds(there)
    # a body that starts and ends within 0.1 rad of level turns by no more than that on the whole
    if name != "yaw_rate" and span >= 60:
        return _offset(name, column[there], f"mean over {span:.0f} s", 0.1 / span)
    return []


def _offset(name: str, values: FloatArray, where: str, doubt: float, kind: str = "rate") -> list[Decision]:
    mean = float(np.mean(np.clip(values, quantile(values, 0.01), quantile(values, 0.99))))
    blocks = [part.mean() for part in np.array_split(values, min(10, len(values) // 5))]
    error = 3 * float(np.std(blocks)) / np.sqrt(len(blocks)) + doubt
    if abs(mean) < max(_MIN_OFFSET[kind], error):
        return []
    found = f"{name} has an offset of {show(name, mean)}"
    evidence = f"{where}, ± {show(name, error)}"
    if name == "roll":
        evidence += "; the unit's mount, or roads that fall to one side"
    return [Decision(name, "offset", found, _KEPT, evidence, applied=False)]


def _roll_offset(grid: Grid, roll: FloatArray, still: BoolArray) -> list[Decision]:
    lateral = grid.get("accel_y")
    here = still & np.isfinite(roll)
    if seconds(here) >= _MIN_STANDSTILL_S:
        return _offset("roll", roll[here], f"at standstill ({seconds(here):.0f} s)", 0.0, "angle")
    if lateral is None:
        return []
    found = compare(roll, lateral)
    if found is not None and abs(found.correlation) >= 0.8:
        return _fitted_offset(roll, lateral)
    straight = np.isfinite(roll) & (np.abs(lateral) < _STRAIGHT)
    if seconds(straight) < _MIN_STRAIGHT_S:
        return []
    where = f"where accel_y is below {_STRAIGHT:g} m/s² ({seconds(straight):.0f} s)"
    return _offset("roll", roll[straight], where, 0.0, "angle")


def _fitted_offset(roll: FloatArray, lateral: FloatArray) -> list[Decision]:
    """The roll angle at which a line through the drive has no lateral acceleration."""
    both = np.isfinite(roll) & np.isfinite(lateral)
    slope = float(np.cov(roll[both], lateral[both])[0, 1] / np.var(lateral[both], ddof=1))
    where = f"where a line through roll over accel_y has none ({seconds(both):.0f} s)"
    return _offset("roll", roll[both] - slope * lateral[both], where, 0.0, "angle")


def weightless(signals: Mapping[str, Signal]) -> Decision | None:
    """A vertical acceleration from which gravity was taken out, so that it is no specific force; None where it is in."""
    signal = signals.get("accel_z")
    if signal is None:
        return None
    middle = median(signal.values)
    if abs(middle) >= _MOST_WEIGHTLESS or float(np.std(signal.values)) <= 1e-6:
        return None
    return Decision(
        signal="accel_z",
        kind="choice",
        found="accel_z has no gravity in it: it is no specific force",
        action="left out; where it points up, map it with offset = 9.81",
        evidence=f"median {middle:.2f} m/s²",
        applied=True,
    )


def stuck(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """Channels that stand at one value while the vehicle does what must move them."""
    speed, yaw, lateral = vehicle_speed(grid), grid.get("yaw_rate"), grid.get("accel_y")
    turning = _moves(lateral, 1.0) or (yaw is not None and speed is not None and _moves(yaw * speed, 1.0))
    change = None if speed is None else grid.rate(speed)
    pushing = _moves(change, 1.0) or _moves(grid.get("accel_x"), 1.0)
    must = {
        "accel_x": _moves(change, 1.0),
        "accel_y": turning, "yaw_rate": turning, "roll_rate": turning, "roll": turning,
        "steering_wheel_angle": turning, "pitch_rate": pushing, "pitch": pushing or turning,
        **dict.fromkeys(("axle_load_front", "axle_load_rear"), _moves(change, 0.5)),
    }  # fmt: skip
    decisions: list[Decision] = []
    for name, moving in must.items():
        signal = signals.get(name)
        if signal is None or len(signal.values) < 20:
            continue
        if moving and float(np.ptp(signal.values)) == 0.0:
            found = f"{name} stands at {show(name, float(signal.values[0]))} for the whole drive"
            evidence = f"{len(signal.values)} equal samples while the vehicle moves"
            decisions.append(Decision(name, "range", found, "left out", evidence, applied=True))
        elif moving:
            decisions += _coarse(signal)
    return decisions


def _flat(values: FloatArray) -> bool:
    finite = values[np.isfinite(values)]
    return len(finite) == 0 or float(np.std(finite)) < 1e-4


def _moves(values: FloatArray | None, least: float) -> bool:
    if values is None or not np.isfinite(values).any():
        return False
    return seconds(np.abs(values - median(values)) > least) > 1.0


def _coarse(signal: Signal) -> list[Decision]:
    """Steps so coarse that a signal takes a handful of values only."""
    if len(distinct(signal.values[:_MANY])) > _LEVELS:
        return []
    levels = distinct(signal.values)
    low, high = quantile(signal.values, 0.01), quantile(signal.values, 0.99)
    step = float(np.min(np.diff(levels))) if 1 < len(levels) <= _LEVELS else 0.0
    if step <= 0 or (high - low) / step >= 8:
        return []
    found = f"{signal.name} comes in coarse steps of {show(signal.name, step)}"
    evidence = f"{len(levels)} different values in {len(signal.values)} samples"
    return [Decision(signal.name, "scale", found, "left as it is", evidence, applied=False)]
