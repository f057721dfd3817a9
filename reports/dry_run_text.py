"""What `cogest batch --dry-run` prints: the drives by vehicle, what would be done, what lacks what, what was left out and why."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from parsers.places_text import masked
from pipelines.fleet.batch import Absent
from pipelines.fleet.find import by_vehicle
from pipelines.fleet.outlook import ASKED, Outlook
from pipelines.fleet.records import FoundDrive, FoundFleet
from pipelines.fleet.stored import shown_drive
from reports.layout import printable, table, terminal_width, wrapped
from reports.text import spec_of

WOULD: dict[str, str] = {
    "new": "do: new",
    "changed": "do: changed",
    "again": "do: again",
    "failed before": "failed before",
    "kept": "keep: done",
}
"""State -> the word in the list."""

_NAMED = 4
"""So many files that were left out for one reason are named."""

NO_DATE = (
    "no date in the log: the drive comes last among its vehicle's, and counts for no trend; "
    "a drive.toml's start_utc says when it was"
)


def size_text(size: int) -> str:
    """Bytes as people say them."""
    value = float(size)
    for unit in ("B", "kB", "MB", "GB"):
        if value < 999.5:
            return f"{value:.0f} {unit}" if unit == "B" or value >= 9.95 else f"{value:.1f} {unit}"
        value /= 1000
    return f"{value:.1f} TB"


def text(
    found: FoundFleet,
    state: Mapping[str, str],
    outlooks: Mapping[str, Outlook] | None = None,
    width: int | None = None,
    absent: Sequence[Absent] = (),
) -> str:
    """The whole answer for a terminal of so many columns; those of the terminal itself unless given.

    state: by drive_id, as in `WOULD`; a drive that is not in it is new. outlooks: by drive_id, where they were looked for.
    absent: drives of the store that are no longer where they were.
    """
    width = width or terminal_width()
    vehicles = by_vehicle(found.drives)
    lacks = {drive.drive_id: _lacks(drive, (outlooks or {}).get(drive.drive_id)) for drive in found.drives}
    lines = wrapped(_total(found, len(vehicles), state, lacks), width, indent=0)
    alone = [drives[0] for vehicle, drives in vehicles.items() if _is_alone(vehicle, drives)]
    for vehicle, drives in vehicles.items():
        if not _is_alone(vehicle, drives):
            lines += ["", printable(f"Vehicle {_whose(vehicle, drives)}"), *_table(drives, state, width)]
    if alone:
        lines += ["", "Without a vehicle file or a folder of its vehicle", *_table(alone, state, width)]
    notes = {drive.drive_id: drive.notes for drive in found.drives}
    told = {name: _outlook_texts(outlook) for name, outlook in (outlooks or {}).items()}
    for title, texts in (("Lacks", lacks), ("Notes", notes), ("Channels", told)):
        lines += _by_sentence(title, texts, vehicles, width)
    return "\n".join([*lines, *_absent_lines(absent, width), *_left_out_lines(found, width)])


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _lacks(drive: FoundDrive, outlook: Outlook | None) -> tuple[str, ...]:
    """What a user should know before the work, by the folder and by the logs."""
    undated = outlook is not None and not outlook.dated and drive.start_utc is None
    return (*drive.lacks, NO_DATE) if undated else drive.lacks


def _total(
    found: FoundFleet, vehicles: int, state: Mapping[str, str], lacks: Mapping[str, Sequence[str]]
) -> str:
    counts = Counter(state.get(drive.drive_id, "new") for drive in found.drives)
    said = ", ".join(f"{counts[word]} {word}" for word in WOULD if counts[word])
    size = size_text(sum(drive.size for drive in found.drives))
    lacking = sum(map(bool, lacks.values()))
    tail = f" {_many(lacking, 'drive')} {'lacks' if lacking == 1 else 'lack'} something." if lacking else ""
    return f"{masked(found.folder)}: {_many(len(found.drives), 'drive')} of {_many(vehicles, 'vehicle')}, {size}: {said}.{tail}"


def _is_alone(vehicle: str, drives: Sequence[FoundDrive]) -> bool:
    """Whether nothing says which vehicle a drive is of."""
    return len(drives) == 1 and drives[0].vehicle is None and drives[0].name == vehicle


def _whose(vehicle: str, drives: Sequence[FoundDrive]) -> str:
    name = next((drive.vehicle_name for drive in drives if drive.vehicle_name), None)
    return vehicle if name in (None, vehicle) else f"{vehicle}: {name}"


def _table(drives: Sequence[FoundDrive], state: Mapping[str, str], width: int) -> list[str]:
    rows = [["drive", "size", "would", "format"]]
    for drive in drives:
        word = state.get(drive.drive_id, "new")
        rows.append([drive.name, size_text(drive.size), WOULD.get(word, word), ", ".join(drive.formats)])
    return table(rows, width, right=(1,), names=(0,))


def _by_sentence(
    title: str,
    texts: Mapping[str, Sequence[str]],
    vehicles: Mapping[str, Sequence[FoundDrive]],
    width: int,
) -> list[str]:
    """Each sentence once, with the drives that it is true of. texts: by drive_id."""
    of: dict[str, set[str]] = defaultdict(set)
    for name, sentences in texts.items():
        for sentence in sentences:
            of[sentence].add(name)
    lines = ["", title] if of else []
    for sentence, names in of.items():
        lines += wrapped(f"{_whom(names, vehicles)}: {sentence}", width, hang=2)
    return lines


def _whom(names: set[str], vehicles: Mapping[str, Sequence[FoundDrive]]) -> str:
    """Drives in words: all, whole vehicles, or their names."""
    if len(names) > 1 and len(names) == sum(map(len, vehicles.values())):
        return "all"
    words = []
    for vehicle, drives in vehicles.items():
        mine = [drive for drive in drives if drive.drive_id in names]
        if len(drives) > 1 and len(mine) == len(drives):
            words.append(f"all of {vehicle}")
        else:
            words += [drive.name for drive in mine]
    return _some(words)


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(names[:_NAMED])
    return f"{shown} and {len(names) - _NAMED} more" if len(names) > _NAMED else shown


def _outlook_texts(outlook: Outlook | None) -> list[str]:
    """What a drive could tell, in sentences that drives with the same channels share."""
    if outlook is None:
        return []
    if outlook.problem:
        return [outlook.problem]
    ready = ", ".join(outlook.ready) or "none"
    asked = [
        spec_of(name).title for name in ASKED if name not in {parameter for parameter, _ in outlook.cannot}
    ]
    texts = [f"{_many(len(outlook.signals), 'signal')}; can run: {ready}"]
    if asked:
        texts.append(f"may tell: {', '.join(asked)}")
    return [*texts, *(f"cannot tell: {spec_of(name).title}; {lack}" for name, lack in outlook.cannot)]


def _absent_lines(absent: Sequence[Absent], width: int) -> list[str]:
    """Drives of the store that are no longer where they were."""
    if not absent:
        return []
    lines = ["", f"In the store and no longer at their place: {_many(len(absent), 'drive')}"]
    for drive in absent:
        if drive.moved_to is not None:
            lines += wrapped(f"{drive.name}: moved to {drive.moved_to}, and counts there alone", width)
    gone = [drive.name or drive.drive_id for drive in absent if drive.moved_to is None]
    if gone:
        kept = "the logs are gone; what they told of their vehicle still counts, and --prune takes it out"
        lines += wrapped(f"{_some(gone)}: {kept}", width)
    return lines


def _left_out_lines(found: FoundFleet, width: int) -> list[str]:
    """What was left out, by reason."""
    if not found.left_out:
        return []
    by_reason: dict[str, list[str]] = defaultdict(list)
    for name, why in found.left_out_below():
        by_reason[why].append(name)
    lines = ["", f"Left out: {len(found.left_out)} (files or folders)"]
    for why, places in by_reason.items():
        lines += wrapped(f"{why}: {_some(places)}", width)
    return lines


def plan_dict(
    found: FoundFleet,
    state: Mapping[str, str],
    outlooks: Mapping[str, Outlook] | None = None,
    absent: Sequence[Absent] = (),
) -> dict[str, Any]:
    """The same as plain values, for JSON: folder, drives (with `would`, and `outlook` where it was looked for), left_out,
    absent (drives of the store that are no longer where they were)."""
    outlooks = outlooks or {}
    drives: list[dict[str, Any]] = []
    for drive in found.drives:
        told = outlooks.get(drive.drive_id)
        entry = {
            **asdict(shown_drive(drive)),
            "would": state.get(drive.drive_id, "new"),
            "lacks": list(_lacks(drive, told)),
        }
        if told is not None:
            entry["outlook"] = asdict(told)
        drives.append(entry)
    left_out = [{"place": masked(place), "why": why} for place, why in found.left_out]
    return {
        "folder": masked(found.folder),
        "drives": drives,
        "left_out": left_out,
        "absent": [asdict(drive) for drive in absent],
    }
