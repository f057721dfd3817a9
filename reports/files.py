"""Write a file whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from parsers.errors import ReportError


def make_folder(folder: Path) -> None:
    """Make a folder and those above it. Raises ReportError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ReportError(
            f"the folder cannot be made ({error.strerror or error})",
            path=folder,
            hint="choose another with --out",
        ) from error


def remove_old(path: Path) -> None:
    """Take a file of an earlier run away, if there is one; a folder of that name is not ours. Raises ReportError."""
    if path.is_dir() and not path.is_symlink():
        return
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise ReportError(
            f"is of an earlier run and cannot be removed ({error.strerror or error})",
            path=path,
            hint="choose another folder with --out",
        ) from error


def write_whole(path: Path, content: bytes) -> None:
    """Write under a temporary name beside the target, then rename: a reader never meets half a file.

    Raises ReportError where it cannot be written; nothing is left behind then, and an older file stays.
    """
    make_folder(path.parent)
    temporary: str | None = None
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name[:80]}.", suffix=".tmp", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(
            temporary, 0o666 & ~mask
        )  # mkstemp's files are for their owner only; a report is for everyone
        os.replace(temporary, path)
    except OSError as error:
        if temporary is not None:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
        raise ReportError(
            f"cannot be written ({error.strerror or error})",
            path=path,
            hint="choose another folder with --out",
        ) from error
