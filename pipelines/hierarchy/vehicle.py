"""What all drives of one vehicle say together."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

from pipelines.hierarchy.answers import drive_answers, vehicle_answers
from pipelines.hierarchy.changes import load_changes
from pipelines.hierarchy.join import Joined, joined, usable
from pipelines.hierarchy.records import Apart, DriveTold, LoadChange, Trend, VehicleKnowledge
from pipelines.hierarchy.trends import trends

_MISFIT: Apart = "misfit"


def _chance(log_probability: float) -> str:
    return f"{math.exp(log_probability):.1g}" if log_probability > -230 else "less than 1e-99"


def notes_of(found: Joined) -> tuple[str, ...]:
    """What is to be said of the vehicle: which drives were not joined, and whether all stand alone."""
    notes = []
    silent = [d.drive_id for d in found.drives if not usable(d)]
    if silent:
        notes.append(f"nothing to join in {len(silent)} of {len(found.drives)} drives: {_listed(silent)}")
    if found.apart:
        notes.append("the vehicle's drives contradict each other: each stands on its own")
    return tuple(notes)


def drive_notes_of(found: Joined) -> dict[str, tuple[str, ...]]:
    """What was done with drives that do not go with the others, by drive."""
    notes: dict[str, list[str]] = defaultdict(list)
    for drive_id, misfit in sorted(found.left_out.items()):
        notes[drive_id].append(
            f"{drive_id} does not go with the vehicle's other drives (probability {_chance(misfit.log_probability)} by "
            "chance): another vehicle or vehicle file, changed parts, or a sensor that was moved; it was left out"
        )
    for drive_id, misfit in sorted(found.other_sensors.items()):
        what = f" ({misfit.about.replace('_', ' ')})" if misfit.about else ""
        notes[drive_id].append(
            f"{drive_id} goes with the others only as recorded by other sensors, or by sensors that were moved or calibrated "
            f"anew{what}: its sensors' errors are taken as its own"
        )
    for drive_id, factor in sorted(found.widened.items()):
        notes[drive_id].append(
            f"{drive_id} goes with the others only with its errors {factor:.2g} x as large: it counts less"
        )
    return {drive_id: tuple(said) for drive_id, said in notes.items()}


def _listed(names: Sequence[str]) -> str:
    more = len(names) - 3
    return ", ".join(names[:3]) + (f" and {more} more" if more > 0 else "")


def join_vehicle(vehicle_id: str, drives: Sequence[DriveTold]) -> VehicleKnowledge:
    """Join the drives of one vehicle, in any order. A drive that told nothing, or contradicts the others, keeps its own
    verdict, and a single drive is its verdict."""
    found = joined(drives)
    changes: tuple[LoadChange, ...] = ()
    drifts: tuple[Trend, ...] = ()
    if found.posterior is not None:
        changes = load_changes(found.posterior, found.drives)
        drifts = trends(found.posterior, found.drives)
    misfits = {} if found.apart else dict.fromkeys(sorted(found.left_out), _MISFIT)
    return VehicleKnowledge(
        vehicle_id, vehicle_answers(found), drive_answers(found), changes, drifts, notes_of(found), drive_notes_of(found),
        misfits,
    )  # fmt: skip
