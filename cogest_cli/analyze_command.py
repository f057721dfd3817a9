"""`cogest analyze`: one drive in, a report out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cogest_cli.options import (
    Dbc,
    Estimators,
    InputPath,
    Logs,
    Map,
    NoFix,
    Seed,
    SuspensionMapFile,
    VehicleFile,
)
from parsers.places import as_path

if TYPE_CHECKING:
    from pipelines.drive_results import DriveResults


def analyze(
    logs: Logs,
    vehicle: VehicleFile = None,
    map_file: Map = None,
    dbc: Dbc = None,
    estimators: Estimators = None,
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("report"),
    settings: Annotated[
        InputPath | None,
        typer.Option(
            metavar="FILE",
            help="Settings file (TOML), see `cogest estimators --settings`; default: the log's own or the nearest settings.toml.",
            show_default=False,
            parser=as_path,
        ),
    ] = None,
    formats: Annotated[str, typer.Option("--format", help="What to write.")] = "html,pdf,json",
    seed: Seed = 0,
    suspension_map: SuspensionMapFile = None,
    no_fix: NoFix = False,
) -> None:
    """Analyse one drive: estimate the vehicle's parameters and write report.html, report.pdf, results.json."""
    from cogest_cli.options import check_logs, check_out, command_line, databases
    from cogest_cli.progress import ProgressLine

    check_logs(logs)
    check_out(out)
    from cogest_cli.version import version
    from pipelines.analyze import Request
    from pipelines.analyze import analyze as analyze_drive
    from pipelines.discover import nearest
    from reports.tire_force_file import write_tire_forces
    from reports.write import check_formats, write_reports

    wanted = check_formats(formats)
    request = Request(
        logs=tuple(logs),
        vehicle=vehicle or nearest("vehicle.toml", logs[0]),
        map=map_file or nearest("map.toml", logs[0]),
        map_given=map_file is not None,
        dbc=databases(logs, dbc),
        dbc_given=bool(dbc),
        settings=settings or nearest("settings.toml", logs[0]),
        estimators=estimators,
        seed=seed,
        fix=not no_fix,
        command=command_line(),
        version=version(),
        suspension_map=suspension_map,
    )
    with ProgressLine() as progress:
        results = analyze_drive(request, progress)
        progress("writing the report", 1.0)
        written = write_reports(results, out, wanted, replace=True)
        forces = write_tire_forces(results, out)
    _tell(results, (*written, *([forces] if forces else [])))


def _tell(results: DriveResults, paths: Sequence[Path]) -> None:
    """Print the verdict, the tyre forces' errors where the log measured them, and what was written."""
    from cogest_cli.output import show, show_line
    from reports.suspension_map_text import tire_force_errors
    from reports.terminal import verdict_table

    show(verdict_table(results))
    used = results.inputs
    show_line(f"vehicle file: {used.vehicle or 'none (a height needs at least mass_kg and body in one)'}")
    if used.suspension_map:
        show_line(f"suspension map: {used.suspension_map}")
    if used.map:
        show_line(f"mapping file: {used.map}")
    for database in used.dbc:
        show_line(f"database: {database}")
    if used.settings:
        show_line(f"settings file: {used.settings}")
    for estimate in results.estimates:
        if table := tire_force_errors(estimate.diagnostics):
            show(f"\n{table}")
    for path in paths:
        show_line(path)
