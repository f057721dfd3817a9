"""Wrong signs, by ISO 8855: x forward, y left, z up; a left turn has accel_y, yaw_rate and roll above zero.

Lateral signals vote: each is compared with the lateral acceleration (else with yaw rate x speed). Of the two
explanations, "the reference is right" and "the reference is inverted", the one that inverts less wins, where channels
whose sign convention varies (roll, yaw rate) are cheap to invert, and those that have none (the path over ground,
the difference of the wheels' speeds, springs whose sign braking has told) are dear. Without such a witness the choice
is a convention, and is said to be. Where accel_z points down, the log's axes are likely those of SAE J670 (y right): all
lateral signals that agree with each other are then cheap to invert together.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, Together, compare
from parsers.checks.horizon import roll_tells
from parsers.checks.leaning import CANNOT_TELL, level_roads, swift_tells, told_by
from parsers.checks.motion import (
    MIN_SPEED,
    path_speed,
    path_turn_rate,
    right_minus_left,
    seconds,
    smooth,
    vehicle_speed,
)
from parsers.checks.springs import DEFLECTIONS, springs_decision, springs_in_braking
from parsers.drive import Decision
from parsers.quantiles import median, quantile

MIN_LATERAL = 1.0
MIN_SECONDS = 1.0
_MIN_LATERAL_CENTRED = 0.7
_LEAST = 0.55
_LEAST_QUICK = 0.6
_SURE = 1.0
_MIN_ROLL = 0.01
# what it costs to say that a channel's sign is wrong
_COSTS = {"accel_y": 1.5, "yaw_rate": 1.0, "roll": 0.9, "steering_wheel_angle": 1.2}
_PATH_COST = 4.0
_WHEELS_COST = 3.0
_SPRINGS_COST = 1.1
_SPRINGS_TOLD_COST = 5.0
_ROLL_RATE_COST = 0.9
_Z_DOWN_BONUS = 1.2
_ROLL_RATE = "roll_rate"
_YAW_ALONE = "sign of yaw_rate: other axes are turned, and it goes with none of them clearly"
_WITNESSES = {
    "path": "the path over ground",
    "wheels": "the difference of the rear wheels' speeds",
    "springs": "the springs",
}


@dataclass(frozen=True)
class Vote:
    """How a lateral channel relates to the reference. cost: of saying that it is inverted; said: what it is called; by: what of the
    reference it was held against, where that is a part of it."""

    name: str
    found: Together
    cost: float
    said: str
    by: str = ""


@dataclass(frozen=True)
class SignResult:
    """Which signals are inverted, the decisions, and which checks had too little to go by.

    axes_turned: whether the log's axes are those of SAE J670. exchanged: signals that are not what their names say, each being
    another's. told: signals whose sign an earlier step could not tell, and this one did.
    """

    inverted: frozenset[str]
    decisions: tuple[Decision, ...]
    unchecked: tuple[str, ...]
    axes_turned: bool = False
    exchanged: frozenset[str] = frozenset()
    told: frozenset[str] = frozenset()


def lateral_reference(grid: Grid) -> tuple[str, FloatArray] | None:
    """The signal that others are compared with, and what it says of lateral acceleration in m/s²."""
    lateral = grid.get("accel_y")
    if lateral is not None:
        return "accel_y", lateral
    yaw, speed = grid.get("yaw_rate"), vehicle_speed(grid)
    return None if yaw is None or speed is None else ("yaw_rate", yaw * speed)


def excited(values: FloatArray, least: float) -> bool:
    """Whether a column is beyond `least` for long enough, and not by one-sided offset alone."""
    return seconds(np.abs(values) > least) >= MIN_SECONDS


def varied(values: FloatArray, least: float) -> bool:
    """Whether a column is further than `least` from its median for long enough."""
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and excited(finite - quantile(finite, 0.5), least)


def lateral_votes(grid: Grid, reference: tuple[str, FloatArray]) -> list[Vote]:
    """All that can be compared with the reference and goes together with it clearly."""
    name, lateral = reference
    speed, yaw, turning = vehicle_speed(grid), grid.get("yaw_rate"), path_turn_rate(grid)
    votes: list[tuple[str, FloatArray, float, bool]] = []
    moving = np.abs(speed) > MIN_SPEED if speed is not None else np.zeros(len(lateral), dtype=np.bool_)
    if name != "yaw_rate" and yaw is not None and speed is not None:
        votes.append(("yaw_rate", np.where(moving, yaw * speed, np.nan), _COSTS["yaw_rate"], False))
    elif name != "yaw_rate" and yaw is not None:
        # a bend that is felt is driven forward: without a speed the yaw rate alone has the sign
        votes.append(("yaw_rate", yaw, _COSTS["yaw_rate"], False))
    ground = path_speed(grid)
    if turning is not None and ground is not None:
        votes.append(("path", turning * ground, _PATH_COST, False))
    difference = right_minus_left(grid, "wheel_speed")
    if difference is not None and speed is not None:
        votes.append(("wheels", np.where(moving, smooth(difference * speed), np.nan), _WHEELS_COST, True))
    steering = grid.get("steering_wheel_angle")
    if steering is not None and speed is not None:
        votes.append(
            ("steering_wheel_angle", np.where(moving, steering, np.nan), _COSTS["steering_wheel_angle"], True)
        )
    springs = right_minus_left(grid, "suspension_deflection")
    if springs is not None:
        told = springs_in_braking(grid) is not None
        votes.append(("springs", springs, _SPRINGS_TOLD_COST if told else _SPRINGS_COST, True))
    roll, turning_over = grid.get("roll"), grid.get("roll_rate")
    if roll is not None:
        votes.append(("roll", roll, _COSTS["roll"], True))
    elif turning_over is not None:
        votes.append((_ROLL_RATE, turning_over, _ROLL_RATE_COST, True))
    if not excited(lateral, MIN_LATERAL):
        return []
    moves = varied(lateral, _MIN_LATERAL_CENTRED)
    found: list[Vote] = []
    for each, values, cost, centred in votes:
        if centred and not moves:
            continue
        smoothed, by = smooth(lateral) if each == "path" else lateral, ""
        smoothed = grid.rate(lateral) if each == _ROLL_RATE else smoothed
        together = compare(values, smoothed, centred=centred)
        changes = grid.rate(values) if each == "roll" else values
        if each == "roll" and name == "accel_y":
            together, by = roll_tells(grid, together, (changes, grid.rate(lateral)), (_LEAST, _LEAST_QUICK))
        elif each in ("roll", _ROLL_RATE) and together is not None and abs(together.correlation) >= _LEAST:
            together = told_by(grid, together, (changes, grid.rate(lateral)), _LEAST_QUICK)
        elif each in ("roll", _ROLL_RATE):
            together = swift_tells(changes, grid.rate(lateral))
        if together is not None and abs(together.correlation) >= _LEAST:
            said = "yaw_rate × speed" if each == "yaw_rate" and speed is not None else each
            found.append(Vote(each, together, cost, _WITNESSES.get(each, said), by))
    return found


def springs_signs(grid: Grid) -> SignResult:
    """The sign of suspension deflections, which braking tells without the lateral signals."""
    found = springs_in_braking(grid)
    if found is None or found.sign > 0:
        return SignResult(frozenset(), (), ())
    return SignResult(frozenset(DEFLECTIONS), (springs_decision(found),), ())


def lateral_signs(grid: Grid) -> SignResult:
    """Signs of accel_y, yaw_rate, roll, steering and deflections against each other."""
    reference = lateral_reference(grid)
    if reference is None:
        return SignResult(
            frozenset(), (), ("lateral signs: no lateral acceleration, nor yaw rate and speed",)
        )
    name, lateral = reference
    if not excited(lateral, MIN_LATERAL):
        text = f"lateral signs: {name} never asks for {MIN_LATERAL:g} m/s² for {MIN_SECONDS:g} s"
        return SignResult(frozenset(), (), (text,))
    votes = lateral_votes(grid, reference)
    down = grid.get("accel_z")
    z_down = down is not None and bool(np.isfinite(down).any()) and median(down) < -5
    costs = {vote.name: vote.cost for vote in votes} | {name: _COSTS[name]}
    against = {vote.name for vote in votes if vote.found.sign < 0}
    with_it = {vote.name for vote in votes if vote.found.sign > 0}
    if z_down:
        turning_alike = {"steering_wheel_angle"} & with_it
        for signal in {"accel_y", "yaw_rate", *turning_alike} & set(costs):
            costs[signal] = max(costs[signal] - _Z_DOWN_BONUS, 0.1)
    right = sum(costs[each] for each in against)
    wrong = costs[name] + sum(costs[each] for each in with_it)
    chosen = against if right <= wrong else {name, *with_it}
    margin = abs(right - wrong)
    by_name = {vote.name: vote for vote in votes}
    chosen = chosen - {
        _ROLL_RATE
    }  # a witness here; its own sign is looked at when those of the others are settled
    told = springs_in_braking(grid) is not None
    if told and _springs_alone(against, with_it):
        chosen = {"springs"}
    exchanged = "springs" in chosen and told
    decisions = tuple(
        _lateral_decision(each, name, by_name, chosen, margin, z_down)
        for each in costs
        if each in chosen and not (exchanged and each == "springs")
    )
    if exchanged:
        # braking has told their sign, and all else that turns says the opposite: no sign of theirs is right for both
        chosen = chosen - {"springs"}
    names: set[str] = set()
    for each in chosen - {"path", "wheels"}:
        names |= set(DEFLECTIONS) if each == "springs" else {each}
    axes_turned = z_down and name in chosen
    alone = axes_turned and "yaw_rate" in grid.columns and "yaw_rate" not in costs
    unchecked: tuple[str, ...] = ()
    if "roll" in grid.columns and "roll" not in costs:
        why = CANNOT_TELL if _hidden(grid) else "it goes with no bend clearly"
        unchecked = (f"sign of roll: {why}",)
    return SignResult(
        frozenset(names), decisions, unchecked + ((_YAW_ALONE,) if alone else ()), axes_turned=axes_turned,
        exchanged=frozenset(DEFLECTIONS) if exchanged else frozenset(),
    )  # fmt: skip


def _springs_alone(against: Collection[str], with_it: Collection[str]) -> bool:
    """Whether only the springs disagree with bends as acceleration, turning and roll show them all alike.

    Axes with y to the right change the signs of what is felt across and of turning, never that of roll; a unit that is mounted backwards changes
    roll and what is felt across, never turning. So no way to hold the axes explains all of these, and exchanged wheels do.
    """
    return (
        set(against) == {"springs"}
        and bool({"roll", _ROLL_RATE} & set(with_it))
        and bool({"yaw_rate", "steering_wheel_angle", "path", "wheels"} & set(with_it))
    )


def _hidden(grid: Grid) -> bool:
    """Whether a roll angle moves on roads that may lean."""
    roll = grid.get("roll")
    return roll is not None and varied(roll, _MIN_ROLL) and not level_roads(grid)


def _lateral_decision(
    each: str, reference: str, votes: Mapping[str, Vote], chosen: set[str], margin: float, z_down: bool
) -> Decision:
    vote = votes.get(each) or next(vote for vote in votes.values() if vote.name not in chosen)
    other = reference if each in votes else vote.name
    said = votes[other].said if other in votes else other if other != "yaw_rate" else "yaw_rate × speed"
    agree = [
        _WITNESSES.get(name, name) for name in (reference, *votes) if name not in chosen and name != each
    ]
    evidence = (
        f"correlation {vote.found.correlation:.2f} with {vote.by or said} over {vote.found.seconds:.0f} s"
    )
    if len(agree) > 1:
        evidence += f"; {', '.join(agree)} agree with each other"
    if each in ("path", "wheels"):
        what = "longitude" if each == "path" else "wheel_speed_rl"
        found = f"{_WITNESSES[each]} turns the other way than {said}"
        return Decision(what, "sign", found, "left as it is", evidence, applied=False)
    signal = "suspension_deflection_fl" if each == "springs" else each
    action = "inverted"
    if each == "springs":
        action = "all four deflections inverted (compression is positive)"
    if reference in chosen and z_down:
        action += ": accel_z points down, so the log's axes are taken for those of SAE J670 (y right, z down)"
    elif margin < _SURE:
        action += " by convention: which of the two is wrong cannot be told, only that they disagree"
    shown = "suspension deflection" if each == "springs" else each
    found = f"{shown} has the sign opposite to {said}"
    if reference in chosen and each != reference:
        against = next((name for name in votes if name not in chosen), "")
        found = f"{shown} goes with {said}, which has the sign opposite to {_WITNESSES.get(against, against)}"
    return Decision(signal, "sign", found, action, evidence, applied=True)


def turned_along(names: Collection[str], unchecked: Sequence[str]) -> tuple[Decision, ...]:
    """Pitch and its rate in a log whose axes are those of SAE J670, where the drive cannot tell their sign.

    names: of the signals; unchecked: what the checks say they could not judge.
    """
    evidence = (
        "accel_z points down and the lateral signals are inverted together; the drive alone cannot tell it"
    )
    return tuple(
        Decision(
            name,
            "sign",
            f"{name} belongs to axes of SAE J670, in which nose up is positive",
            "inverted with the other axes",
            evidence,
            applied=True,
        )
        for name in ("pitch", "pitch_rate")
        if name in names and any(text.startswith(f"sign of {name}:") for text in unchecked)
    )
