"""Drives of a store whose logs are no longer where they were: gone, or only moved to another place of the folder."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field

from parsers.errors import LogError
from parsers.places_text import masked
from pipelines.fleet.keys import facts_of
from pipelines.fleet.records import FoundDrive, FoundFleet
from pipelines.fleet.stored import Catalogue, StoredDrive

Content = tuple[str, ...]
"""The hashes of a drive's logs, in order."""


@dataclass(frozen=True)
class Lost:
    """Drives of a store whose logs are no longer in the folder under their names. gone: drive_ids, sorted (damaged ones too),
    without those that may lie in what could not be looked into.

    moved: drive_id -> the drive of the folder that has the same logs now.
    """

    gone: tuple[str, ...] = ()
    moved: Mapping[str, FoundDrive] = field(default_factory=dict)


def away(catalogue: Catalogue, found: FoundFleet) -> tuple[str, ...]:
    """The stored drives (damaged ones too) whose logs are no longer in the folder under their names, by drive_id."""
    there = {drive.drive_id for drive in found.drives}
    return tuple(sorted((catalogue.drives.keys() | catalogue.damaged.keys()) - there))


def hidden(catalogue: Catalogue, found: FoundFleet, drive_id: str) -> bool:
    """Whether a stored drive that was not found may still be there: where it lay, the folder could not be looked into."""
    stored = catalogue.drives.get(drive_id)
    return bool(found.unread) if stored is None else found.hides(stored.drive.name)


def lost(catalogue: Catalogue, found: FoundFleet) -> Lost:
    """What became of the drives that are no longer where they were.

    A log that was filed under another vehicle, or renamed, has its drive there: what the store holds of the old place must
    not count beside it. Logs are read only where a drive that is not stored yet is as large as one that is gone.
    """
    absent = away(catalogue, found)
    before = {
        drive_id: content
        for drive_id in absent
        if drive_id in catalogue.drives and (content := _stored_content(catalogue.drives[drive_id]))
    }
    sought = tuple(drive_id for drive_id in absent if not hidden(catalogue, found, drive_id))
    if not before:
        return Lost(sought)
    sizes = {catalogue.drives[drive_id].drive.size for drive_id in before}
    now: dict[Content, FoundDrive] = {}
    for drive in found.drives:
        stored = catalogue.drives.get(drive.drive_id)
        content = _stored_content(stored) if stored is not None else ()
        if not content and drive.size in sizes:
            content = _content_now(drive)
        if content:
            now.setdefault(content, drive)
    moved = {drive_id: now[content] for drive_id, content in before.items() if content in now}
    return Lost(tuple(drive_id for drive_id in sought if drive_id not in moved), moved)


def _stored_content(stored: StoredDrive) -> Content:
    """What a drive's logs were when it was done; () where that is not known."""
    facts = [stored.facts.get(masked(place)) for place in stored.drive.logs]
    return tuple(one.sha256 for one in facts if one is not None) if all(facts) else ()


def _content_now(drive: FoundDrive) -> Content:
    with contextlib.suppress(LogError):
        return tuple(facts_of(place).sha256 for place in drive.logs)
    return ()
