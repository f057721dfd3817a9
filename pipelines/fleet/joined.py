"""What a vehicle's drives said together, kept in the store: a vehicle of which no drive has changed is not joined again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from parsers.errors import StoreError
from pipelines.fleet.copies import Finished, copies_of
from pipelines.fleet.plain import from_plain, json_bytes, read_json
from pipelines.fleet.relations_file import FILE_NAME as RELATIONS
from pipelines.fleet.rows import FILE_NAME as ROWS
from pipelines.fleet.store import Store
from pipelines.hierarchy.records import Apart, DriveTold, VehicleKnowledge

VEHICLES = "vehicles"
FORMAT = 5
"""To be raised when the same drives would be joined to something else, or records change."""

_COPY: Apart = "copy"

Join = Callable[[str, Sequence[DriveTold]], VehicleKnowledge]
"""(vehicle_id, its drives in the order of time) -> what they say together; the same for the same drives."""


@dataclass(frozen=True)
class _Joined:
    """key: of the drives that went in. sum: of what they said, so that a damaged file is told from a sound one."""

    key: str
    knowledge: VehicleKnowledge
    sum: str = ""


class DamagedDriveError(Exception):
    """What a drive's relations told cannot be read. number: of the drive among those given."""

    def __init__(self, number: int, problem: str) -> None:
        super().__init__(problem)
        self.number = number


def name_of(vehicle_id: str) -> str:
    """The file below the store; a vehicle's id may be any text."""
    named = hashlib.sha256(vehicle_id.encode("utf-8", "surrogatepass")).hexdigest()
    return f"{VEHICLES}/{named[:2]}/{named[:32]}.json"


def _key(vehicle_id: str, drives: Sequence[Finished]) -> str:
    """A hash over all that goes into joining: rows.json (which names cogest's version) and relations.parquet of each drive."""
    told = [
        (
            drive.drive_id,
            drive.start_utc,
            *(drive.stored.files[n].sha256 if n in drive.stored.files else "" for n in (ROWS, RELATIONS)),
        )
        for drive in drives
    ]
    return hashlib.sha256(json_bytes([FORMAT, vehicle_id, told])).hexdigest()


def _sum(raw: Mapping[str, Any]) -> str:
    """A hash over what a file says that the drives said together."""
    said = json.dumps(raw.get("knowledge"), sort_keys=True)
    return hashlib.sha256(said.encode("utf-8", "surrogatepass")).hexdigest()


def _last(store: Store, name: str, key: str) -> VehicleKnowledge | None:
    """What was joined last, if it was of the same drives."""
    content = store.storage.read(name)
    if content is None:
        return None
    try:
        raw = read_json(content)
        sound = raw.get("key") == key and raw.get("sum") == _sum(raw)
        return from_plain(_Joined, raw).knowledge if sound else None
    except (StoreError, RecursionError):
        # damaged: joined anew
        return None


def joined(store: Store, vehicle_id: str, drives: Sequence[Finished], join: Join) -> VehicleKnowledge:
    """What a vehicle's finished drives (in the order of time) say together.

    Raises DamagedDriveError, StoreError where the store cannot be written, and what `join` raises.
    """
    name, key = name_of(vehicle_id), _key(vehicle_id, drives)
    known = _last(store, name, key)
    if known is not None:
        return known
    copies = copies_of(drives)
    told = [
        _silent(drive) if drive.drive_id in copies else _told(store, number, drive)
        for number, drive in enumerate(drives)
    ]
    knowledge = join(vehicle_id, told)
    if copies:
        said = {**knowledge.drive_notes}
        for drive_id, copy in copies.items():
            said[drive_id] = (*said.get(drive_id, ()), copy.sentence(drive_id))
        apart: dict[str, Apart] = {**knowledge.apart, **dict.fromkeys(copies, _COPY)}
        knowledge = replace(knowledge, drive_notes=said, apart=apart)
    made = _Joined(key, knowledge)
    store.storage.write(name, json_bytes(replace(made, sum=_sum(read_json(json_bytes(made))))))
    return knowledge


def _silent(drive: Finished) -> DriveTold:
    """A drive that keeps its own verdict and tells the others nothing."""
    return DriveTold(drive.drive_id, drive.start_utc, drive.rows.verdict, None)


def _told(store: Store, number: int, drive: Finished) -> DriveTold:
    try:
        kept = store.kept(drive.stored)
    except StoreError as error:
        raise DamagedDriveError(number, error.problem) from error
    return DriveTold(drive.drive_id, drive.start_utc, drive.rows.verdict, kept)


def tidy(store: Store, vehicle_ids: Sequence[str]) -> None:
    """Take away what was joined of vehicles that are no more."""
    for name in store.storage.tree(VEHICLES).keys() - {name_of(vehicle) for vehicle in vehicle_ids}:
        store.storage.remove(name)
