"""What a drive says against its own figures, in words: for the table of vehicles, whose joined answers are made of such drives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from parsers.drive import DecisionKind, ImportRecord
from pipelines.drive_results import DriveResults
from pipelines.hierarchy.records import VehicleKnowledge
from pipelines.results import JointVerdict

NAMED = 3
"""Drives that are named with a doubt; of more there is the number."""
MOST = 40
"""Doubts of one drive, and of one vehicle: a table repeats the latter in every row."""

OF_THE_WHOLE: tuple[DecisionKind, ...] = ("load", "zero", "vehicle", "scale")
"""Findings in a log that doubt what goes with it (a load that changed, another vehicle's file), whatever was done."""
UNLESS_MENDED: tuple[DecisionKind, ...] = ("sign", "unit", "spikes")


def doubts_of(results: DriveResults) -> tuple[str, ...]:
    """A drive's doubts, each once: that its file or log must be wrong, relations that disagree, causes that it speaks for, findings in the log."""
    refused = [entry.refused.rstrip("; ") for entry in results.verdict.values() if entry.refused]
    return _first([*refused, *_of_relations(results.joint), *_of_log(results.record)])


def _first(doubts: Sequence[str]) -> tuple[str, ...]:
    """Each once, and how many more there are than are told."""
    once = list(dict.fromkeys(doubts))
    more = len(once) - MOST
    return tuple(once if more <= 0 else [*once[:MOST], f"and {more} more"])


def _of_relations(joint: JointVerdict | None) -> list[str]:
    if joint is None:
        return []
    against = [
        f"{check.relation} contradicts the rest"
        for check in joint.relations
        if check.widened > 1 or not math.isfinite(check.widened)
    ]
    return [*against, *joint.spoke_for, *(f"ended far from what was known: {text}" for text in joint.far)]


def _of_log(record: ImportRecord) -> list[str]:
    whole = (
        [] if record.status == "complete" else [f"the log is {record.status}: only what was whole is used"]
    )
    found = [d.found for d in record.decisions if d.kind in OF_THE_WHOLE]
    left = [
        f"{d.found}: not corrected" for d in record.decisions if d.kind in UNLESS_MENDED and not d.applied
    ]
    return [*whole, *found, *left]


def vehicle_doubts(
    knowledge: VehicleKnowledge, said: Mapping[str, Sequence[str]], names: Mapping[str, str]
) -> list[str]:
    """What is to be doubted of a vehicle's joined answers: what was done with its drives, and what those that were joined doubt.

    said: drive_id -> `doubts_of`; names: drive_id -> its name for people; both in the order of time.
    """
    treated = [note for drive_id in names for note in knowledge.drive_notes.get(drive_id, ())]
    who: dict[str, list[str]] = {}
    for drive_id, doubts in said.items():
        # one that the join does not have says nothing of it
        for doubt in doubts if drive_id not in knowledge.apart else ():
            who.setdefault(doubt, []).append(names[drive_id])
    # what most drives say first
    often = sorted(who.items(), key=lambda item: -len(item[1]))
    return list(
        _first([*knowledge.notes, *treated, *(f"{_listed(drives)}: {doubt}" for doubt, drives in often)])
    )


def _listed(names: Sequence[str]) -> str:
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
