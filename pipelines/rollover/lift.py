"""Wheel lift from tyre normal forces: which wheel, when, for how long, how surely; a turn's lift told from a bounce.

A wheel is light where its force is below 3 % of its static load plus what its sensor may be off. A light wheel lifted in a
turn where the slow part of its load is (nearly) gone too, where it is the turn's inner wheel, and where the other wheels
carry the weight that it lost. A wheel that a bump throws up keeps its slow load; a sensor that drops out leaves a
vehicle whose wheels do not carry its weight, and is no event at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from parsers.signals import WHEELS
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray
from pipelines.rollover.check import slow_forces
from pipelines.rollover.motion import Motion
from pipelines.rollover_results import LiftKind, WheelLift
from pipelines.tire_forces import TireForces

LIGHT = 0.03
GONE = 0.02
"""Shares of the static load: a wheel is looked at below LIGHT, and counts as off the ground below GONE."""
SHORTEST_S = 0.05
TURN_S = 0.08
APART_S = 0.08
SLOW_SHARE = 0.30
TURNING_G = 0.25
BALANCE = 0.15
DROPOUT_S = 0.15
EDGE_S = (0.075, 0.175)
AT_ONCE, MISSING = 0.7, 0.5
"""Least duration of any event and of one called a turn's lift; events nearer than APART_S are one. SLOW_SHARE: of the static
load that the slow part may keep in a turn's lift. TURNING_G: least lateral acceleration of one. BALANCE: how far the four
forces' sum may be from the weight; an imbalance of DROPOUT_S is no bump. EDGE_S: from where to where
from an event's edges its inside and outside are compared; AT_ONCE, MISSING: shares of the loss that a failing sensor has within the
nearer distance, and that is missing in the sum."""

LEAST_PROBABILITY = 0.05
MOST_EVENTS = 500
_95 = 1.959964


@dataclass(frozen=True)
class _Light:
    """A light stretch of one wheel: rows first..past."""

    wheel: str
    first: int
    past: int
    least: float
    std: float
    probability: float


def statics(forces: TireForces, motion: Motion | None) -> dict[str, float]:
    """Static load of each wheel: the median while the vehicle goes straight, or of all there is."""
    straight = np.ones(len(forces.time_s), dtype=bool)
    if motion is not None and len(motion.time_s) > 1:
        lateral = np.interp(forces.time_s, motion.time_s, motion.lateral)
        near = np.abs(lateral) < 0.08
        straight = near if near.sum() >= 20 else straight
    found = {}
    for wheel in WHEELS:
        values = forces.value[wheel]
        known = values[straight & np.isfinite(values)]
        known = known if len(known) else values[np.isfinite(values)]
        found[wheel] = float(np.median(known)) if len(known) else math.nan
    return found


def _normal(z: float) -> float:
    return 0.5 * math.erfc(-z / math.sqrt(2))


def _spread(forces: TireForces, wheel: str) -> tuple[FloatArray, bool]:
    """Standard deviation of a wheel's force; wider where it read below nought, which no force is, and whether it did."""
    std = (forces.high[wheel] - forces.low[wheel]) / (2 * _95)
    values = forces.value[wheel]
    known = values[np.isfinite(values)]
    # a single wild sample is not a zero that is off: the reading below which a thousandth of the drive lies
    below = -float(np.quantile(known, 0.001)) if len(known) else 0.0
    wrong = below > 2 * float(np.nanmedian(std)) if np.isfinite(std).any() else False
    return (np.maximum(std, below / 1.5) if wrong else std), wrong


def _light(forces: TireForces, wheel: str, static: float, period_s: float) -> tuple[list[_Light], bool]:
    """Light stretches of one wheel, and whether its sensor's zero is off."""
    values = forces.value[wheel]
    std, wrong = _spread(forces, wheel)
    with np.errstate(invalid="ignore"):
        light = np.isfinite(values) & (values < LIGHT * static + 1.645 * np.where(np.isfinite(std), std, 0.0))
    joined: list[tuple[int, int]] = []
    for first, past in runs(light):
        if (
            joined
            and (first - joined[-1][1]) * period_s < APART_S
            and np.isfinite(values[joined[-1][0] : past]).all()
        ):
            joined[-1] = (joined[-1][0], past)
        else:
            joined.append((first, past))
    found = []
    for first, past in joined:
        if (past - first) * period_s < SHORTEST_S - 1e-9:
            continue
        part = np.sort(values[first:past])
        # the mean of the lowest tenth of a second, so that one noisy sample does not lift a wheel
        least = float(part[: max(1, min(len(part), round(0.1 / period_s)))].mean())
        error = max(float(np.nanmedian(std[first:past])), 1e-6)
        chance = _normal((GONE * static - least) / error)
        if chance >= LEAST_PROBABILITY:
            found.append(_Light(wheel, first, past, least, error, chance))
    return found, wrong


@dataclass(frozen=True)
class _Looked:
    """Forces and what events are judged by. static, slow (n,): by wheel; total: (n,) sum of the four; weight: at rest."""

    forces: TireForces
    static: dict[str, float]
    slow: dict[str, FloatArray]
    total: FloatArray
    weight: float
    period_s: float


def _look(forces: TireForces, motion: Motion | None) -> _Looked:
    static = statics(forces, motion)
    total = np.asarray(np.sum([forces.value[w] for w in WHEELS], axis=0))
    period = float(np.median(np.diff(forces.time_s)))
    known = sum(load for load in static.values() if np.isfinite(load))
    return _Looked(forces, static, slow_forces(forces), total, max(known, 1.0), period)


def _edges(values: FloatArray, event: _Light, reach: int) -> FloatArray:
    """(2,) how much lower `values` are `reach` rows inside an event's first and last edge than as far outside."""
    last = len(values) - 1
    found = []
    for row, side in ((event.first, -1), (event.past - 1, 1)):
        outside, inside = row + side * reach, row - side * reach
        there = 0 <= outside <= last and 0 <= inside <= last
        found.append(float(values[outside] - values[inside]) if there else 0.0)
    return np.asarray(np.nan_to_num(np.array(found)))


def _dropped_out(looked: _Looked, event: _Light) -> bool:
    """Whether a sensor failed: its force goes and comes back at once, and nobody takes over what the wheel lost.

    A turn unloads a wheel over some tenths of a second, and the outer wheels gain as much.
    """
    values = looked.forces.value[event.wheel]
    near, far = (
        max(reach, round(seconds / looked.period_s)) for reach, seconds in ((1, EDGE_S[0]), (2, EDGE_S[1]))
    )
    far = min(far, max(near, (event.past - event.first) // 2))
    lost = _edges(values, event, far)
    if lost.sum() < 4 * event.std:
        return False
    at_once = bool((_edges(values, event, near) >= AT_ONCE * lost).all())
    return at_once and float(_edges(looked.total, event, far).sum()) > MISSING * float(lost.sum())


def _lateral_at(motion: Motion | None, time_s: float) -> float | None:
    if motion is None or len(motion.time_s) == 0:
        return None
    row = int(np.clip(np.searchsorted(motion.time_s, time_s), 0, len(motion.time_s) - 1))
    if abs(float(motion.time_s[row]) - time_s) > 0.5:
        return None
    return float(motion.lateral[row])


def _kind(event: _Light, looked: _Looked, lateral: float | None) -> LiftKind | None:
    """A turn's lift ("wheel" until the other wheel of its side is looked at), a bounce; None for a dropout."""
    rows = slice(event.first, event.past)
    lasting = (event.past - event.first) * looked.period_s
    held = abs(float(np.nanmedian(looked.total[rows])) / looked.weight - 1) <= BALANCE
    if lasting >= DROPOUT_S and (not held or _dropped_out(looked, event)):
        return None
    side = 1.0 if event.wheel.endswith("l") else -1.0
    inner = lateral is None or side * lateral >= TURNING_G
    gone = float(np.nanmin(looked.slow[event.wheel][rows])) <= SLOW_SHARE * looked.static[event.wheel]
    return "wheel" if held and inner and gone and lasting >= TURN_S - 1e-9 else "bounce"


def _with_sides(events: list[tuple[_Light, WheelLift]]) -> list[WheelLift]:
    """A turn's lifts whose other wheel of the side is off at the same time become "side"."""
    found = []
    for light, event in events:
        other = {"fl": "rl", "rl": "fl", "fr": "rr", "rr": "fr"}[event.wheel]
        both = event.kind == "wheel" and any(
            e.kind == "wheel" and e.wheel == other and x.first < light.past and light.first < x.past
            for x, e in events
        )
        found.append(replace(event, kind="side") if both else event)
    return sorted(found, key=lambda e: (e.start_s, e.wheel))


def _events_of(
    wheel: str, looked: _Looked, motion: Motion | None
) -> tuple[list[tuple[_Light, WheelLift]], int, bool]:
    """One wheel's events, how many dropouts were passed by, and whether its sensor's zero is off."""
    forces, period = looked.forces, looked.period_s
    found, wrong = _light(forces, wheel, looked.static[wheel], period)
    events = []
    for light in found:
        start, last = float(forces.time_s[light.first]), float(forces.time_s[light.past - 1])
        lateral = _lateral_at(motion, 0.5 * (start + last))
        kind = _kind(light, looked, lateral)
        if kind is not None:
            lasting = last - start + period
            event = WheelLift(
                wheel, kind, start, lasting, light.least, light.probability, lateral, forces.source
            )
            events.append((light, event))
    return events, len(found) - len(events), wrong


def lifts_of_forces(
    forces: TireForces, motion: Motion | None
) -> tuple[tuple[WheelLift, ...], tuple[str, ...]]:
    """Events of all four wheels in order of time, and notes on sensors."""
    if len(forces.time_s) < 4:
        return (), ("too few tyre forces to look for wheel lift",)
    looked = _look(forces, motion)
    notes: list[str] = []
    events: list[tuple[_Light, WheelLift]] = []
    dropped = 0
    for wheel in WHEELS:
        if not looked.static[wheel] > 0:
            notes.append(f"tyre force {wheel} is not positive at rest: no lift is looked for there")
            continue
        found, lost, wrong = _events_of(wheel, looked, motion)
        events += found
        dropped += lost
        if wrong:
            notes.append(
                f"tyre force {wheel} reads below nought: its zero is off, and its interval was widened"
            )
    if dropped:
        notes.append(
            f"{dropped} times a tyre force was near nought while nobody else carried its load: sensor dropouts, no lift"
        )
    if motion is None:
        notes.append("no lateral acceleration: a turn's lift was told from the forces alone")
    listed = _with_sides(events)
    if len(listed) > MOST_EVENTS:
        notes.append(f"{len(listed)} unloadings; the {MOST_EVENTS} most sure are listed")
        listed = sorted(listed, key=lambda e: (e.kind == "bounce", -e.probability))[:MOST_EVENTS]
        listed.sort(key=lambda e: (e.start_s, e.wheel))
    return tuple(listed), tuple(notes)
