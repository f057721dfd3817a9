"""Options that several commands share."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from parsers.errors import DatabaseError, ReportError
from parsers.places import as_path
from parsers.places_text import masked

if TYPE_CHECKING:
    from parsers.load import LoadOptions, Progress

    InputPath = Path
else:

    class InputPath:
        """What help calls a path or a URL. typer makes a pathlib.Path of what is annotated as one: a URL loses a "/"."""


OTHER = "choose another folder with --out"
_URL_AS_PATH = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]+:/")

Logs = Annotated[
    list[InputPath],
    typer.Argument(
        metavar="LOG...",
        help="One drive's log, or its parts: paths or URLs (s3://…).",
        show_default=False,
        parser=as_path,
    ),
]
Log = Annotated[
    InputPath,
    typer.Argument(
        metavar="LOG", help="The log: a path or a URL (s3://…).", show_default=False, parser=as_path
    ),
]
Map = Annotated[
    InputPath | None,
    typer.Option(
        "--map",
        metavar="FILE",
        help="Mapping file (TOML); default: the nearest map.toml up the folders.",
        show_default=False,
        parser=as_path,
    ),
]
Dbc = Annotated[
    list[InputPath] | None,
    typer.Option(
        "--dbc",
        metavar="FILE",
        help="CAN database; may be repeated; default: the *.dbc beside the log.",
        show_default=False,
        parser=as_path,
    ),
]
VehicleFile = Annotated[
    InputPath | None,
    typer.Option(
        metavar="FILE",
        help="Vehicle file (TOML); default: the nearest vehicle.toml up the folders.",
        show_default=False,
        parser=as_path,
    ),
]
SuspensionMapFile = Annotated[
    InputPath | None,
    typer.Option(
        "--suspension-map",
        metavar="FILE",
        parser=as_path,
        help="Suspension map (TOML) of this vehicle, by `cogest suspension-map`: tyre normal forces over the drive.",
        show_default=False,
    ),
]
Estimators = Annotated[
    str | None, typer.Option(help="Only these, by name: NAME,NAME…; default: all.", show_default=False)
]
Seed = Annotated[
    int, typer.Option(help="Seed of the random numbers; the same seed gives the same result.", min=0)
]
NoFix = Annotated[
    bool,
    typer.Option(
        "--no-fix", help="Only say what is wrong with signs, units and spikes; leave the data alone."
    ),
]


def command_line() -> str:
    """What the user typed, for the report: without what may be secret in a URL."""
    return shlex.join(["cogest", *map(masked, sys.argv[1:])])


def databases(logs: Sequence[Path], given: Sequence[Path] | None) -> tuple[Path, ...]:
    """The CAN databases as given, else those beside the logs. Raises DatabaseError for one that is not there."""
    from pipelines.discover import databases_beside

    for path in given or ():
        try:
            there = path.is_file()
        except OSError as error:
            # a store that does not answer
            raise DatabaseError(f"cannot be read ({error.strerror or error})", path=path) from error
        if not there:
            problem = "a folder, not a DBC file" if path.is_dir() else "no such file"
            raise DatabaseError(problem, path=path, hint="check the name given with --dbc")
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
        dbc_given=bool(dbc),
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
    if _URL_AS_PATH.match(folder.as_posix()):
        raise ReportError(
            "is a URL: reports and tables are written to folders of this machine", path=folder, hint=OTHER
        )
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
