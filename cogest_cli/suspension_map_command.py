"""`cogest suspension-map`: train a suspension map on drives with measuring wheels, and judge it on others."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cogest_cli.options import Dbc, InputPath, Map, NoFix, VehicleFile
from parsers.errors import VehicleError
from parsers.places import as_path

if TYPE_CHECKING:
    from cogest_cli.progress import ProgressLine
    from parsers.drive import Drive
    from pipelines.suspension_mapping.judge import Judged
    from pipelines.vehicles.vehicle import Vehicle


def suspension_map(
    logs: Annotated[
        list[InputPath],
        typer.Argument(
            metavar="LOG...", help="Training drives of one vehicle, each with tire_normal_force of all wheels.",
            show_default=False, parser=as_path,
        ),
    ],
    out: Annotated[Path, typer.Option(help="The map file (TOML) to write.", show_default=False)],
    validate: Annotated[
        list[InputPath] | None,
        typer.Option(
            metavar="LOG", help="A drive to judge the map on; may be repeated.", show_default=False, parser=as_path
        ),
    ] = None,
    vehicle: VehicleFile = None,
    map_file: Map = None,
    dbc: Dbc = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    no_fix: NoFix = False,
) -> None:  # fmt: skip
    """Train a suspension map: what the tyres' normal forces are, told by struts, deflections and accelerations."""
    from cogest_cli.options import check_logs
    from cogest_cli.output import show, show_line, speaks_unicode
    from cogest_cli.progress import ProgressLine

    check_logs([*logs, *(validate or ())])
    check_file(out)
    from cogest_cli.version import version
    from pipelines.discover import nearest
    from pipelines.suspension_mapping.file import map_text
    from pipelines.suspension_mapping.judge import judge
    from pipelines.suspension_mapping.train import train, training_drive
    from pipelines.vehicles.vehicle import Vehicle
    from pipelines.vehicles.vehicle_file import read_vehicle
    from reports.files import write_whole
    from reports.suspension_map_text import map_report_dict, map_report_text

    found = vehicle or nearest("vehicle.toml", logs[0])
    # the map that the file names may be the one that is to be made
    known = read_vehicle(found, with_map=False) if found else Vehicle()
    with ProgressLine() as progress:
        drives = [
            training_drive(_load(log, map_file, dbc, no_fix, known, progress), log.name) for log in logs
        ]
        progress("training", 0.9)
        record = train(drives, known, _name(known, logs))
        judged: list[Judged] = []
        for log in validate or ():
            drive = _load(log, map_file, dbc, no_fix, known, progress)
            judged += judge(record, drive, log.name)
    write_whole(out, map_text(record).encode("utf-8"))
    if as_json:
        content = map_report_dict(record, judged, str(out), version())
        print(json.dumps(content, indent=1, ensure_ascii=not speaks_unicode(), allow_nan=False))
        return
    show(map_report_text(record, judged))
    show_line(out)


TAKEN = ("vehicle.toml", "map.toml", "settings.toml")
"""Names, alone or behind a dot, that every command takes by itself for what they say, beside a log or above it: a map for tyres is none of them."""


def check_file(path: Path) -> None:
    """Raise VehicleError where no map can be written: said before the work."""
    if path.is_dir():
        raise VehicleError(
            "is a folder, expected a file to write", path=path, hint="choose another with --out"
        )
    if path.name in TAKEN or path.name.endswith(tuple(f".{name}" for name in TAKEN)):
        raise VehicleError(
            "is a name under which cogest looks for a file of another kind",
            path=path,
            hint='choose another with --out ("suspension.toml")',
        )


def _name(vehicle: Vehicle, logs: Sequence[Path]) -> str:
    return vehicle.name or f"the vehicle of {logs[0].name}"


def _load(
    log: Path,
    map_file: Path | None,
    dbc: Sequence[Path] | None,
    no_fix: bool,
    known: Vehicle,
    progress: ProgressLine,
) -> Drive:
    from cogest_cli.options import load_options
    from parsers.load import load_drive
    from pipelines.prepare.put_right import put_right
    from pipelines.vehicles.wheel_radius import wheel_radius

    options = load_options([log], map_file, dbc, not no_fix, progress)
    drive = load_drive([log], replace(options, radius=wheel_radius(known)))
    return put_right(drive, known, fix=not no_fix)[0]
