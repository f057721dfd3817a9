"""What limited a result, in words, the weightiest first: for the report's first screen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from parsers.drive import ImportRecord
from parsers.mapping.overlooked import SAID as OVERLOOKED
from parsers.timebase import MAX_GAPS
from pipelines.file_limits import unchecked, unlike_any, with_two_stiffnesses
from pipelines.joint.conflict import BEYOND_DOUBT
from pipelines.prepare.gravity import GRAVITY_ADDED
from pipelines.results import Estimate, JointVerdict, ParameterEstimate
from pipelines.vehicles.measured import known_body
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.missing import by_lack


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
        *with_two_stiffnesses(vehicle),
        *unlike_any(vehicle),
        *unchecked(verdict),
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
