"""What limited a result, in words, the weightiest first: for the report's first screen."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from parsers.drive import ImportRecord
from parsers.mapping.overlooked import SAID as OVERLOOKED
from parsers.timebase import MAX_GAPS
from pipelines.joint.conflict import BEYOND_DOUBT
from pipelines.joint.rests import hanging_on, moved_by
from pipelines.parameters import PARAMETERS
from pipelines.prepare.gravity import GRAVITY_ADDED
from pipelines.results import Estimate, JointVerdict, ParameterEstimate
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.measured import known_body
from pipelines.vehicles.spring_base import spring_base
from pipelines.vehicles.unheard_of import (
    LEAST_FRONT,
    MOST_FRONT,
    TRACKS_APART,
    front_share,
    odd_axles,
    tracks_apart,
)
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.missing import by_lack

MOST_MOVED = 3
"""Answers that are named with a rate that moves them."""

HANGING = "This drive hardly checks the file's"
"""Of a sentence on what answers hang on."""

FILE_AGAINST_ITSELF, FILE_UNLIKE = "The vehicle file contradicts itself", "The vehicle file puts"


def _data_limits(record: ImportRecord) -> list[str]:
    limits: list[str] = []
    if record.status != "complete":
        limits.append(f"The log is {record.status}: only what was whole is used.")
    whole = [gap for gap in record.gaps if gap.signal is None]
    if whole:
        missing = sum(gap.end_s - gap.start_s for gap in whole)
        more = "At least " if len(whole) >= MAX_GAPS else ""
        limits.append(
            f"{more}{len(whole)} gap{'s' if len(whole) > 1 else ''} in the log, "
            f"{missing:.1f} s of {record.duration_s:.1f} s: "
            "nothing is interpolated across a gap."
        )
    if record.clock_jumps:
        limits.append(
            f"The clock jumped {record.clock_jumps} time{'s' if record.clock_jumps > 1 else ''}: "
            "rows whose stamps do not fit the longest stretch are left out."
        )
    doubtful = [d for d in record.decisions if not d.applied and d.kind in ("sign", "unit", "spikes")]
    limits += [f"{d.found[:1].upper()}{d.found[1:]}: not corrected." for d in doubtful]
    return limits


def _overlooked(record: ImportRecord) -> list[str]:
    """Channels that nobody knows and that look like what the log lacks: a mapping file makes signals of them."""
    return [f"{note[:1].upper()}{note[1:]}." for note in record.notes if note.startswith(OVERLOOKED)]


def _load_changed(record: ImportRecord) -> list[str]:
    """That the drive holds two loads (`prepare.load_step`), and what to do."""
    return [
        f"{d.found[:1].upper()}{d.found[1:]}: split the drive there. What hangs on the load is weak, and half of what the load changes of it is in its spread."
        for d in record.decisions
        if d.kind == "load"
    ]


def _zero_open(record: ImportRecord) -> list[str]:
    """That the deflections look zeroed under the load (`prepare.deflection_zero`) or the unit leans (`prepare.level_unit`), and what to state."""
    return [
        f"{d.found[:1].upper()}{d.found[1:]}. {d.action[:1].upper()}{d.action[1:]}."
        for d in record.decisions
        if d.kind in ("zero", "mount")
    ]


def _another_vehicle(record: ImportRecord) -> list[str]:
    """That the drive turns unlike the vehicle file's vehicle (`prepare.steered`)."""
    return [
        f"{d.found[:1].upper()}{d.found[1:]}: is the file this vehicle's?"
        for d in record.decisions
        if d.kind == "vehicle"
    ]


def _changed(record: ImportRecord) -> list[str]:
    """That samples are used otherwise than they were logged, beyond units and signs: all that rests on them hangs on it."""
    return [
        f"{d.found[:1].upper()}{d.found[1:]} ({d.evidence}): {d.action}; --no-fix uses it as it was logged."
        for d in record.decisions
        if d.kind == "choice" and d.applied and d.action.startswith(GRAVITY_ADDED)
    ]


def _not_run(estimates: Sequence[Estimate], record: ImportRecord) -> list[str]:
    """What was skipped; where nothing ran, what the log gives and what the method that lacks least lacks, as an example."""
    skipped = [e for e in estimates if e.status == "skipped"]
    if not skipped:
        return []
    if not any(e.status == "ran" for e in estimates):
        nearest = by_lack(skipped)[0]
        given = ", ".join(entry.signal for entry in record.mapped if entry.used) or "none"
        return [
            f"No method could run. Signals that this log gives: {given}.",
            f"For example, {nearest.estimator} {nearest.reason}.",
            "What each of the others lacks stands under Estimators.",
        ]
    methods = f"{len(skipped)} of {len(estimates)} methods"
    return [f"{methods} did not run, for what the log or the vehicle file lacks: see Estimators."]


def _two_stiffnesses(vehicle: Vehicle) -> list[str]:
    """That a file's roll stiffness is not what its springs and bars make, which are used where all are there."""
    total = vehicle.get("roll_stiffness_nmprad")
    made = variance = 0.0
    for axle in ("front", "rear"):
        spring, bar = (
            vehicle.get(f"spring_rate_{axle}_npm"),
            vehicle.get(f"anti_roll_stiffness_{axle}_nmprad"),
        )
        track = spring_base(vehicle, axle)
        if total is None or spring is None or bar is None or track is None:
            return []
        lever = 0.5 * track.value**2
        made += lever * spring.value + bar.value
        variance += (lever * spring.std) ** 2 + bar.std**2
    if total is None or abs(total.value - made) < max(
        0.1 * made, 3 * math.hypot(total.std, math.sqrt(variance))
    ):
        return []
    return [
        f"{FILE_AGAINST_ITSELF}: roll_stiffness_nmprad is {total.value:.0f}, its springs and bars make {made:.0f} "
        "(½ spring rate × spring base² + bar, of both axles; the base is the track where none is given): springs and bars are used."
    ]


def _unheard_of(vehicle: Vehicle) -> list[str]:
    """That a file puts more of the empty vehicle on one axle, or into it, than any such vehicle has there."""
    share, place = front_share(vehicle), vehicle.get("cg_to_front_axle_m")
    said = []
    if share is not None and place is not None:
        said.append(
            f"{FILE_UNLIKE} {share:.1%} of the empty mass on the front axle (cg_to_front_axle_m {place.value:.3f}, wheelbase_m): hardly any car, "
            f"van or pickup has less than {LEAST_FRONT:.0%} or more than {MOST_FRONT:.0%}; are those figures from the front axle, and of this vehicle?"
        )
    for axle, part in odd_axles(vehicle).items():
        usual = usual_unsprung(vehicle, axle, 1.0)[0]
        said.append(
            f"{FILE_UNLIKE} {part:.2%} of the empty mass into the {axle} axle with its wheels (unsprung_mass_{axle}_kg); "
            f"{usual:.1%} is usual of such vehicles: is that figure of both wheels, and of this vehicle?"
        )
    tracks = tracks_apart(vehicle)
    if tracks is not None:
        mean, apart = tracks
        said.append(
            f"{FILE_UNLIKE} the {'front' if apart > 0 else 'rear'} wheels {abs(apart) * mean * 1000:.0f} mm further apart than the "
            f"{'rear' if apart > 0 else 'front'} ones (track_front_m, track_rear_m): hardly any such vehicle's differ by more "
            f"than {TRACKS_APART[kind_of(vehicle)] * mean * 1000:.0f} mm; is one of them mistyped?"
        )
    return said


def _unchecked(verdict: Mapping[str, ParameterEstimate]) -> list[str]:
    """Which figures of the file the answers hang on without the drive checking them: such a one, if wrong, makes them wrong unseen."""
    pieces = []
    for key, names in hanging_on(verdict).items():
        whole = [name for name in names if not name.startswith("corner_mass_")]
        titles = [_title(name) for name in whole] + (["corner masses"] if len(whole) < len(names) else [])
        pieces.append(f"{key} ({', '.join(titles)})")
    for key, moved in moved_by(verdict).items():
        unit = {name: PARAMETERS[name].unit for name in moved}
        told = [f"{_title(name)} by {by} {unit[name]}" for name, by in list(moved.items())[:MOST_MOVED]]
        pieces.append(f"{key} (10 % off would move {', '.join(told)})")
    if not pieces:
        return []
    return [f"{HANGING} {_listed(pieces)}: if one is wrong, so is what hangs on it."]


def _title(name: str) -> str:
    """A parameter within a sentence."""
    title = PARAMETERS[name].title
    return title[:1].lower() + title[1:] if title[1:2].islower() else title


def _listed(pieces: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(pieces[:-1]), pieces[-1])))


def _contradiction(joint: JointVerdict | None) -> list[str]:
    """That something is surely wrong, and what most likely."""
    surely = [r.relation for r in joint.relations if r.probability < BEYOND_DOUBT] if joint else []
    if not surely:
        return []
    return [
        f"The log and the vehicle file contradict each other beyond doubt ({', '.join(surely)}): is it this vehicle's file, "
        "and is each channel what its name says? Nothing that rests on them is called identified."
    ]


def what_limits(
    record: ImportRecord,
    estimates: Sequence[Estimate],
    verdict: Mapping[str, ParameterEstimate],
    vehicle: Vehicle,
    joint: JointVerdict | None = None,
    *,
    file_given: bool = False,
) -> tuple[str, ...]:
    """Sentences: what the estimators lacked, what the vehicle file left open, what the data lost. file_given: whether there is a vehicle file at all."""
    skipped = _not_run(estimates, record)
    # the weightiest first: that nothing ran, or, where something did, at the end what else could have
    nothing_ran = not any(e.status == "ran" for e in estimates)
    limits = list(skipped) if nothing_ran else []
    limits += [
        *_overlooked(record),
        *_load_changed(record),
        *_zero_open(record),
        *_another_vehicle(record),
        *_changed(record),
        *_contradiction(joint),
        *_two_stiffnesses(vehicle),
        *_unheard_of(vehicle),
        *_unchecked(verdict),
    ]
    limits += [f"{e.estimator} failed: {e.reason}." for e in estimates if e.status == "failed"]
    height = verdict.get("cg_height_m")
    if height is not None and height.status != "identified":
        limits.append(f"CG height {height.status.replace('_', ' ')}: {height.reason}")
    if not vehicle.quantities:
        limits.append(
            "The vehicle file states no mass, track or springs."
            if file_given
            else "No vehicle file: mass, track and springs are unknown; give one with --vehicle."
        )
    elif vehicle.body is not None and known_body(vehicle.body) is None and vehicle.get("cg_height_m") is None:
        limits.append(
            f"No measured vehicle is called {vehicle.body!r}: its CG height before the drive is wide open."
        )
    if vehicle.quantities and not vehicle.load_stated:
        unsaid = vehicle.load_unsaid
        limits.append(f"{unsaid[:1].upper()}{unsaid[1:]}: the drive's load is taken as unknown.")
    return tuple(dict.fromkeys([*limits, *_data_limits(record), *skipped]))
