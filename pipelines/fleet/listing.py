"""What lies in a fleet's folder: every file once, in order. Links in a ring, stores and hidden files are passed over."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from dataclasses import dataclass, field

from pipelines.fleet.entries import Entry, Listing, is_hidden, path_of
from pipelines.fleet.records import BatchError
from pipelines.fleet.store import STORE_FILE

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
