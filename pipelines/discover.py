"""Files that belong to a log: its own or the nearest vehicle.toml, map.toml and settings.toml up the folders, the DBCs beside it."""

from __future__ import annotations

import tomllib
from pathlib import Path

from parsers.small_text import read_small_text

SETTINGS = "settings.toml"


def nearest(name: str, log: Path) -> Path | None:
    """The file `name` in the log's folder or the nearest folder above it. A log that is not there has none.

    A file of the log's own (drive.vehicle.toml beside drive.csv) goes before the folder's. A settings.toml above the log's folder in
    which no estimator is named is another program's: many have a file of that name.
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
            if place.is_file() and (
                name != SETTINGS or place.parent == folders[0] or _names_an_estimator(place)
            ):
                return place
        except OSError:
            continue
    return None


def _names_an_estimator(path: Path) -> bool:
    """Whether a settings file is cogest's, by its tables; one that cannot be read is taken for that, so that it is said."""
    from pipelines.estimators.registry import estimators

    try:
        tables = tomllib.loads(read_small_text(path))
    except (OSError, ValueError, RecursionError):
        return True
    return any(estimator.name in tables for estimator in estimators())


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
