"""Files that belong to a log: its own or the nearest vehicle.toml, map.toml and settings.toml up the folders, the DBCs beside it."""

from __future__ import annotations

from pathlib import Path


def nearest(name: str, log: Path) -> Path | None:
    """The file `name` in the log's folder or the nearest folder above it. A log that is not there has none.

    A file of the log's own (drive.vehicle.toml beside drive.csv) goes before the folder's.
    """
    try:
        start = log.resolve()
        folders = [start, *start.parents] if start.is_dir() else list(start.parents)
    except (OSError, RuntimeError):
        # a loop of links, a name too long: opening the log says it better
        return None
    # the root of all folders has no name, and so no file of its own
    own = [start.with_name(f"{start.stem}.{name}")] if start.name else []
    for place in (*own, *(folder / name for folder in folders)):
        try:
            if place.is_file():
                return place
        except OSError:
            continue
    return None


def databases_beside(log: Path) -> tuple[Path, ...]:
    """The *.dbc files in the log's folder (and in the log, where it is a folder), by name."""
    try:
        start = log.resolve()
        folders = [start, start.parent] if start.is_dir() else [start.parent]
        return tuple(
            path
            for folder in folders
            for path in sorted(folder.iterdir())
            if path.suffix.lower() == ".dbc" and path.is_file()
        )
    except (OSError, RuntimeError):
        return ()
