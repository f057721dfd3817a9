"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from parsers.load import LoadOptions, Progress

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
NoFix = Annotated[
    bool,
    typer.Option(
        "--no-fix", help="Only say what is wrong with signs, units and spikes; leave the data alone."
    ),
]


def load_options(
    log: Path, map_file: Path | None, dbc: list[Path] | None, fix: bool, progress: Progress
) -> LoadOptions:
    """The options as given, and what lies beside the log where nothing was given."""
    from parsers.load import LoadOptions
    from parsers.mapping import read_map
    from pipelines.discover import databases_beside, nearest

    found = map_file or nearest("map.toml", log)
    return LoadOptions(
        map=read_map(found, strict=map_file is not None) if found else None,
        dbc=tuple(dbc) if dbc else databases_beside(log),
        fix=fix,
        progress=progress,
    )
