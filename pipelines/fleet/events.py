"""What happens in a batch, as records: for whoever watches it (a progress line, a log file, a script)."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import ClassVar, TypeAlias

from pipelines.fleet.records import BatchSummary


@dataclass(frozen=True)
class Found:
    """The first event: what is to do. drives: all that were found = to_do + kept. left_out: places that are no log.

    bytes_to_do: of the logs to do. folder, store: places as they may be shown. engine: its name; workers: how many, 0 = not known
    yet. version: of cogest. left_out_first: the first of them, each a name below the folder and why.
    """

    kind: ClassVar[str] = "found"
    drives: int
    to_do: int
    kept: int
    left_out: int
    bytes_to_do: int = 0
    folder: str = ""
    store: str = ""
    engine: str = ""
    workers: int = 0
    version: str = ""
    left_out_first: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Kept:
    """A drive that was done before and of which nothing changed.

    status: "done", or how it failed before, with its reason: a failure is not tried again either, unless asked for.
    """

    kind: ClassVar[str] = "kept"
    drive_id: str
    name: str
    vehicle_id: str
    status: str = "done"
    reason: str = ""


@dataclass(frozen=True)
class Started:
    """A drive was handed to the engine. bytes: of its logs. worker: who has it, in words, "" where not known yet."""

    kind: ClassVar[str] = "started"
    drive_id: str
    name: str
    bytes: int = 0
    worker: str = ""


@dataclass(frozen=True)
class DriveEnded:
    """A drive ended. status: as `pipelines.engines.base.TaskStatus`; reason: why not, in words, "" where "done".

    seconds: wall clock of the drive alone. number: how many ended so far, this one too; total: how many are to do.
    bytes: of its logs.
    """

    kind: ClassVar[str] = "ended"
    drive_id: str
    name: str
    vehicle_id: str
    status: str
    reason: str
    seconds: float
    worker: str
    number: int
    total: int
    bytes: int = 0


@dataclass(frozen=True)
class Joining:
    """All drives ended; those of each vehicle are now joined. vehicles: how many."""

    kind: ClassVar[str] = "joining"
    vehicles: int


@dataclass(frozen=True)
class Reported:
    """Tables and fleet report are written. paths: places as text."""

    kind: ClassVar[str] = "reported"
    paths: tuple[str, ...]


@dataclass(frozen=True)
class Finished:
    """The last event."""

    kind: ClassVar[str] = "finished"
    summary: BatchSummary


Event: TypeAlias = Found | Kept | Started | DriveEnded | Joining | Reported | Finished

Watcher: TypeAlias = Callable[[Event], None]
"""Is told of every event, in order, from one thread at a time."""


def no_watcher(event: Event) -> None:
    """A watcher that watches nothing."""


def to_all(*watchers: Watcher) -> Watcher:
    """One watcher that tells several, in their order."""

    def tell(event: Event) -> None:
        for watcher in watchers:
            watcher(event)

    return tell


def _number(value: object) -> object:
    """A float that JSON can hold: NaN and infinities are null, seconds are told to the millisecond."""
    if isinstance(value, float):
        return round(value, 3) if math.isfinite(value) else None
    return value


def _summary(summary: BatchSummary) -> dict[str, object]:
    return {
        "found": summary.found,
        "kept": summary.kept,
        "done": summary.done,
        "failed": len(summary.failed),
        "gone": summary.gone,
        "moved": summary.moved,
        "seconds": _number(summary.seconds),
        "failures": [
            {"drive_id": e.drive.drive_id, "name": e.drive.name, "status": e.status, "reason": e.reason}
            for e in summary.failed
        ],
    }


def event_json(event: Event, time: str | None = None) -> str:
    """An event as one line of JSON (RFC 8259, ASCII only, no line break within): "event", "time" if given, its fields.

    Keys are those of docs/batch.md; they stay, others may be added.
    """
    fields = _summary(event.summary) if isinstance(event, Finished) else asdict(event)
    head = {"event": event.kind} | ({} if time is None else {"time": time})
    return json.dumps(head | {name: _number(value) for name, value in fields.items()}, allow_nan=False)
