"""From the drives in a store to the fleet's tables: vehicle by vehicle, in one order, so that the same drives give the same bytes.

A drive whose logs are no longer in the folder stays in the tables and counts for its vehicle: what it told stays true when
a log is moved away. Its column `gone` says so, and `prune` takes it out. A log that was moved within the folder counts as
the drive that it is now, and its old place is in no table: that drive's notes say where it was.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import polars as pl

from parsers.errors import StoreError
from parsers.places_text import masked
from pipelines.fleet.copies import Finished
from pipelines.fleet.doubts import vehicle_doubts
from pipelines.fleet.joined import DamagedDriveError, Join, joined, tidy
from pipelines.fleet.moved import Lost, away, hidden, lost
from pipelines.fleet.records import FoundDrive, FoundFleet
from pipelines.fleet.rows import DriveRows
from pipelines.fleet.store import Catalogue, Store, StoredDrive
from pipelines.fleet.tables import TABLES
from pipelines.hierarchy.outliers import FEWEST, TYPICAL, rank
from pipelines.hierarchy.records import Outlier, VehicleKnowledge
from pipelines.hierarchy.rows import (
    Row,
    change_rows,
    drive_rows,
    outlier_rows,
    parameter_rows,
    trend_rows,
    vehicle_rows,
)
from pipelines.starts import best_start

Rank = Callable[[Sequence[VehicleKnowledge], Mapping[str, str]], Sequence[Outlier]]


@dataclass(frozen=True)
class _Drive:
    """A drive of the store. rows: None where it failed. key: as stored."""

    found: FoundDrive
    status: str
    reason: str
    gone: bool
    stored: StoredDrive | None
    rows: DriveRows | None

    @property
    def start_utc(self) -> str | None:
        """As the log says it, else as the user does (drive.toml); without an offset where neither knows the time zone."""
        return best_start(self.rows.start_utc if self.rows is not None else None, self.found.start_utc)

    @property
    def order(self) -> tuple[bool, str, str, str]:
        """By time where it is known, then by name."""
        start = self.start_utc
        return start is None, start or "", self.found.name, self.found.drive_id


def prune(store: Store, found: FoundFleet) -> tuple[str, ...]:
    """Take the drives out of the store whose logs are no longer in the folder, or at another place of it; their drive_ids.

    Those that lay where the folder could not be looked into now (a share that is away) stay.
    """
    catalogue = store.all()
    absent = tuple(drive_id for drive_id in away(catalogue, found) if not hidden(catalogue, found, drive_id))
    for drive_id in absent:
        store.forget(drive_id)
    return absent


def gather(
    store: Store,
    found: FoundFleet,
    join: Join,
    rank_of: Rank = rank,
    told: Callable[[str], None] | None = None,
    began: Collection[str] | None = None,
) -> dict[str, pl.DataFrame]:
    """The tables of `TABLES`, of all drives in the store; those that were found but not stored yet are left out.

    join: `pipelines.hierarchy.vehicle.join_vehicle`. A vehicle whose drives cannot be joined costs that vehicle alone; its
    drives' notes say so. told: is given each vehicle_id before its drives are joined. began: drive_ids in the store
    when the folder was looked through, None = all: one that came since is of another batch, whose folder held its logs. Memory: one vehicle's relations, and
    the tables themselves.
    """
    catalogue = store.all()
    vehicles = _by_vehicle(catalogue, found, lost(catalogue, found), began)
    frames: dict[str, list[pl.DataFrame]] = {name: [] for name in TABLES}
    known: list[VehicleKnowledge] = []
    bodies: dict[str, str | None] = {}
    names: dict[str, str | None] = {}
    for vehicle_id in sorted(vehicles):
        if told is not None:
            told(vehicle_id)
        read = [_read(store, drive) for drive in vehicles[vehicle_id]]
        drives, knowledge, notes = _joined(store, vehicle_id, read, join)
        names[vehicle_id] = next((d.found.vehicle_name for d in drives if d.found.vehicle_name), None)
        bodies[vehicle_id] = next((d.rows.body for d in drives if d.rows is not None and d.rows.body), None)
        if knowledge is not None:
            known.append(_slim(knowledge))
        for name, rows in _vehicle_tables(store, found, drives, knowledge, names[vehicle_id], notes).items():
            frames[name].append(_frame(name, rows))
    tidy(store, sorted(vehicles))
    outliers = rank_of(known, kinds(names, bodies))
    frames["outliers"].append(_frame("outliers", outlier_rows(outliers, names)))
    return {name: pl.concat([_frame(name, []), *parts], rechunk=True) for name, parts in frames.items()}


def kinds(names: Mapping[str, str | None], bodies: Mapping[str, str | None]) -> dict[str, str]:
    """With which others each vehicle is compared: those of its name and body where enough share both, else those of its body.

    names, bodies: vehicle_id -> as the vehicle file says. A vehicle of no known body that few share a name with is left out.
    """
    shared = Counter((names[vehicle], bodies[vehicle]) for vehicle in names if names[vehicle])
    made: dict[str, str] = {}
    for vehicle, name in names.items():
        body = bodies[vehicle]
        if name and shared[name, body] >= FEWEST:
            made[vehicle] = f"{name}, {body}"
        elif body:
            made[vehicle] = f"any {body}"
    return made


def _by_vehicle(
    catalogue: Catalogue, found: FoundFleet, absent: Lost, began: Collection[str] | None
) -> dict[str, list[_Drive]]:
    """All drives by vehicle but for the old places of those that were moved; what is told of a drive is what was found now,
    else what was found when it was stored."""
    now = {drive.drive_id: drive for drive in found.drives}
    for drive_id, drive in absent.moved.items():
        old, known = catalogue.drives[drive_id].drive, now[drive.drive_id]
        whose = f" of vehicle {old.vehicle_id}" if old.vehicle_id != known.vehicle_id else ""
        now[drive.drive_id] = replace(known, notes=(*known.notes, f"moved here from {old.name}{whose}"))
    vehicles: dict[str, list[_Drive]] = {}
    for drive_id, stored in catalogue.drives.items():
        if drive_id in absent.moved:
            continue
        drive = now.get(drive_id, stored.drive)
        new = began is not None and drive_id not in began
        gone = drive_id not in now and not new and not found.hides(drive.name)
        made = _Drive(drive, stored.status, stored.reason, gone, stored, None)
        vehicles.setdefault(drive.vehicle_id, []).append(made)
    for drive_id in catalogue.damaged.keys() & now.keys():
        made = _damaged(now[drive_id], catalogue.damaged[drive_id])
        vehicles.setdefault(made.found.vehicle_id, []).append(made)
    return vehicles


def _damaged(found: FoundDrive, problem: str, *, is_gone: bool = False) -> _Drive:
    then = "its logs are no longer in the folder" if is_gone else "the next batch does it again"
    reason = f"its folder in the store is damaged ({problem}); {then}"
    return _Drive(found, "error", reason, is_gone, None, None)


def _read(store: Store, drive: _Drive) -> _Drive:
    """The drive with its rows."""
    if drive.stored is None or drive.status != "done":
        return drive
    try:
        rows = store.rows(drive.stored)
    except StoreError as error:
        return _doubted(store, drive, error.problem)
    if rows is None:
        return _doubted(store, drive, "rows.json is missing")
    return replace(drive, rows=rows)


def _doubted(store: Store, drive: _Drive, problem: str) -> _Drive:
    """A drive of which a file is not what was written: the next batch does it again, if its logs are still there.

    One that another batch has done since the store was looked through is read as it is now.
    """
    now = store.stored(drive.found.drive_id)
    if now is not None and now != drive.stored:
        return _read(store, replace(drive, stored=now, status=now.status, reason=now.reason, rows=None))
    if drive.stored is not None and not drive.gone:
        store.doubt(drive.stored)
    return _damaged(drive.found, problem, is_gone=drive.gone)


def _joined(
    store: Store, vehicle_id: str, read: Sequence[_Drive], join: Join
) -> tuple[list[_Drive], VehicleKnowledge | None, tuple[str, ...]]:
    """The vehicle's drives in order, what they say together, and why they could not be joined. A damaged drive costs itself alone."""
    drives = sorted(read, key=lambda drive: drive.order)
    done = [drive for drive in drives if drive.rows is not None]
    told = [
        Finished(d.stored, d.rows, d.start_utc) for d in done if d.stored is not None and d.rows is not None
    ]
    if not told:
        return drives, None, ()
    try:
        knowledge = joined(store, vehicle_id, told, join)
    except DamagedDriveError as error:
        bad = done[error.number]
        rest = [_doubted(store, drive, str(error)) if drive is bad else drive for drive in drives]
        return _joined(store, vehicle_id, rest, join)
    except Exception as error:
        # whatever goes wrong in one vehicle's figures must not cost the others their tables
        why = str(error).partition("\n")[0] or type(error).__name__
        return drives, None, (f"the drives of its vehicle could not be joined: {why}",)
    return drives, knowledge, ()


def _slim(knowledge: VehicleKnowledge) -> VehicleKnowledge:
    """What comparing vehicles needs of one: all vehicles are in memory then."""
    drives = {
        drive_id: {name: answers[name] for name in TYPICAL if name in answers}
        for drive_id, answers in knowledge.drives.items()
    }
    return replace(knowledge, drives=drives, load_changes=(), trends=())


def _vehicle_tables(
    store: Store,
    fleet: FoundFleet,
    drives: Sequence[_Drive],
    knowledge: VehicleKnowledge | None,
    vehicle_name: str | None,
    notes: tuple[str, ...],
) -> dict[str, list[Row]]:
    """One vehicle's rows of each table but the outliers."""
    starts = {drive.found.drive_id: drive.start_utc for drive in drives}
    parameters: list[Row] = []
    for drive in drives:
        if drive.rows is not None:
            found, verdict = drive.found, drive.rows.verdict
            parameters += parameter_rows(found.vehicle_id, found.drive_id, drive.start_utc, "drive", verdict)
    made: dict[str, list[Row]] = {"drives": [_drive_row(store, fleet, d, knowledge, notes) for d in drives]}
    if knowledge is not None:
        parameters += drive_rows(knowledge, starts)
        said = {drive.found.drive_id: drive.rows.doubts for drive in drives if drive.rows is not None}
        called = {drive.found.drive_id: drive.found.name for drive in drives}
        made["vehicles"] = vehicle_rows(knowledge, vehicle_name, vehicle_doubts(knowledge, said, called))
        made["load_changes"] = change_rows(knowledge, starts)
        made["trends"] = trend_rows(knowledge)
    place = {drive.found.drive_id: number for number, drive in enumerate(drives)}
    parameters.sort(key=lambda r: (place[str(r["drive_id"])], str(r["parameter"]), str(r["source"])))
    return {**made, "parameters": parameters}


def _drive_row(
    store: Store, fleet: FoundFleet, drive: _Drive, knowledge: VehicleKnowledge | None, notes: tuple[str, ...]
) -> Row:
    """notes: why the vehicle's drives could not be joined."""
    found, rows, stored = drive.found, drive.rows, drive.stored
    if knowledge is not None:
        notes = (*notes, *knowledge.notes_for(found.drive_id))
    row: Row = {
        "drive_id": found.drive_id,
        "drive": found.name,
        "vehicle_id": found.vehicle_id,
        "vehicle_name": found.vehicle_name,
        "status": drive.status,
        "reason": drive.reason,
        "start_utc": drive.start_utc,
        "format": ", ".join(found.formats),
        "log_bytes": found.size,
        "logs": [_below(place, fleet.folder) for place in found.logs],
        "key": None if stored is None else stored.key,
        "notes": [*found.notes, *found.lacks, *(notes if rows is not None else ())],
        "report": None if stored is None else store.report(stored),
        "gone": drive.gone,
        "apart": None if knowledge is None else knowledge.apart.get(found.drive_id),
    }
    if rows is None:
        return row
    return {
        **row,
        "duration_s": rows.duration_s,
        "format": rows.format,
        "import_status": rows.import_status,
        "log_sha256": rows.log_sha256,
        "cogest": rows.cogest,
        **asdict(rows.rollover),
        "notes": [*found.notes, *found.lacks, *rows.notes, *notes],
    }


def _below(place: str, folder: str) -> str:
    """A log's name below the fleet's folder, so that a folder that was moved as a whole gives the same table."""
    shown, start = masked(place), masked(folder).rstrip("/\\")
    if start and shown.startswith(start) and shown[len(start) : len(start) + 1] in ("/", "\\"):
        return shown[len(start) + 1 :].replace("\\", "/")
    return shown


def _text(value: object) -> object:
    """Text as a table can hold it: a name from a log may hold bytes that are no text."""
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode("utf-8")
    return [_text(entry) for entry in value] if isinstance(value, list) else value


def _frame(name: str, rows: Iterable[Mapping[str, object]]) -> pl.DataFrame:
    """Rows as a table with the columns of `TABLES[name]`; what a row lacks is null."""
    made = list(rows)
    columns = {
        column: pl.Series(column, [_text(row.get(column)) for row in made], dtype=kind, strict=True)
        for column, kind in TABLES[name].items()
    }
    return pl.DataFrame(columns)
