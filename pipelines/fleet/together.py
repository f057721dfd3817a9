"""What grouping works on: recordings taken together so far, and what can be asked of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from pipelines.fleet.clocks import Clock
from pipelines.fleet.logs import Log
from pipelines.fleet.names import numbered, recorder_name

OVERLAP_SHARE = 0.5
"""Recorders of one drive run together for at least this share of the longer one."""


@dataclass(frozen=True)
class Moments:
    """Mean and standard deviation of a signal, in SI."""

    mean: float
    std: float


class Facts(Protocol):
    """What is asked of recordings whose names say that they may belong together."""

    def clock(self, log: Log) -> Clock | None:
        """When it begins and ends; None where that is not quickly told."""
        ...

    def content(self, log: Log) -> Mapping[str, Moments] | None:
        """Its signals; None where it is too large to be read for this, or cannot be."""
        ...


@dataclass(frozen=True)
class Together:
    """Recordings of one drive, the first names it. name, start_utc: as a user said. notes, lacks: as of `FoundDrive`."""

    logs: tuple[Log, ...]
    notes: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()
    name: str | None = None
    start_utc: str | None = None

    def saying(self, *, note: str = "", lack: str = "") -> Together:
        """The same with a sentence more."""
        return replace(
            self,
            notes=(*self.notes, note) if note else self.notes,
            lacks=(*self.lacks, lack) if lack else self.lacks,
        )


@dataclass
class Grouped:
    """What became of a folder's recordings. left_out: (place, why). notes: sentences for a recording, by its place."""

    drives: list[Together] = field(default_factory=list)
    left_out: list[tuple[str, str]] = field(default_factory=list)
    notes: dict[str, tuple[str, ...]] = field(default_factory=dict)


def words_of(unit: Together) -> tuple[tuple[str, ...], tuple[str, ...], str]:
    """Of a unit's name: the drive's words, the recorder's kinds, and the stem that other recorders may share."""
    stem = unit.logs[0].stem
    found = numbered(stem)
    stem = stem.casefold()
    if len(unit.logs) > 1 and found.number is not None:
        stem = found.row.replace("\0", found.moment or "")
    words = recorder_name(stem)
    kinds = tuple(word.rstrip("0123456789") for word in words.recorder)
    drive = words.drive
    if found.moment is not None and kinds:
        # two recorders are not switched on in the same second
        drive = recorder_name(found.row.replace("\0", " ")).drive
    return drive, kinds, stem


def united(units: Sequence[Together], why: str) -> Together:
    """One drive of several; the first by name names it."""
    ranked = sorted(units, key=lambda unit: unit.logs[0].name)
    logs = tuple(log for unit in ranked for log in unit.logs)
    names = ", ".join(unit.logs[0].name for unit in ranked)
    notes = tuple(note for unit in ranked for note in unit.notes)
    return Together(
        logs, (*notes, f"{names} are {why}"), tuple(lack for unit in ranked for lack in unit.lacks)
    )


def clock_of_all(unit: Together, facts: Facts) -> Clock | None:
    """From the first recording's begin to the last one's end; None where that is not known of each."""
    clocks = [facts.clock(log) for log in unit.logs]
    known = [clock for clock in clocks if clock is not None]
    if len(known) < len(clocks):
        return None
    return Clock(
        min(c.first_ns for c in known), max(c.last_ns for c in known), all(c.absolute for c in known)
    )


def run_together(a: Together, b: Together, facts: Facts) -> bool:
    """Whether two run at the same time by the wall clock, for most of the longer one."""
    first, second = clock_of_all(a, facts), clock_of_all(b, facts)
    if first is None or second is None or not (first.absolute and second.absolute):
        return False
    both = min(first.last_ns, second.last_ns) - max(first.first_ns, second.first_ns)
    return both > 0 and both >= OVERLAP_SHARE * max(first.duration_ns, second.duration_ns)
