"""What lies in a fleet's folder: every file once, in order. Links in a ring, stores and hidden files are passed over."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

from pipelines.fleet.records import BatchError
from pipelines.fleet.store import STORE_FILE


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
        from parsers.places import FileFacts
        from parsers.places_path import RemotePath

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


_SEEN = "a link led to this already"

Lister = Callable[[str, str | None], Listing]
"""(folder, store) -> what lies in it. Raises BatchError where there is no such folder."""


def list_any(folder: str, store: str | None = None) -> Listing:
    """The files below a folder, here or at a URL. Raises BatchError where there is no such folder."""
    if folder.lower().startswith("file://"):
        folder = str(path_of(folder))
    if "://" in folder:
        from pipelines.fleet.listing_url import list_url

        return list_url(folder, store)
    return list_folder(folder, store)


def is_hidden(name: str) -> bool:
    """Whether a name is one that programs keep to themselves."""
    return name.startswith((".", "~$", "._")) or name in ("__MACOSX", "__pycache__", "$RECYCLE.BIN")


def list_folder(folder: str, store: str | None = None) -> Listing:
    """The files below a folder of this machine. Raises BatchError where it is none, or cannot be read."""
    root = os.path.abspath(folder)
    if not os.path.isdir(root):
        what = "is a file, not a folder" if os.path.exists(root) else "no such folder"
        hint = "for one log use `cogest analyze`" if os.path.isfile(root) else "give the folder with the logs"
        raise BatchError(what, path=folder, hint=hint)
    own = os.path.realpath(store) if store is not None and "://" not in store else None
    walk = _Walk(Listing(root), os.path.realpath(root), own)
    try:
        os.scandir(root).close()
    except OSError as error:
        raise BatchError(f"the folder cannot be read ({error.strerror})", path=folder) from error
    walk.run()
    walk.listing.entries.sort(key=lambda entry: entry.below)
    walk.listing.left_out.sort()
    return walk.listing


@dataclass
class _Walk:
    """A walk: where it is, and which real folders it has been in."""

    listing: Listing
    real_root: str
    store: str | None
    seen: set[str] = field(default_factory=set)

    def run(self) -> None:
        """Go through all folders."""
        self.seen.add(self.real_root)
        waiting = [(self.listing.root, "")]
        while waiting:
            place, below = waiting.pop()
            waiting += self._folder(place, below)

    def _leave(self, place: str, why: str, unread: str = "") -> None:
        """unread: its name below the folder, where nothing is known of what lies there."""
        self.listing.left_out.append((place, why))
        if unread:
            self.listing.unread.append(unread)

    def _folder(self, place: str, below: str) -> list[tuple[str, str]]:
        """Take in the files of one folder; the folders in it."""
        try:
            with os.scandir(place) as found:
                entries = sorted(
                    (entry for entry in found if not is_hidden(entry.name)), key=lambda e: e.name
                )
        except OSError as error:
            self._leave(place, f"the folder cannot be read ({error.strerror or error})", below)
            return []
        if any(entry.name == STORE_FILE for entry in entries):
            self._leave(place, "a results store of cogest")
            return []
        folders: list[tuple[str, str]] = []
        for entry in entries:
            name = f"{below}/{entry.name}" if below else entry.name
            try:
                entry.name.encode("utf-8")
            except UnicodeEncodeError:
                self._leave(entry.path, "its name is no valid text: rename it")
                continue
            try:
                self._entry(entry, name, folders)
            except OSError as error:
                self._leave(entry.path, f"cannot be looked at ({error.strerror or error})", name)
        return folders

    def _entry(self, entry: os.DirEntry[str], name: str, folders: list[tuple[str, str]]) -> None:
        """Take in one entry of a folder. Raises OSError."""
        if entry.is_symlink() and not self._is_new_link(entry, name):
            return
        if entry.is_dir():
            real = os.path.realpath(entry.path)
            if real == self.store:
                return
            if real in self.seen:
                self._leave(entry.path, _SEEN)
                return
            self.seen.add(real)
            folders.append((entry.path, name))
            return
        facts = entry.stat()
        if stat.S_ISREG(facts.st_mode):
            self.listing.entries.append(Entry(entry.path, name, facts.st_size, facts.st_mtime_ns))
        else:
            self._leave(entry.path, "a pipe or a device, not a file")

    def _is_new_link(self, entry: os.DirEntry[str], name: str) -> bool:
        """Whether a link leads to something that the walk does not come by anyway; says so where it does not."""
        real = os.path.realpath(entry.path)
        if not os.path.exists(real):
            self._leave(entry.path, "a link that leads nowhere", name)
            return False
        if os.path.commonpath([real, self.real_root]) in (real, self.real_root):
            self._leave(entry.path, "a link to what is in the fleet's folder already")
            return False
        above = real
        while above not in self.seen and os.path.dirname(above) != above:
            above = os.path.dirname(above)
        if above in self.seen:
            self._leave(entry.path, _SEEN)
            return False
        if not os.path.isdir(real):
            self.seen.add(real)
        return True


def path_of(place: str) -> Path:
    """A place as something that can be opened and asked like a path."""
    if "://" not in place:
        return Path(place)
    from parsers.places import as_path

    return as_path(place)
