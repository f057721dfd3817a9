"""A drive as a store keeps it: what its drive.json says, and where it lies."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from parsers.places_text import masked
from pipelines.fleet.records import Facts, FoundDrive
from pipelines.fleet.storage import checked

DRIVES = "drives"
"""The folder of all drives' folders."""


@dataclass(frozen=True)
class Sealed:
    """A file of a drive's folder as it was written. size: bytes. sha256: in hex."""

    size: int
    sha256: str


@dataclass(frozen=True)
class StoredDrive:
    """A drive's folder in the store, as its drive.json tells it.

    status: "done", or as `pipelines.engines.base.TaskStatus` with the reason in words. key: see `pipelines.fleet.keys`; "" =
    to be done again.
    facts: place of an input -> what it was when the key was made. files: name -> its seal, all files but drive.json.
    """

    drive: FoundDrive
    key: str
    status: str
    reason: str = ""
    facts: Mapping[str, Facts] = field(default_factory=dict)
    files: Mapping[str, Sealed] = field(default_factory=dict)

    def fresh(self, key: str, formats: Iterable[str] = ()) -> bool:
        """Whether it need not be done again: done, with this key, and a report in each of these formats is there."""
        reports = (f"report.{name}" for name in formats)
        return self.status == "done" and self.key == key != "" and all(name in self.files for name in reports)


@dataclass(frozen=True)
class Catalogue:
    """All drives of a store. damaged: drive_id -> what is wrong with its folder; such a drive is to be done again."""

    drives: Mapping[str, StoredDrive]
    damaged: Mapping[str, str]


def folder_of(drive_id: str) -> str:
    """The drive's folder below the store: thousands of drives are spread over 256 folders."""
    spread = hashlib.sha256(drive_id.encode("utf-8", "surrogateescape")).hexdigest()[:2]
    return checked(f"{DRIVES}/{spread}/{drive_id}")


def sealed(content: bytes) -> Sealed:
    """The seal of a file's content."""
    return Sealed(len(content), hashlib.sha256(content).hexdigest())


def shown_drive(drive: FoundDrive) -> FoundDrive:
    """A drive as it was found, with places as they may be shown."""
    return replace(
        drive,
        logs=tuple(masked(place) for place in drive.logs),
        vehicle=None if drive.vehicle is None else masked(drive.vehicle),
        map=None if drive.map is None else masked(drive.map),
        settings=None if drive.settings is None else masked(drive.settings),
        dbc=tuple(masked(place) for place in drive.dbc),
    )


def shown(stored: StoredDrive) -> StoredDrive:
    """The drive with places as they may be shown: a store is passed on, a URL's password is not."""
    return replace(
        stored,
        drive=shown_drive(stored.drive),
        facts={masked(place): facts for place, facts in stored.facts.items()},
    )
