"""Options that several commands share."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from parsers.errors import DatabaseError, ReportError

if TYPE_CHECKING:
    from parsers.load import LoadOptions, Progress

OTHER = "choose another folder with --out"

Logs = Annotated[
    list[Path], typer.Argument(metavar="LOG...", help="One drive's log, or its parts.", show_default=False)
]
Log = Annotated[Path, typer.Argument(metavar="LOG", help="The log.", show_default=False)]
Map = Annotated[
    Path | None,
    typer.Option(
        "--map", help="Mapping file (TOML); default: the nearest map.toml up the folders.", show_default=False
    ),
]
Dbc = Annotated[
    list[Path] | None,
    typer.Option(
        "--dbc", help="CAN database; may be repeated; default: the *.dbc beside the log.", show_default=False
    ),
]
SuspensionMapFile = Annotated[
    Path | None,
    typer.Option(
        "--suspension-map",
        help="Suspension map (TOML) of this vehicle, by `cogest suspension-map`: tyre normal forces over the drive.",
        show_default=False,
    ),
]
NoFix = Annotated[
    bool,
    typer.Option(
        "--no-fix", help="Only say what is wrong with signs, units and spikes; leave the data alone."
    ),
]


def databases(logs: Sequence[Path], given: Sequence[Path] | None) -> tuple[Path, ...]:
    """The CAN databases as given, else those beside the logs. Raises DatabaseError for one that is not there."""
    from pipelines.discover import databases_beside

    for path in given or ():
        if not path.is_file():
            raise DatabaseError("no such file", path=path, hint="check the name given with --dbc")
    return tuple(given) if given else tuple(dict.fromkeys(p for log in logs for p in databases_beside(log)))


def load_options(
    logs: Sequence[Path], map_file: Path | None, dbc: Sequence[Path] | None, fix: bool, progress: Progress
) -> LoadOptions:
    """The options as given, and what lies beside the logs where nothing was given."""
    from parsers.load import LoadOptions
    from parsers.mapping import read_map
    from pipelines.discover import nearest

    found = map_file or nearest("map.toml", logs[0])
    return LoadOptions(
        map=read_map(found, strict=map_file is not None) if found else None,
        dbc=databases(logs, dbc),
        fix=fix,
        progress=progress,
    )


def check_logs(logs: Sequence[Path]) -> None:
    """Raise LogError for a log that is not there or empty: said before the heavy libraries load."""
    from parsers.registry import read_head

    for log in logs:
        read_head(log)


def check_out(folder: Path) -> None:
    """Raise ReportError where no folder can be made there: said before the work, not after it."""
    for place in (folder, *folder.absolute().parents):
        try:
            if not place.exists():
                continue
        except OSError as error:
            raise ReportError(f"cannot be used ({error.strerror})", path=folder, hint=OTHER) from error
        if not place.is_dir():
            problem = "is a file, not a folder" if place == folder else f"{place} is a file, not a folder"
            raise ReportError(problem, path=folder, hint=OTHER)
        if not os.access(place, os.W_OK | os.X_OK):
            raise ReportError(f"no permission to write in {place}", path=folder, hint=OTHER)
        return
