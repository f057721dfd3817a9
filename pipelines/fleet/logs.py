"""A recording as it was found, before it is known which drive it is of."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from pipelines.fleet.entries import Placed, path_of
from pipelines.fleet.table_heads import TableLook


@dataclass(frozen=True)
class Log(Placed):
    """A recording. place, below, size: as `Entry` has them; a folder where the format is one. stem: its name without suffix.

    format, title: of its importer; "" where none claims it, and `trouble` then says why it will fail. look: how to read its
    time, of tables of text. digest: of its first bytes, "" for a folder. parts: names of the files in it, of a folder.
    """

    size: int
    stem: str
    format: str
    title: str
    trouble: str = ""
    look: TableLook | None = field(default=None, repr=False, compare=False)
    digest: bytes = b""
    changed: int = 0

    @property
    def path(self) -> Path:
        """To open it."""
        return path_of(self.place)
