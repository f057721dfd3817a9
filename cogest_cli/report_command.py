"""`cogest report`: the report again, from stored results alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    results: Annotated[
        str,
        typer.Argument(
            metavar="STORE|DIR",
            help="A store that `cogest batch` wrote, or a folder that `cogest analyze` wrote.",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(help="Folder for the report; default: the same place.", show_default=False)
    ] = None,
    formats: Annotated[str, typer.Option("--format", help="What to write.")] = "html,pdf",
) -> None:
    """Write a report again from stored results, without the logs: a drive's, or a fleet's."""
    from cogest_cli.output import show_line
    from parsers.places_text import is_url
    from pipelines.fleet.store import STORE_FILE

    if is_url(results) or (Path(results) / STORE_FILE).is_file():
        from pipelines.fleet.store import open_store
        from reports.fleet.stored import check_fleet_formats, put_fleet_report

        wanted = check_fleet_formats(formats)
        for place in put_fleet_report(open_store(results), wanted, out):
            show_line(place)
        return
    from reports.archive import load_folder
    from reports.write import check_formats, write_reports

    folder = Path(results)
    for path in write_reports(load_folder(folder), out or folder, check_formats(formats)):
        show_line(path)
