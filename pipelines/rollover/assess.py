"""How near a drive came to rolling over: limits, margins, wheel lift and probability, from the verdict and the log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from pipelines.models.roll import GRAVITY
from pipelines.results import Estimate, FloatArray, ParameterEstimate
from pipelines.rollover.body import Body, draw_body
from pipelines.rollover.check import by_forces, compare, onto, slow_forces, spread_of_forces
from pipelines.rollover.draws import summary
from pipelines.rollover.lift import lifts_of_forces
from pipelines.rollover.lift_transfer import lifts_of_accelerations
from pipelines.rollover.margin import DriveMargin, measure, traces, turn_margins
from pipelines.rollover.motion import (
    CUTOFF_HZ,
    FELL_RAD,
    Motion,
    fitted_gradient,
    prepare_motion,
    read_motion,
)
from pipelines.rollover.probability import exceedance, lifted_by_forces, unknown
from pipelines.rollover.threshold import limits, stability_factor
from pipelines.rollover_results import CoefficientCheck, Rollover, RolloverLimit, TurnSide, WheelLift
from pipelines.tire_forces import TireForces, tire_forces
from pipelines.vehicles.vehicle import Vehicle

COVERED = 0.95
_95 = 1.959964


@dataclass(frozen=True)
class _Forces:
    """Tyre forces and what follows from them alone: coefficient (n,) on their own clock."""

    forces: TireForces
    coefficient: FloatArray
    peak: ParameterEstimate | None
    peak_time_s: float | None


def _read_forces(drive: Drive, estimates: Sequence[Estimate]) -> _Forces | None:
    forces = tire_forces(estimates, drive)
    if forces is None or len(forces.time_s) < 4:
        return None
    slow = slow_forces(forces)
    coefficient = by_forces(slow)
    if not np.isfinite(coefficient).any():
        return None
    row = int(np.nanargmax(np.abs(coefficient)))
    value, std = float(min(abs(coefficient[row]), 1.0)), spread_of_forces(forces, slow, row)
    peak = ParameterEstimate(
        "peak_coefficient", value, std, max(value - _95 * std, 0.0), min(value + _95 * std, 1.0), "identified",
        f"(158) from tyre forces, {forces.source}", None, None, ("tyre forces",),
    )  # fmt: skip
    return _Forces(forces, coefficient, peak, float(forces.time_s[row]))


def _lower(body: Body, left: ParameterEstimate, right: ParameterEstimate) -> ParameterEstimate:
    """The threshold of the side that lifts first, under its old name."""
    first = left if (left.value or 0.0) <= (right.value or 0.0) else right
    text = "left turns" if first is left else "right turns"
    kept = {"value": first.value, "std": first.std, "low": first.low, "high": first.high}
    return ParameterEstimate(
        "threshold_g", kept["value"], kept["std"], kept["low"], kept["high"], first.status,
        f"the lower of both sides ({text}); {first.reason}", None, first.reference, body.told.sources,
    )  # fmt: skip


def _peak(motion: Motion) -> tuple[float, float]:
    row = int(np.argmax(np.abs(motion.lateral)))
    return float(abs(motion.lateral[row])), float(motion.time_s[row])


def _lifts(
    read: _Forces | None, found: DriveMargin | None, motion: Motion | None, mass: float | None
) -> tuple[tuple[WheelLift, ...], str, tuple[str, ...]]:
    """Events, where their forces are from, and notes."""
    if read is not None:
        events, notes = lifts_of_forces(read.forces, motion)
        return events, read.forces.source, notes
    if found is not None:
        weight = None if mass is None else mass * GRAVITY
        events = lifts_of_accelerations(found.table, found.factors, found.motion, found.peak, weight)
        return (
            events,
            "load transfer with the verdict's parameters: no tyre forces in the log, and only the sum of a side",
            (),
        )
    return (
        (),
        "not known: the log has no tyre forces, and load transfer needs the CG height, the track and lateral acceleration",
        (),
    )


def _without_body(motion: Motion | None, read: _Forces | None, why: str, notes: list[str]) -> Rollover:
    """What can be said of a drive of a vehicle whose height or track is not known."""
    events, source, more = _lifts(read, None, motion, None)
    peak = None if motion is None else _peak(motion)
    if motion is None:
        notes.append("no peak: the log has no usable lateral acceleration")
    else:
        notes.append(
            f"peak of the lateral acceleration along the road, low-passed at {CUTOFF_HZ:g} Hz; {motion.how[0]}"
        )
    return Rollover(
        None, None, None if peak is None else peak[0],
        None if read is None or read.peak is None else read.peak.value,
        None if peak is None else peak[1], (*notes, *more),
        peak_coefficient=None if read is None else read.peak,
        coefficient_source="" if read is None else f"tyre forces, {read.forces.source}",
        lifts=events, lift_source=source, exceedance=unknown(why),
    )  # fmt: skip


def assess_rollover(
    verdict: Mapping[str, ParameterEstimate],
    vehicle: Vehicle,
    drive: Drive,
    estimates: Sequence[Estimate] = (),
) -> Rollover:
    """Limits with intervals, margins to both sides, wheel lift, probability of having exceeded the threshold.

    estimates: all of this drive; one may hold tyre normal forces. Parts that cannot be told are None, and a note says why.
    """
    prepared = prepare_motion(drive)
    body = draw_body(verdict, vehicle, fitted_gradient(prepared, vehicle))
    mass = verdict.get("mass_kg")
    mass_kg = None if mass is None else mass.value
    known = None if isinstance(body, str) else body
    motion = read_motion(prepared, vehicle, known, mass_kg)
    read = _read_forces(drive, estimates)
    if isinstance(body, str):
        return _without_body(motion, read, body, [f"no static stability factor: {body}"])
    table = limits(body, vehicle)
    last = table[-1]
    factor, threshold = stability_factor(body, vehicle), _lower(body, last.left, last.right)
    notes = (
        [] if body.gradient_known else ["the roll gradient is not known: that of a usual vehicle was taken"]
    )
    if motion is None:
        notes.append("no peak: the log has no usable lateral acceleration")
        events, source, more = _lifts(read, None, None, mass_kg)
        return Rollover(
            factor, threshold, notes=(*notes, *more), limits=table, lifts=events, lift_source=source,
            exceedance=unknown("the log has no usable lateral acceleration"), assumptions=body.assumptions,
            peak_rollover_coefficient=None if read is None or read.peak is None else read.peak.value,
            peak_coefficient=None if read is None else read.peak,
            coefficient_source="" if read is None else f"tyre forces, {read.forces.source}",
        )  # fmt: skip
    return _driven(body, motion, read, (factor, threshold), table, notes, mass_kg)


def _covers(read: _Forces, motion: Motion) -> bool:
    """Whether the tyre forces are there for (nearly) all of the motion."""
    return float(np.mean(np.isfinite(onto(motion, read.forces.time_s, read.coefficient)))) >= COVERED


def _driven(
    body: Body, motion: Motion, read: _Forces | None, pair: tuple[ParameterEstimate, ParameterEstimate],
    table: tuple[RolloverLimit, ...], notes: list[str], mass_kg: float | None,
) -> Rollover:  # fmt: skip
    found = measure(motion, body)
    notes += [f"lateral acceleration along the road, low-passed at {CUTOFF_HZ:g} Hz", *motion.how]
    last = table[-1]
    each: dict[TurnSide, ParameterEstimate] = {"left": last.left, "right": last.right}
    reason = f"CG height {body.told.status.replace('_', ' ')}; {motion.how[0]}"
    events, source, more = _lifts(read, found, motion, mass_kg)
    told = read is not None and _covers(read, motion)
    reached = lifted_by_forces(events) if told else found.reached
    if motion.fell is not None:
        reached = {**reached, motion.fell.turn: 1.0}
        notes.append(
            f"the body rolled beyond {np.degrees(FELL_RAD):.0f} degrees at {motion.fell.time_s:.1f} s: far beyond any suspension, if not over; what came after is left out"
        )
    turns = turn_margins(found, each, reached, reason)
    across: FloatArray | None = None
    check: CoefficientCheck | None = None
    coefficient = summary(
        "peak_coefficient", np.minimum(found.either, 1.0), body.told.status, reason, sources=body.told.sources
    )
    by = "accelerations and body roll, (160)"
    if read is not None:
        across = onto(motion, read.forces.time_s, read.coefficient)
        check = compare(found, across)
        if read.forces.measured and read.peak is not None:
            coefficient, by = read.peak, f"tyre forces, {read.forces.source}, (158)"
    peak, peak_time = _peak(motion)
    guessed = motion.steady and not body.gradient_known
    return Rollover(
        pair[0], pair[1], peak, coefficient.value, peak_time, (*notes, *more), peak_coefficient=coefficient,
        coefficient_source=by, limits=table, turns=turns, lifts=events, lift_source=source,
        exceedance=exceedance(reached, body, by_forces=told, guessed_roll=guessed), check=check,
        traces=traces(found, across), assumptions=body.assumptions,
    )  # fmt: skip
