"""A store in an object store (S3 and the like, whatever fsspec opens): no renames, but every object appears whole.

A drive's folder cannot be exchanged in one step. So its mark is taken away first and written last: a folder with a mark is
whole, one without is none. What was written is compared with what is there before it counts, so that of two writers of one
drive none leaves a mixture.
"""

from __future__ import annotations

import hashlib
import random
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

from parsers import places_fs
from parsers.errors import StoreError
from parsers.places import join
from parsers.places_text import masked
from pipelines.fleet.storage import MARK, checked

T = TypeVar("T")

LEFT_BEHIND_S = 24 * 3600.0
"""A drive's folder without its mark to which nobody has written for so long is taken for left behind."""
_ATTEMPTS = 6
_FEW = 3
_AT_ONCE = 16
_DEPTH = 2
"""Of a drive's folder below the store: drives/<two digits>/<drive_id>."""


class UrlStorage:
    """A folder behind a URL as a store's place. Nothing is made before the first write."""

    parallel = _AT_ONCE

    def __init__(self, place: str) -> None:
        """place: the URL; it need not be there yet. Raises StoreError where no library opens it."""
        self._url = place.rstrip("/")
        self.place = masked(self._url)
        self._lock = threading.Lock()
        with self._errors(""):
            self._fs, self._root = places_fs.file_system(self._url)
            self._root = self._root.rstrip("/")

    def at(self, name: str) -> str:
        """The file's URL, without secrets."""
        return masked(join(self._url, checked(name))) if name else self.place

    @contextmanager
    def _errors(self, name: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            where = f"{self.place}/{name}" if name else self.place
            raise StoreError(f"the store failed: {error.strerror or error}", path=where) from error

    def _ask(self, ask: Callable[[], T]) -> T:
        """One request, again where the connection breaks. Raises OSError in words."""
        return places_fs.again(ask, self._url)

    def _path(self, name: str) -> str:
        return f"{self._root}/{checked(name)}" if name else self._root

    # reading

    def read(self, name: str) -> bytes | None:
        """See `Storage`."""
        with self._errors(name):
            return self._read(name)

    def _read(self, name: str) -> bytes | None:
        path = self._path(name)
        try:
            return bytes(self._ask(lambda: self._fs.cat_file(path)))
        except (FileNotFoundError, IsADirectoryError):
            return None

    def names(self, folder: str) -> Sequence[str]:
        """See `Storage`."""
        path = self._path(folder)
        with self._errors(folder):
            try:
                found: list[str] = self._ask(lambda: self._fs.ls(path, detail=False))
            except (FileNotFoundError, NotADirectoryError):
                return ()
        below = {str(each).rstrip("/").rpartition("/")[2] for each in found if self._inside(str(each), path)}
        return sorted(below)

    @staticmethod
    def _inside(found: str, folder: str) -> bool:
        return found.strip("/").startswith(folder.strip("/") + "/") and found.strip("/") != folder.strip("/")

    def tree(self, folder: str) -> Mapping[str, int]:
        """See `Storage`. One listing, which an object store gives a thousand files at a time."""
        with self._errors(folder):
            return {name: int(entry.get("size") or 0) for name, entry in self._entries(folder).items()}

    def _entries(self, folder: str) -> dict[str, Mapping[str, Any]]:
        """What the store says of every file below a folder (or of the file), by name. Raises OSError."""
        path = self._path(folder)
        try:
            found: dict[str, Mapping[str, Any]] = self._ask(lambda: self._fs.find(path, detail=True))
        except FileNotFoundError:
            return {}
        skip = len(self._root.strip("/")) + 1
        names = {place.strip("/")[skip:]: entry for place, entry in found.items() if not place.endswith("/")}
        # of some stores "a/b" lists "a/bc" too
        own = {n: e for n, e in names.items() if not folder or n == folder or n.startswith(folder + "/")}
        return dict(sorted(own.items()))

    # writing

    def write(self, name: str, content: bytes) -> None:
        """See `Storage`."""
        with self._errors(name):
            self._write(name, content)

    def _write(self, name: str, content: bytes) -> None:
        path = self._path(name)
        self._ask(lambda: self._fs.pipe_file(path, content))

    def create(self, name: str, content: bytes) -> bool:
        """See `Storage`. S3 does it with a condition (If-None-Match) in the request itself."""
        path = self._path(name)
        asked = 0

        def ask() -> bool:
            nonlocal asked
            asked += 1
            try:
                self._fs.pipe_file(path, content, mode="create")
            except FileExistsError:
                return False
            except Exception as error:
                if any(
                    word in str(error)
                    for word in ("PreconditionFailed", "pre-conditions", "ConditionalRequest")
                ):
                    return False
                raise
            return True

        with self._errors(name):
            made = self._ask(ask)
            # where the first answer was lost, the file that is there may be ours
            return made or (asked > 1 and self._read(name) == content)

    def publish(self, folder: str, files: Mapping[str, bytes]) -> None:
        """See `Storage`."""
        if MARK not in files:
            raise ValueError(f"a folder is published with its {MARK}")
        new = {f"{folder}/{checked(name)}": content for name, content in files.items()}
        mark = f"{folder}/{MARK}"
        with self._errors(folder):
            for attempt in range(_ATTEMPTS):
                old = self._entries(folder)
                self._remove([mark] if mark in old else [])
                self._remove([name for name in old if name not in new])
                self._write_all({name: content for name, content in new.items() if name != mark})
                self._write(mark, new[mark])
                if self._holds(folder, new):
                    return
                # another process writes this drive too: of both, the one that is alone in the end stays
                self._remove([mark])
                time.sleep(random.uniform(0.0, 0.2 * 2**attempt))
        raise StoreError("cannot be replaced: others keep writing it", path=f"{self.place}/{folder}")

    def _write_all(self, files: Mapping[str, bytes]) -> None:
        with ThreadPoolExecutor(max(1, min(_AT_ONCE, len(files)))) as pool:
            for _ in pool.map(lambda item: self._write(*item), files.items()):
                pass

    def _holds(self, folder: str, files: Mapping[str, bytes]) -> bool:
        """Whether a folder holds these files and no others."""
        found = self._entries(folder)
        return found.keys() == files.keys() and all(
            self._is(name, files[name], entry) for name, entry in found.items()
        )

    def _is(self, name: str, content: bytes, entry: Mapping[str, Any]) -> bool:
        """Whether a file has this content. S3's etag is an MD5 of it, but for encrypted and large objects."""
        if entry.get("size") != len(content):
            return False
        etag = places_fs.etag_of(entry)
        if etag == hashlib.md5(content, usedforsecurity=False).hexdigest():
            return True
        return self._read(name) == content

    def remove(self, name: str) -> None:
        """See `Storage`. Marks go first: what is half removed is no drive."""
        with self._errors(name):
            self._remove_tree(checked(name))

    def _remove_tree(self, name: str) -> None:
        found = self._entries(name)
        self._remove([each for each in found if each.endswith("/" + MARK)])
        self._remove([each for each in found if not each.endswith("/" + MARK)])

    def _remove(self, names: Iterable[str]) -> None:
        """Take files away, many with one request where the store can; one that is gone is no error. Raises OSError."""
        paths = [self._path(name) for name in names]
        if len(paths) > _FEW:
            try:
                self._ask(lambda: self._fs.rm(paths))
                return
            except FileNotFoundError:
                pass
        for path in paths:
            # alone: not every version of s3fs says which of many could not be removed, and a mark must be gone
            self._remove_one(path)

    def _remove_one(self, path: str) -> None:
        try:
            self._ask(lambda: self._fs.rm_file(path))
        except FileNotFoundError:
            return

    def sweep(self) -> None:
        """See `Storage`. Nobody can tell whether another machine's process lives: what is old is taken away."""
        with self._errors(""):
            folders: dict[str, list[tuple[str, Mapping[str, Any]]]] = {}
            for name, entry in self._entries("drives").items():
                parts = name.split("/")
                if len(parts) > _DEPTH + 1:
                    folders.setdefault("/".join(parts[: _DEPTH + 1]), []).append((name, entry))
            before = (time.time() - LEFT_BEHIND_S) * 1e9
            for folder, files in folders.items():
                if any(name == f"{folder}/{MARK}" for name, _ in files):
                    continue
                changed = [places_fs.changed_ns_of(entry) for _, entry in files]
                if all(each is not None and each < before for each in changed):
                    self._remove([name for name, _ in files])
