"""`cogest convert`: a log into Parquet, one file a rate group."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cogest_cli.options import Dbc, Logs, Map, NoFix, VehicleFile

if TYPE_CHECKING:
    from parsers.mapping import WheelRadius


def convert(
    logs: Logs,
    out: Annotated[Path, typer.Option(help="Folder for the Parquet files.", show_default=False)],
    map_file: Map = None,
    dbc: Dbc = None,
    vehicle: VehicleFile = None,
    no_fix: NoFix = False,
) -> None:
    """Bring a log into canonical signals and write them as Parquet: DIR/*.parquet with `time_ns`."""
    from cogest_cli.options import check_logs, check_out, load_options
    from cogest_cli.output import show_line
    from cogest_cli.progress import ProgressLine

    check_logs(logs)
    check_out(out)
    from parsers.convert import convert_logs
    from pipelines.discover import nearest
    from reports.gap_text import gap_lines

    vehicle_path = vehicle or nearest("vehicle.toml", logs[0])
    with ProgressLine() as progress:
        options = load_options(logs, map_file, dbc, not no_fix, progress)
        if vehicle_path:
            options = replace(options, radius=_radius(vehicle_path))
        converted = convert_logs(logs, options, out)
    record = converted.record
    show_line(f"{record.format}, {record.status}: {converted.signals} signals over {record.duration_s:.1f} s")
    for decision in record.decisions:
        show_line(f"  {decision.signal}: {decision.found}; {decision.action} ({decision.evidence})")
    for line in gap_lines(record):
        show_line(f"  {line[:1].lower()}{line[1:]}")
    for reason, count in record.rejected.items():
        show_line(f"  rejected: {count} x {reason}")
    if record.disorder:
        show_line(f"  put in order: {', '.join(record.disorder)}")
    for note in record.notes:
        show_line(f"  note: {note}")
    for path in converted.files:
        show_line(path)


def _radius(vehicle: Path) -> WheelRadius | None:
    """All that a table needs of a vehicle: with it turn rates of wheels are speeds."""
    from pipelines.vehicles.vehicle_file import read_vehicle
    from pipelines.vehicles.wheel_radius import wheel_radius

    return wheel_radius(read_vehicle(vehicle))
