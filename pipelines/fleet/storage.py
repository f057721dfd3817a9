"""Where a store's files lie: the few operations that a store needs, so that a disk and an object store both can hold one.

Names are relative to the store, with "/" between folders. Every operation raises StoreError where the place cannot be
reached, read or written; a file that is not there is no error where it says None. All are safe to call from threads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from parsers.errors import StoreError

MARK = "drive.json"
"""The file that makes a drive's folder one: where folders cannot be renamed it is written last and taken away first."""


class Storage(Protocol):
    """place: as the user gave it, for messages and links. parallel: how many reads at once are worth it (1 = a disk)."""

    place: str
    parallel: int

    def read(self, name: str) -> bytes | None:
        """A file's content, None where there is no such file."""
        ...

    def write(self, name: str, content: bytes) -> None:
        """Write or replace one file, whole or not at all; folders above it are made."""
        ...

    def create(self, name: str, content: bytes) -> bool:
        """Write a file that is not there yet; False, and nothing written, where it is. Of many at once one succeeds."""
        ...

    def names(self, folder: str) -> Sequence[str]:
        """Names of the files and folders directly in a folder ("" = the store), sorted; () where there is no such folder."""
        ...

    def tree(self, folder: str) -> Mapping[str, int]:
        """Sizes in bytes of all files below a folder, by name from the store; what is half written is not among them."""
        ...

    def publish(self, folder: str, files: Mapping[str, bytes]) -> None:
        """Put a folder (with `MARK` among its files) in place of the one of that name, whole.

        Whoever reads meanwhile, or after a crash at any moment, finds the old folder, the new one, or one without `MARK`
        (which is none); never files of both under one `MARK`.
        """
        ...

    def remove(self, name: str) -> None:
        """Take away a file, or a folder with all in it; nothing where there is none."""
        ...

    def sweep(self) -> None:
        """Take away what killed processes left half written, never what a process that may be alive is writing."""
        ...

    def at(self, name: str) -> str:
        """The place of a file as others open it: a path or a URL."""
        ...


def checked(name: str) -> str:
    """The name, if it stays below the store whatever the system. Raises StoreError: a store's text is not trusted."""
    parts = name.split("/")
    if any(part in ("", ".", "..") for part in parts) or any(c in name for c in '\\\0:*?"<>|'):
        raise StoreError(f"{name[:80]!r} is no name of a file in a store")
    return name
