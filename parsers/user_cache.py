"""The user's folder for what can be made again: read databases, machine code. Where there is none, nothing is kept."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path


def user_cache() -> Path | None:
    """cogest's part of the folder in which this system keeps what can be made again, or None for a user without a home."""
    try:
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData/Local")
        elif sys.platform == "darwin":
            base = Path.home() / "Library/Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # no home
        return None
    return base / "cogest"


def drop_oldest(folder: Path, pattern: str, most: int) -> None:
    """Delete the oldest files of a name's form until `most` are left; what cannot be deleted stays."""
    with suppress(OSError):
        found = sorted(folder.glob(pattern), key=lambda each: -each.stat().st_mtime_ns)
        for old in found[most:]:
            with suppress(OSError):
                old.unlink()
