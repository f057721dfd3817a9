"""Finding the drives in a folder: what is a log, what belongs together, which vehicle it is. Nothing is dropped in silence.

vehicle_id: `id` of the [vehicle] table where the vehicle file has one; else the folder (below the fleet's) of the topmost
vehicle.toml whose [vehicle] table is that of the nearest one, "." for the fleet's own folder and above; without any vehicle
file the top folder in which the log lies, and the drive's own name for a log that lies in the fleet's folder itself.
The rules are in docs/fleet_folder.md.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace

from parsers.places_text import masked
from pipelines.discover import SETTINGS
from pipelines.fleet.belongings import MAP, OWN, Belongings, VehicleFacts, distinct, top_folder
from pipelines.fleet.entries import Listing
from pipelines.fleet.find_facts import LookedUp
from pipelines.fleet.find_said import said_drives
from pipelines.fleet.group import group_folder
from pipelines.fleet.heads import Heads
from pipelines.fleet.likeness import Likeness, likeness
from pipelines.fleet.listing import Lister, list_any
from pipelines.fleet.logs import Log
from pipelines.fleet.names import drive_id
from pipelines.fleet.recordings import recordings
from pipelines.fleet.records import BatchError, FoundDrive, FoundFleet
from pipelines.fleet.together import Together

_NEEDS_DBC = frozenset(("blf", "asc", "trc", "candump"))


def find_drives(folder: str, store: str | None = None, lister: Lister = list_any) -> FoundFleet:
    """All drives under a folder or URL; the store's own place is passed over.

    Reads the first bytes of each file, and more only of recordings whose names say that they may belong together. Raises
    BatchError where there is no such folder, or no log in it.
    """
    listing = lister(folder, store)
    belongings = Belongings.of(listing)
    found = recordings(listing, Heads(belongings.read_options))
    said = said_drives(listing, found.by_name)
    facts = LookedUp(belongings)
    drives = [*said.drives]
    drives += [
        Together(logs, (why,)) for logs, why in found.joint if not said.taken & {log.below for log in logs}
    ]
    left_out = [*listing.left_out, *found.left_out, *said.left_out]
    for where in sorted(found.single):
        logs = [log for log in found.single[where] if log.below not in said.taken]
        if where in said.separate:
            drives += [Together((log,), lacks=said.lacks.get(where, ())) for log in logs]
            continue
        grouped = group_folder(logs, facts)
        drives += grouped.drives
        left_out += grouped.left_out
    if not drives:
        raise BatchError("no log in this folder", path=masked(folder), hint=_instead(listing, left_out))
    made = _marked_twins(_with_vehicles(drives, belongings), drives)
    return FoundFleet(
        listing.root,
        tuple(sorted(made, key=lambda d: (d.name, d.drive_id))),
        tuple(sorted(left_out)),
        tuple(listing.unread),
    )


def _instead(listing: Listing, left_out: Sequence[tuple[str, str]]) -> str:
    """What to do about a folder without a log."""
    if left_out:
        return f"it holds {len(left_out)} files or folders that are none, such as {masked(left_out[0][0])}: {left_out[0][1]}"
    return "it is empty" if not listing.entries else "give the folder with the logs"


def _marked_twins(found: Sequence[FoundDrive], drives: Sequence[Together]) -> list[FoundDrive]:
    """Say of drives that hold the same bytes, or for the most part the same, that they do. drives: those that `found` was made of, in the same order.

    Of one vehicle they count once; for several vehicles they count, and can be of one of them only.
    """
    rows: dict[tuple[int, bytes], list[tuple[Log, FoundDrive]]] = defaultdict(list)
    for drive, each in zip(found, drives, strict=True):
        log = each.logs[0]
        if len(each.logs) == 1 and log.size and log.digest:
            rows[(log.size, log.digest)].append((log, drive))
    said: dict[str, FoundDrive] = {}
    for row in rows.values():
        kept: list[tuple[Log, FoundDrive]] = []
        for log, drive in row:
            how, original = _likest(log, kept)
            if original is None or how is Likeness.MOSTLY:
                kept.append((log, drive))
            if original is not None:
                said[drive.drive_id] = _twin(drive, original, how)
    return [said.get(drive.drive_id, drive) for drive in found]


def _likest(log: Log, others: Sequence[tuple[Log, FoundDrive]]) -> tuple[Likeness, FoundDrive | None]:
    """The first drive that holds all that a log does, else the first that holds most of it."""
    mostly: FoundDrive | None = None
    for other, drive in others:
        how = likeness(other, log)
        if how in (Likeness.SAME, Likeness.ENDS):
            return how, drive
        if how is Likeness.MOSTLY and mostly is None:
            mostly = drive
    return Likeness.MOSTLY, mostly


def _twin(drive: FoundDrive, original: FoundDrive, how: Likeness) -> FoundDrive:
    """A drive that says how its log holds what another's does."""
    same, once = f"{how.value} {original.name}", drive.vehicle_id == original.vehicle_id
    if how is Likeness.MOSTLY:
        counts = "once only where both begin at one moment of a known date" if once else "for both vehicles"
        wrong = f"{same}: one of the two is damaged or was changed, and they count {counts}; remove one"
        return replace(drive, lacks=(*drive.lacks, wrong))
    if once:
        return replace(drive, notes=(*drive.notes, f"{same}: for their vehicle they count once"))
    wrong = f"{same}, which is of vehicle {original.vehicle_id}: it counts for both vehicles; remove one"
    return replace(drive, lacks=(*drive.lacks, wrong))


def _with_vehicles(drives: Sequence[Together], belongings: Belongings) -> list[FoundDrive]:
    """The drives as records, each with what belongs to it."""
    made = [_made(drive, belongings) for drive in drives]
    ids = distinct([(found.vehicle_id, own) for found, own in made])
    return [replace(found, vehicle_id=vehicle) for (found, _), vehicle in zip(made, ids, strict=True)]


def _made(drive: Together, belongings: Belongings) -> tuple[FoundDrive, bool]:
    """A drive's record, and whether its vehicle file itself says which vehicle it is."""
    folder = drive.logs[0].folder
    name = drive.name or _name_of(drive, belongings)
    own = drive_id(name, [log.below for log in drive.logs])
    # a bag's own folder may hold the vehicle's file
    inside = (
        drive.logs[0].below
        if not drive.logs[0].digest and drive.logs[0].below in belongings.files
        else folder
    )
    beside = [(log.folder, log.name) for log in drive.logs]
    vehicle = belongings.vehicle(inside, beside)
    dbc = belongings.databases(inside)
    said = vehicle is not None and vehicle.id is not None
    settings = belongings.nearest(SETTINGS, inside, beside)
    problem = belongings.settings_problem(settings) if settings is not None else ""
    unusable = (f"the settings file cannot be used, and the drive will fail: {problem}",) if problem else ()
    found = FoundDrive(
        drive_id=own,
        name=name,
        logs=tuple(log.place for log in drive.logs),
        vehicle=vehicle.place if vehicle else None,
        vehicle_id=_vehicle_id(drive, vehicle, folder if _own(vehicle) else inside, belongings, name),
        vehicle_name=vehicle.name if vehicle else None,
        map=belongings.nearest(MAP, inside, beside),
        settings=settings,
        dbc=dbc,
        formats=tuple(dict.fromkeys(log.title for log in drive.logs)),
        size=sum(log.size for log in drive.logs),
        notes=drive.notes,
        lacks=(*_lacks(drive, vehicle, dbc), *unusable, *drive.lacks),
        start_utc=drive.start_utc,
    )
    return found, said


def _own(vehicle: VehicleFacts | None) -> bool:
    """Whether a vehicle file is a log's own."""
    return vehicle is not None and vehicle.place.endswith(OWN)


def _name_of(drive: Together, belongings: Belongings) -> str:
    first = drive.logs[0]
    if first.below == ".":
        return belongings.root_name
    return first.below if len(drive.logs) == 1 else f"{first.below} +{len(drive.logs) - 1}"


def _vehicle_id(
    drive: Together, vehicle: VehicleFacts | None, folder: str, belongings: Belongings, name: str
) -> str:
    if vehicle is None:
        return top_folder(drive.logs[0].below) or name
    if vehicle.id is not None:
        return vehicle.id
    return belongings.vehicle_folder(folder, vehicle) or "."


def _lacks(drive: Together, vehicle: VehicleFacts | None, dbc: Sequence[str]) -> tuple[str, ...]:
    """What a user should know before the work."""
    several = len(drive.logs) > 1
    lacks = [
        f"{f'{log.name} ' if several else ''}will fail: {log.trouble}" for log in drive.logs if log.trouble
    ]
    if vehicle is None:
        top = top_folder(drive.logs[0].below)
        whose = (
            f"all logs under {top}/ count as one vehicle"
            if top
            else "the drive counts as a vehicle of its own"
        )
        lacks.append(
            "no vehicle.toml up the folders: mass, wheelbase and springs are not known, so that answers are wide or none, "
            f"and {whose}"
        )
    elif vehicle.problem:
        lacks.append(f"the vehicle file cannot be used, and the drive will fail: {vehicle.problem}")
    if not dbc and any(log.format in _NEEDS_DBC for log in drive.logs):
        lacks.append("no *.dbc beside the log or above it: only standard (J1939) messages can be decoded")
    return tuple(lacks)


def by_vehicle(drives: Sequence[FoundDrive]) -> Mapping[str, list[FoundDrive]]:
    """Drives by their vehicle, both in order."""
    rows: dict[str, list[FoundDrive]] = defaultdict(list)
    for drive in sorted(drives, key=lambda each: (each.vehicle_id, each.name)):
        rows[drive.vehicle_id].append(drive)
    return rows
