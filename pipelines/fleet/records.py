"""Records of a fleet: a drive that was found, what a drive's work is, and how a batch ended."""

from __future__ import annotations

from dataclasses import dataclass, field

from parsers.errors import CogestError
from parsers.places_text import masked


@dataclass(frozen=True)
class FoundDrive:
    """One drive in the fleet's folder. Places are absolute paths or URLs, as text.

    drive_id: a short name of its own, safe as a folder's name on every system; the same as long as its logs' names
    below the fleet's folder are the same. name: its logs' common name below the fleet's folder, for people. logs: its
    recordings, first the one that names it. vehicle, map, settings: the nearest file up the folders. dbc: CAN databases
    beside the logs. vehicle_id: which vehicle, see `pipelines.fleet.find`. formats: titles of the logs' formats. size:
    bytes of all logs. notes: why recordings were taken together, what was left out. lacks: what a user should know before
    the work ("no vehicle.toml up the folders: …"), in words. start_utc: when the zero of its stamps was, where a drive.toml
    says it; for logs that do not know it themselves.
    """

    drive_id: str
    name: str
    logs: tuple[str, ...]
    vehicle: str | None
    vehicle_id: str
    vehicle_name: str | None
    map: str | None
    settings: str | None
    dbc: tuple[str, ...]
    formats: tuple[str, ...]
    size: int
    notes: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()
    start_utc: str | None = None


@dataclass(frozen=True)
class FoundFleet:
    """All drives under a folder, by name. left_out: (place, why) of files that are no log, or that cannot be used.

    unread: names below the folder of what could not be looked into: drives that lay there are not known to be gone.
    """

    folder: str
    drives: tuple[FoundDrive, ...]
    left_out: tuple[tuple[str, str], ...] = ()
    unread: tuple[str, ...] = ()

    def hides(self, name: str) -> bool:
        """Whether a drive of this name may lie in what could not be looked into."""
        return any(name == below or name.startswith(f"{below}/") for below in self.unread)

    def left_out_below(self) -> tuple[tuple[str, str], ...]:
        """What was left out, by its name below the folder where it lies there."""
        return tuple((_below(place, self.folder), why) for place, why in self.left_out)


def _below(place: str, folder: str) -> str:
    inside = place[len(folder) :].lstrip("/\\") if place.startswith(folder) else ""
    return inside or masked(place)


@dataclass(frozen=True)
class Choices:
    """What is the same for all drives of a batch. formats: of the drives' own reports ("html", "pdf"); () = none."""

    estimators: str | None = None
    seed: int = 0
    fix: bool = True
    formats: tuple[str, ...] = ("html",)
    version: str = ""


@dataclass(frozen=True)
class Facts:
    """What an input file was when its content was hashed: while size and stamp stay, it is not hashed again.

    size: bytes. stamp: of its last change (mtime in ns, or an object store's tag); "" = always hash again. sha256: of its
    content, in hex; of a folder: of the names and content of all its files.
    """

    size: int
    stamp: str
    sha256: str


@dataclass(frozen=True)
class Job:
    """One drive's work, as it goes to a worker (as JSON). key: hash of all that the results depend on.

    store: the store's place. command: what the user typed, for the drive's report.
    """

    drive: FoundDrive
    choices: Choices
    store: str
    key: str
    command: str = ""


@dataclass(frozen=True)
class Ended:
    """How one drive ended. status: as `pipelines.engines.base.TaskStatus`, or "kept" where it was done before."""

    drive: FoundDrive
    status: str
    reason: str = ""
    seconds: float = 0.0
    worker: str = ""


@dataclass(frozen=True)
class BatchSummary:
    """How a batch ended. found, kept (done before), done (now), failed; gone: drives in the store whose logs are no more;
    moved: those whose logs are another drive of the folder now."""

    found: int
    kept: int
    done: int
    failed: tuple[Ended, ...] = field(default=())
    gone: int = 0
    seconds: float = 0.0
    moved: int = 0


class BatchError(CogestError):
    """A batch cannot be started: no such folder, no log in it."""
