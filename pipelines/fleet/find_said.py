"""What users say in drive.toml files, applied to the recordings that were found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from parsers.errors import CogestError
from parsers.small_text import read_small_text
from pipelines.fleet.drive_file import FILE_NAME, DriveFile, DriveFileError, SaidDrive, parse_drive_file
from pipelines.fleet.entries import Entry, Listing
from pipelines.fleet.logs import Log
from pipelines.fleet.together import Together


@dataclass
class Said:
    """What users said. taken: names (below the fleet's folder) of logs that are in a drive, or left out.

    separate: folders in which nothing is guessed; lacks: what must be said of every drive there.
    """

    drives: list[Together] = field(default_factory=list)
    taken: set[str] = field(default_factory=set)
    separate: set[str] = field(default_factory=set)
    lacks: dict[str, tuple[str, ...]] = field(default_factory=dict)
    left_out: list[tuple[str, str]] = field(default_factory=list)


def said_drives(listing: Listing, logs: Mapping[str, Log]) -> Said:
    """Read every drive.toml in the listing. logs: all recordings by their names below the fleet's folder."""
    said = Said()
    for entry in listing.entries:
        if entry.name != FILE_NAME:
            continue
        try:
            content = _read(entry)
        except DriveFileError as error:
            said.separate.add(entry.folder)
            lack = f"{FILE_NAME} cannot be used ({error.problem}): its folder's logs are taken one by one"
            said.lacks[entry.folder] = (lack,)
            continue
        _apply(content, entry, logs, said)
    return said


def _read(entry: Entry) -> DriveFile:
    try:
        return parse_drive_file(read_small_text(entry.path), entry.place)
    except OSError as error:
        raise DriveFileError(f"cannot be read ({error.strerror or error})", path=entry.place) from error
    except UnicodeDecodeError:
        raise DriveFileError("not UTF-8 text", path=entry.place) from None
    except CogestError as error:
        raise DriveFileError(error.problem, path=entry.place) from error


def _apply(content: DriveFile, entry: Entry, logs: Mapping[str, Log], said: Said) -> None:
    """Put what one file says into effect."""
    before = f"{entry.folder}/" if entry.folder else ""
    if content.separate:
        said.separate.add(entry.folder)
    for below, log in logs.items():
        if below.startswith(before) and content.leaves_out(below[len(before) :]):
            said.taken.add(below)
            said.left_out.append((log.place, f"left out by {FILE_NAME}"))
    for drive in content.drives:
        found, missing = _named(drive, before, logs, said.taken)
        lacks = tuple(f"{FILE_NAME} names {name}, which is no log that is there" for name in missing)
        if not found:
            said.left_out.append((entry.place, f"none of its logs is there: {', '.join(drive.logs[:3])}"))
            continue
        said.taken |= {log.below for log in found}
        name = f"{before}{drive.name}" if drive.name else None
        note = f"{FILE_NAME} says that {', '.join(log.name for log in found)} are one drive"
        notes = (note,) if len(found) > 1 else ()
        said.drives.append(Together(tuple(found), notes, lacks, name, drive.start_utc))


def _named(
    drive: SaidDrive, before: str, logs: Mapping[str, Log], taken: set[str]
) -> tuple[Sequence[Log], Sequence[str]]:
    """The logs that a drive names, and the names that are none (any more)."""
    found, missing = [], []
    for name in drive.logs:
        log = logs.get(before + name)
        if log is None or log.below in taken:
            missing.append(name)
        else:
            found.append(log)
    return found, missing
