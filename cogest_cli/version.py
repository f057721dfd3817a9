"""The installed version."""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """The version of the installed distribution; "0+unknown" when run from a bare checkout."""
    try:
        return metadata.version("cogest")
    except metadata.PackageNotFoundError:
        return "0+unknown"
