"""`cogest report`: the report again, from stored results alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    results: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder that `cogest analyze` wrote.", show_default=False)
    ],
    out: Annotated[
        Path | None, typer.Option(help="Folder for the report; default: the same folder.", show_default=False)
    ] = None,
    formats: Annotated[str, typer.Option("--format", help="What to write.")] = "html,pdf",
) -> None:
    """Write a drive's report again from its stored results, without the log."""
    from cogest_cli.output import show_line
    from reports.archive import load_folder
    from reports.write import check_formats, write_reports

    wanted = check_formats(formats)
    for path in write_reports(load_folder(results), out or results, wanted):
        show_line(path)
