"""`cogest analyze`: one drive in, a report out."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from cogest_cli.options import Dbc, Logs, Map, NoFix


def analyze(
    logs: Logs,
    vehicle: Annotated[
        Path | None,
        typer.Option(
            help="Vehicle file (TOML); default: the nearest vehicle.toml up the folders.", show_default=False
        ),
    ] = None,
    map_file: Map = None,
    dbc: Dbc = None,
    estimators: Annotated[
        str | None, typer.Option(help="Only these, by name: NAME,NAME…; default: all.", show_default=False)
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("report"),
    settings: Annotated[
        Path | None,
        typer.Option(help="Settings file (TOML): see `cogest estimators --settings`.", show_default=False),
    ] = None,
    formats: Annotated[str, typer.Option("--format", help="What to write.")] = "html,pdf,json",
    seed: Annotated[
        int, typer.Option(help="Seed of the random numbers; the same seed gives the same result.", min=0)
    ] = 0,
    no_fix: NoFix = False,
) -> None:
    """Analyse one drive: estimate the vehicle's parameters and write report.html, report.pdf, results.json."""
    from cogest_cli.options import check_logs, check_out, databases
    from cogest_cli.output import show, show_line
    from cogest_cli.progress import ProgressLine

    check_logs(logs)
    check_out(out)
    from cogest_cli.version import version
    from pipelines.analyze import Request
    from pipelines.analyze import analyze as analyze_drive
    from pipelines.discover import nearest
    from reports.terminal import verdict_table
    from reports.write import check_formats, write_reports

    wanted = check_formats(formats)
    request = Request(
        logs=tuple(logs),
        vehicle=vehicle or nearest("vehicle.toml", logs[0]),
        map=map_file or nearest("map.toml", logs[0]),
        map_given=map_file is not None,
        dbc=databases(logs, dbc),
        settings=settings,
        estimators=estimators,
        seed=seed,
        fix=not no_fix,
        command=shlex.join(["cogest", *sys.argv[1:]]),
        version=version(),
    )
    with ProgressLine() as progress:
        results = analyze_drive(request, progress)
        progress("writing the report", 1.0)
        written = write_reports(results, out, wanted)
    show(verdict_table(results))
    for path in written:
        show_line(path)
