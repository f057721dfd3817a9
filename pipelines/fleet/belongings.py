"""What belongs to a drive by where it lies: the nearest vehicle.toml, map.toml, settings.toml and *.dbc, and whose vehicle it is."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from parsers.errors import CogestError, VehicleError
from parsers.importer import ReadOptions
from parsers.small_text import read_small_text
from pipelines.discover import SETTINGS, nearest
from pipelines.fleet.entries import Listing, Placed, path_of

VEHICLE, MAP = "vehicle.toml", "map.toml"
OWN = tuple(f".{name}" for name in (VEHICLE, MAP, SETTINGS))
"""How files of a log's own end: drive.vehicle.toml beside drive.csv."""


@dataclass(frozen=True)
class VehicleFacts:
    """What a vehicle file says of whose it is. table: its [vehicle] table. problem: why it cannot be used, or ""."""

    place: str
    id: str | None = None
    name: str | None = None
    table: Mapping[str, object] | None = None
    problem: str = ""


def read_vehicle_facts(place: str) -> VehicleFacts:
    """Read a vehicle file. Raises nothing: what is wrong with it is its `problem`."""
    from pipelines.vehicles.vehicle_file import parse_vehicle, with_suspension_map

    path = path_of(place)
    try:
        text = read_small_text(path)
        vehicle = parse_vehicle(text, path)
        if vehicle.suspension_map_path is not None:
            with_suspension_map(vehicle, vehicle.suspension_map_path)
        table = tomllib.loads(text).get("vehicle", {})
    except UnicodeDecodeError:
        return VehicleFacts(place, problem="not UTF-8 text")
    except VehicleError as error:
        where = f"{error.place}: " if error.place else ""
        return VehicleFacts(place, problem=f"{where}{error.problem}")
    except CogestError as error:
        return VehicleFacts(place, problem=error.problem)
    except OSError as error:
        return VehicleFacts(place, problem=f"cannot be read ({error.strerror or error})")
    return VehicleFacts(place, id=vehicle.id, name=vehicle.name, table=table)


def _settings_problem(place: str) -> str:
    from pipelines.estimators.registry import estimators
    from pipelines.settings import read_settings

    try:
        read_settings(path_of(place), estimators())
    except CogestError as error:
        return str(error)
    return ""


def folders_up(folder: str) -> list[str]:
    """A folder below the fleet's and those above it, the nearest first, the fleet's own ("") last."""
    found = [folder]
    while found[-1]:
        found.append(found[-1].rpartition("/")[0])
    return found


@dataclass
class Belongings:
    """Looks up what belongs to logs, from the listing alone."""

    root: str
    files: Mapping[str, Mapping[str, str]]
    _vehicles: dict[str, VehicleFacts] = field(default_factory=dict)
    _outside: dict[str, str | None] = field(default_factory=dict)
    _options: dict[str, ReadOptions] = field(default_factory=dict)
    _settings: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, listing: Listing) -> Belongings:
        """From what lies in the fleet's folder."""
        files: dict[str, dict[str, str]] = {}
        for entry in listing.entries:
            name = entry.name
            if name.endswith(OWN) or name in (VEHICLE, MAP, SETTINGS) or name.lower().endswith(".dbc"):
                files.setdefault(entry.folder, {})[name] = entry.place
        return cls(listing.root, files)

    @property
    def root_name(self) -> str:
        """The fleet's folder's own name."""
        return path_of(self.root).name or "fleet"

    def own(self, name: str, beside: Sequence[tuple[str, str]]) -> str | None:
        """The place of the file of that name which belongs to a drive's logs alone. beside: (folder, file name) of each log."""
        for folder, log in beside:
            place = self.files.get(folder, {}).get(f"{PurePosixPath(log).stem}.{name}")
            if place is not None:
                return place
        return None

    def nearest(self, name: str, folder: str, beside: Sequence[tuple[str, str]] = ()) -> str | None:
        """The place of the logs' own file of that name, else of the nearest, in the fleet's folder first, then above it."""
        if (mine := self.own(name, beside)) is not None:
            return mine
        for each in folders_up(folder):
            if (place := self.files.get(each, {}).get(name)) is not None:
                return place
        if "://" in self.root:
            return None
        if name not in self._outside:
            above = path_of(self.root).parent
            found = nearest(name, above / ".") if above != path_of(self.root) else None
            self._outside[name] = str(found) if found else None
        return self._outside[name]

    def databases(self, folder: str) -> tuple[str, ...]:
        """The *.dbc beside a log, or in the nearest folder above it that has some, not above the fleet's own."""
        for each in folders_up(folder):
            found = [
                place for name, place in self.files.get(each, {}).items() if name.lower().endswith(".dbc")
            ]
            if found:
                return tuple(sorted(found))
        return ()

    def read_options(self, log: Placed) -> ReadOptions:
        """How to read a table: what its own or the nearest mapping file says of the time column."""
        from parsers.mapping import read_map

        place = self.nearest(MAP, log.folder, [(log.folder, log.name)])
        if place is None:
            return ReadOptions()
        if place not in self._options:
            try:
                mapping = read_map(path_of(place), strict=False)
                self._options[place] = ReadOptions(
                    time_channel=mapping.time_channel, time_unit=mapping.time_unit
                )
            except (CogestError, OSError):
                # the drive's own run says what is wrong with it
                self._options[place] = ReadOptions()
        return self._options[place]

    def settings_problem(self, place: str) -> str:
        """Why a settings file cannot be used, as the drive's own run would say it; "" where it can."""
        if place not in self._settings:
            self._settings[place] = _settings_problem(place)
        return self._settings[place]

    def vehicle(self, folder: str, beside: Sequence[tuple[str, str]] = ()) -> VehicleFacts | None:
        """The logs' own vehicle file, else the nearest; None where there is none."""
        place = self.nearest(VEHICLE, folder, beside)
        return None if place is None else self._facts(place)

    def _facts(self, place: str) -> VehicleFacts:
        if place not in self._vehicles:
            self._vehicles[place] = read_vehicle_facts(place)
        return self._vehicles[place]

    def _alike(self, folder: str, facts: VehicleFacts) -> str:
        """The first log, without its ending, whose own file describes the same vehicle; "" where the file is a folder's."""
        if not facts.place.endswith(f".{VEHICLE}"):
            return ""
        names = sorted(name for name in self.files.get(folder, {}) if name.endswith(f".{VEHICLE}"))
        alike = [
            name
            for name in names
            if (place := self.files[folder][name]) == facts.place
            or (facts.table is not None and self._facts(place).table == facts.table)
        ]
        return _below(folder, alike[0].removesuffix(f".{VEHICLE}")) if alike else ""

    def vehicle_folder(self, folder: str, facts: VehicleFacts) -> str:
        """The topmost folder whose vehicle file describes the same vehicle ([vehicle] alike); "" is the fleet's own.

        Of a log's own file that is like none of them: the first log beside it whose own file is alike.
        """
        found = self._alike(folder, facts)
        for each in folders_up(folder):
            place = self.files.get(each, {}).get(VEHICLE)
            if place == facts.place or (
                place is not None and facts.table is not None and self._facts(place).table == facts.table
            ):
                found = each
        return found


def _below(folder: str, name: str) -> str:
    return f"{folder}/{name}" if folder else name


def top_folder(below: str) -> str:
    """The folder of the fleet in which a log lies, at whatever depth; "" for one that lies in the fleet's own."""
    return below.partition("/")[0] if "/" in below else ""


def distinct(ids: Sequence[tuple[str, bool]]) -> list[str]:
    """Vehicle ids, (id, said by a vehicle file): a folder that is called like another vehicle's own id gets a slash."""
    said = {vehicle for vehicle, own in ids if own}
    return [f"{vehicle}/" if not own and vehicle in said else vehicle for vehicle, own in ids]
