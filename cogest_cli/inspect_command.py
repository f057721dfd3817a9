"""`cogest inspect`: what is in a log, what maps to what and why, and which estimators could run."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from cogest_cli.options import Dbc, Log, Map, NoFix, VehicleFile


def inspect(
    log: Log,
    dbc: Dbc = None,
    map_file: Map = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    write_map: Annotated[
        Path | None, typer.Option(help="Write a starter mapping file here.", show_default=False)
    ] = None,
    vehicle: VehicleFile = None,
    no_fix: NoFix = False,
) -> None:
    """Say what is in a log: channels, rates, gaps, ranges; what maps to which signal; which estimators can run."""
    from cogest_cli.options import check_logs, load_options
    from cogest_cli.output import show, speaks_unicode
    from cogest_cli.progress import ProgressLine

    check_logs([log])
    from parsers.errors import MappingError
    from pipelines.discover import nearest
    from pipelines.inspection import inspect_log
    from pipelines.vehicles.vehicle_file import read_vehicle
    from pipelines.vehicles.wheel_radius import wheel_radius
    from reports.inspection import inspection_dict, inspection_text

    vehicle_path = vehicle or nearest("vehicle.toml", log)
    known = read_vehicle(vehicle_path) if vehicle_path else None
    with ProgressLine() as progress:
        options = load_options([log], map_file, dbc, not no_fix, progress)
        inspection = inspect_log(log, replace(options, radius=wheel_radius(known)), known)
    if write_map is not None:
        if write_map.exists():
            hint = "a mapping file that was edited is not written over: name another, or remove it"
            raise MappingError("is there already", path=write_map, hint=hint)
        try:
            write_map.write_bytes(inspection.starter_map.encode("utf-8", "replace"))
        except OSError as error:
            raise MappingError(f"cannot be written ({error.strerror})", path=write_map) from error
    if as_json:
        content = inspection_dict(inspection)
        print(json.dumps(content, indent=1, ensure_ascii=not speaks_unicode(), allow_nan=False))
        return
    show(inspection_text(inspection))
    if write_map is not None:
        show(f"\nstarter mapping file: {write_map}")
