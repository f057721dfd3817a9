"""What a drive's logs could tell, by their channels alone: which signals, which estimators could run, what the others lack."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from parsers.errors import CogestError, LogError
from parsers.importer import Importer
from parsers.load import LoadOptions, OpenedLog, no_numbers, open_log
from parsers.mapping import propose, read_map
from parsers.registry import find_importer
from pipelines.estimators.base import Estimator
from pipelines.estimators.registry import estimators
from pipelines.fleet.entries import path_of
from pipelines.fleet.records import FoundDrive
from pipelines.needs import Readiness, readiness
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import read_vehicle
from pipelines.vehicles.wheel_radius import wheel_radius

MOST_BYTES = 256 << 20
"""CAN logs are gone through once to see what is in them: those of more bytes are not opened."""

ASKED = ("cg_height_m", "mass_kg", "cg_to_front_axle_m", "roll_stiffness_nmprad")
"""What people look for first."""

OF_MASS = ("cg_height_m", "mass_kg", "roll_stiffness_nmprad")
FORCES = ("suspension_force_", "tire_normal_force_", "axle_load_")
NO_MASS = "nothing says what the vehicle weighs: give mass_kg (and body) in a vehicle file"
"""What hangs on the vehicle's mass, the signals that weigh it, and what stands where neither they nor a file do."""

WEIGH = (
    *FORCES, "suspension_deflection_", "accel_z_unsprung_", "drive_torque", "brake_torque", "brake_pressure",
)  # fmt: skip
NO_FORCE = "no signal shows a force: it needs struts', wheels' or axle loads, suspension deflections with spring rates, or drive torque or brake pressure"
"""Beginnings of the signals of which one a mass needs, whoever tells it, and what stands where there is none of them."""

_SCANNED = frozenset(("blf", "asc", "trc", "candump"))


@dataclass(frozen=True)
class Outlook:
    """What could be told from a drive, before any sample is decoded.

    signals: canonical names that its channels map to, sorted; a channel that turns out to be empty counts still.
    ready: names of the estimators that have all they need. missing: (estimator, what it lacks, in words).
    cannot: (parameter, what the estimator that comes nearest to telling it lacks), of `ASKED`, those that none of the chosen can tell.
    problem: why the drive will fail, or why this was not looked at; "" where neither. dated: whether a log says when it
    was recorded, in whatever time zone.
    """

    signals: tuple[str, ...] = ()
    ready: tuple[str, ...] = ()
    missing: tuple[tuple[str, str], ...] = ()
    cannot: tuple[tuple[str, str], ...] = ()
    problem: str = ""
    dated: bool = True


def _has_date(opened: OpenedLog) -> bool:
    """Whether a log says when it was recorded."""
    reader = opened.reader
    return reader.absolute or reader.start_utc_ns is not None or opened.log.local_start_ns is not None


def outlook(
    drive: FoundDrive, most_bytes: int = MOST_BYTES, chosen: Sequence[Estimator] | None = None
) -> Outlook:
    """Look at a drive's channels. Raises nothing: what goes wrong is the outlook's `problem`.

    chosen: the estimators that would run; None for all. Costs the logs' tables of contents; CAN logs are gone through once, unless they have more than `most_bytes`.
    """
    try:
        vehicle = read_vehicle(path_of(drive.vehicle)) if drive.vehicle else None
        mapping = read_map(path_of(drive.map), strict=False) if drive.map else None
        options = LoadOptions(
            map=mapping,
            dbc=tuple(path_of(place) for place in drive.dbc),
            dbc_given=False,
            radius=wheel_radius(vehicle),
        )
        signals: set[str] = set()
        notes: list[str] = []
        numbers = dated = False
        for place in drive.logs:
            path = path_of(place)
            importer = find_importer(path)
            if drive.size > most_bytes and _is_scanned(importer):
                return Outlook(problem=f"not looked at: {drive.size / 1e9:.1f} GB of CAN frames")
            opened = open_log(path, options)
            dated |= _has_date(opened)
            notes += opened.log.notes
            numbers |= any(each.kind == "number" for each in opened.reader.channels)
            signals |= propose(opened.reader.channels, options.map, options.radius).keys()
        if not signals and not numbers:
            return Outlook(problem=no_numbers(notes))
        if not signals:
            return Outlook(problem="no channel maps to a signal: name the channels in a map.toml")
        return replace(_compared(signals, vehicle, estimators() if chosen is None else chosen), dated=dated)
    except CogestError as error:
        return Outlook(problem=error.problem)
    except OSError as error:
        return Outlook(problem=str(LogError(f"cannot be read ({error.strerror or error})")))


def _is_scanned(importer: Importer) -> bool:
    return importer.name in _SCANNED


def _compared(signals: set[str], vehicle: Vehicle | None, chosen: Sequence[Estimator]) -> Outlook:
    """Compare what there is with what each estimator needs."""
    found = [(estimator, readiness(estimator, signals, vehicle)) for estimator in chosen]
    lacking = [(estimator, _lack(ready)) for estimator, ready in found if not ready.ready]
    told = {name for estimator, ready in found if ready.ready for name in estimator.parameters}
    cannot = []
    weighed = _weighed(signals, vehicle)
    for parameter in ASKED:
        ways = [(estimator, lack) for estimator, lack in lacking if parameter in estimator.parameters]
        if parameter in told:
            if parameter in OF_MASS and not weighed:
                cannot.append((parameter, NO_MASS))
            elif parameter == "mass_kg" and not any(name.startswith(WEIGH) for name in signals):
                cannot.append((parameter, NO_FORCE))
        elif ways:
            nearest, lack = min(ways, key=lambda way: len(way[1]))
            cannot.append((parameter, f"{nearest.name} lacks {'; '.join(lack)}"))
        else:
            cannot.append((parameter, "none of the chosen estimators tells it"))
    return Outlook(
        signals=tuple(sorted(signals)),
        ready=tuple(ready.estimator for _, ready in found if ready.ready),
        missing=tuple((estimator.name, "; ".join(lack)) for estimator, lack in lacking),
        cannot=tuple(cannot),
    )


def _weighed(signals: set[str], vehicle: Vehicle | None) -> bool:
    """Whether a mass is stated, or follows from forces, or from springs that are."""
    if any(name.startswith(FORCES) for name in signals):
        return True
    return vehicle is not None and any(
        vehicle.get(name) is not None for name in ("mass_kg", "spring_rate_front_npm", "spring_rate_rear_npm")
    )


def _lack(ready: Readiness) -> tuple[str, ...]:
    return (*ready.missing_signals, *ready.missing_vehicle)
