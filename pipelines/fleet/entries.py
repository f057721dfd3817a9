"""The files of a fleet's folder as they were listed, here or at a URL."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import cast


@dataclass(frozen=True)
class Placed:
    """What lies in a fleet's folder. place: absolute path or URL. below: its name there, with forward slashes."""

    place: str
    below: str

    @property
    def folder(self) -> str:
        """The folder below the fleet's, "" for the fleet's own."""
        return self.below.rpartition("/")[0]

    @property
    def name(self) -> str:
        """Its own name."""
        return self.below.rpartition("/")[2]


@dataclass(frozen=True)
class Entry(Placed):
    """A file. changed: when it was last written, in ns since 1970; 0 where that is not known."""

    size: int
    changed: int = 0

    @property
    def path(self) -> Path:
        """To open it. Of a file behind a URL what the listing said of it is not asked for again."""
        if "://" not in self.place or self.place.lower().startswith("file:"):
            return path_of(self.place)
        from parsers.places_path import RemotePath
        from parsers.places_text import FileFacts

        return cast("Path", RemotePath(self.place, FileFacts(self.place, self.size, self.changed or None)))


@dataclass
class Listing:
    """All files below a folder, by name; left_out: (place, why) of what was not looked into.

    unread: names below the folder of what could not be looked into now (a link to a share that is away): what lies there is not known.
    """

    root: str
    entries: list[Entry] = field(default_factory=list)
    left_out: list[tuple[str, str]] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)


def is_hidden(name: str) -> bool:
    """Whether a name is one that programs keep to themselves."""
    return name.startswith((".", "~$", "._")) or name in ("__MACOSX", "__pycache__", "$RECYCLE.BIN")


def path_of(place: str) -> Path:
    """A place as something that can be opened and asked like a path."""
    if "://" not in place:
        return Path(place)
    from parsers.places import as_path

    return as_path(place)
