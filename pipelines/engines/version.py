"""Which cogest this is: what machines that work together compare."""

from __future__ import annotations

from importlib import metadata


def _installed() -> str:
    try:
        return metadata.version("cogest")
    except metadata.PackageNotFoundError:
        return "0+unknown"


VERSION = _installed()
"""The installed version; "0+unknown" in a bare checkout. A constant, so that another machine can be asked for it by name."""
