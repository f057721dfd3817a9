"""A file or folder behind a URL, read as `pathlib.Path` is: what importers ask of a path, and no more."""

from __future__ import annotations

import errno
import io
import os
import stat
from collections.abc import Iterator, Mapping
from functools import total_ordering
from pathlib import Path, PurePosixPath
from tempfile import TemporaryFile
from threading import RLock
from typing import IO, Any, cast
from weakref import finalize

from parsers import places_fs
from parsers.places_ranges import SMALL_BYTES, RangeFile, Ranges
from parsers.places_text import FileFacts, is_url, masked

_BUFFER = 16 << 10


@total_ordering
class RemotePath:
    """A place behind a URL. str() and messages show it without secrets; `url` has them.

    What the store says of a file is asked once and kept, so that a log stays the same log while it is read.
    """

    def __init__(self, url: str, facts: FileFacts | None = None) -> None:
        """url: as given. facts: where they are known already."""
        scheme, rest = url.split("://", 1)
        query = ""
        if scheme.lower() in ("http", "https"):
            rest, mark, query = rest.partition("?")
            query = mark + query
        self._authority, _, key = rest.partition("/")
        self._scheme, self._key, self._query = scheme, key.strip("/"), query
        self._facts = facts
        self._is_folder: bool | None = None if facts is None else False
        self._ranges: Ranges | None = None
        self._whole: IO[bytes] | None = None
        self._children: dict[str, RemotePath] | None = None
        self._lock = RLock()

    # names

    @property
    def url(self) -> str:
        """The whole URL, secrets included: for opening, never for showing."""
        return f"{self._root}{self._key}{self._query}"

    @property
    def _root(self) -> str:
        return f"{self._scheme}://{self._authority}/"

    @property
    def name(self) -> str:
        """The last part; of a bucket or host its own name."""
        return self._key.rpartition("/")[2] or self._authority.rpartition("@")[2]

    @property
    def suffix(self) -> str:
        """As of pathlib."""
        return PurePosixPath(self.name).suffix

    @property
    def stem(self) -> str:
        """As of pathlib."""
        return PurePosixPath(self.name).stem

    @property
    def parent(self) -> RemotePath:
        """The folder; of a bucket or host itself."""
        return RemotePath(self._root + self._key.rpartition("/")[0]) if self._key else self

    @property
    def parents(self) -> tuple[RemotePath, ...]:
        """All folders above, the nearest first."""
        found = []
        here = self
        while here._key:
            here = here.parent
            found.append(here)
        return tuple(found)

    def __truediv__(self, name: str) -> RemotePath:
        """A file below; "." and ".." as on a disk, for a store knows none. Another URL is itself."""
        if is_url(name):
            return RemotePath(name)
        if self._children is not None and name in self._children:
            return self._children[name]
        parts = self._key.split("/") if self._key else []
        for part in name.split("/"):
            if part == "..":
                parts = parts[:-1]
            elif part not in ("", "."):
                parts.append(part)
        return RemotePath(self._root + "/".join(parts))

    def with_name(self, name: str) -> RemotePath:
        """Another file beside this one."""
        return self.parent / name

    def resolve(self, strict: bool = False) -> RemotePath:
        """Itself."""
        return self

    def absolute(self) -> RemotePath:
        """Itself."""
        return self

    def as_posix(self) -> str:
        """As it may be shown."""
        return str(self)

    def __str__(self) -> str:
        return masked(self.url).rstrip("/")

    def __repr__(self) -> str:
        return f"RemotePath({str(self)!r})"

    def __reduce__(self) -> tuple[type[RemotePath], tuple[str]]:
        # a copy, in this process or another, asks and fetches for itself
        return RemotePath, (self.url,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RemotePath) and self.url == other.url

    def __lt__(self, other: RemotePath) -> bool:
        return self.url < other.url

    def __hash__(self) -> int:
        return hash(self.url)

    # what the store says

    def _ask(self) -> None:
        """Ask the store what this is, once. Raises OSError."""
        with self._lock:
            if self._is_folder is not None:
                return
            entry = places_fs.info(self.url)
            folder = entry.get("type") == "directory"
            if not folder:
                self._facts = _facts_of(self.url, entry)
            self._is_folder = folder

    def facts(self) -> FileFacts:
        """Size, time and mark of a file. Raises OSError."""
        self._ask()
        if self._facts is None:
            raise IsADirectoryError(errno.EISDIR, "is a folder, not a file")
        return self._facts

    def asked_anew(self) -> FileFacts:
        """As `facts`, as it is now. Raises OSError."""
        return RemotePath(self.url).facts()

    def stat(self) -> os.stat_result:
        """Kind, size and time. Raises OSError."""
        self._ask()
        if self._facts is None:
            return os.stat_result((stat.S_IFDIR | 0o555, 0, 0, 1, 0, 0, 0, 0, 0, 0))
        changed = self._facts.changed_ns or 0
        seconds = changed // 1_000_000_000
        whole = (stat.S_IFREG | 0o444, 0, 0, 1, 0, 0, self._facts.size, seconds, seconds, seconds)
        return os.stat_result(whole, {"st_mtime_ns": changed})

    def exists(self) -> bool:
        """Whether there is a file or a folder. Raises OSError where the store cannot be asked."""
        try:
            self._ask()
        except FileNotFoundError:
            return False
        return True

    def is_file(self) -> bool:
        """Whether this is a file. Raises OSError where the store cannot be asked."""
        return self.exists() and not self._is_folder

    def is_dir(self) -> bool:
        """Whether this is a folder. Raises OSError where the store cannot be asked."""
        return self.exists() and bool(self._is_folder)

    def iterdir(self) -> Iterator[RemotePath]:
        """What is in the folder, by name; one listing, made once. Raises OSError."""
        with self._lock:
            if self._children is None:
                self._children = {entry.name: entry for entry in sorted(self._entries(deep=False))}
            return iter(self._children.values())

    def walk(self) -> Iterator[FileFacts]:
        """All files below, by place, or the file itself; one listing. Raises OSError."""
        files = sorted(entry for entry in self._entries(deep=True) if not entry._is_folder)
        if not files and not self.exists():
            raise FileNotFoundError(errno.ENOENT, "no such folder")
        for file in files:
            yield file.facts()

    def rglob(self, pattern: str) -> Iterator[RemotePath]:
        """All files below whose names match; one listing. Raises OSError."""
        for file in sorted(self._entries(deep=True)):
            if PurePosixPath(file.name).match(pattern):
                yield file

    def _entries(self, *, deep: bool) -> Iterator[RemotePath]:
        # names come without protocol, and of some stores with a "/" before them
        prefix = f"{self._authority}/"
        for entry in places_fs.listing(self.url, deep=deep):
            name = str(entry["name"])
            folder = entry.get("type") == "directory"
            if name.endswith("/") and not folder:
                continue  # a mark that some programs leave to show an empty folder
            url = name if "://" in name else f"{self._scheme}://{name.lstrip('/')}"
            if not url.partition("://")[2].startswith(prefix):
                url = self._root + name.lstrip("/")
            made = RemotePath(url)
            if made._key == self._key and folder:
                continue
            made._is_folder = folder
            if not folder:
                made._facts = _facts_of(made.url, entry)
            yield made

    # contents

    def ranges(self) -> Ranges:
        """The file's bytes, fetched as they are asked for; all streams of this path share them. Raises OSError."""
        with self._lock:
            if self._ranges is None:
                self._ranges = Ranges(self.facts().size, self.fetch)
            return self._ranges

    def fetch(self, start: int, stop: int) -> bytes:
        """The bytes [start, stop), from a temporary file where the server only sends whole files. Raises OSError."""
        if self._whole is None:
            try:
                return places_fs.fetch(self.url, start, stop)
            except places_fs.IgnoresRangesError as whole:
                with self._lock:
                    if self._whole is None:
                        self._whole = _temporary(whole.content)
                        finalize(self, self._whole.close)
        with self._lock:
            self._whole.seek(start)
            return self._whole.read(stop - start)

    def part(self, start: int, stop: int) -> bytes:
        """The bytes [start, stop): fetched as they are, but of a small file, which is kept whole. Raises OSError."""
        if self.facts().size > SMALL_BYTES:
            return self.fetch(start, stop)
        out = bytearray(stop - start)
        del out[self.ranges().read_into(start, memoryview(out)) :]
        return bytes(out)

    @property
    def was_downloaded(self) -> bool:
        """Whether the server sent the whole file where a part was asked for."""
        return self._whole is not None

    def forget(self) -> None:
        """Let go of the bytes that are kept in memory, and of a temporary file."""
        with self._lock:
            if self._ranges is not None:
                self._ranges.forget()
            if self._whole is not None:
                self._whole.close()
                self._whole = None

    def open(
        self,
        mode: str = "r",
        buffering: int = -1,
        encoding: str | None = None,
        errors: str | None = None,
        newline: str | None = None,
    ) -> IO[Any]:
        """A stream for reading, as of pathlib. Raises OSError."""
        if mode not in ("r", "rt", "rb"):
            raise OSError(errno.EROFS, f"cannot be opened with mode {mode!r}: only for reading")
        raw = RangeFile(self.ranges())
        if buffering == 0:
            return cast("IO[Any]", raw)
        buffered = io.BufferedReader(raw, _BUFFER if buffering < 2 else buffering)
        if mode == "rb":
            return buffered
        return io.TextIOWrapper(buffered, encoding=encoding or "utf-8", errors=errors, newline=newline)

    def read_bytes(self) -> bytes:
        """The whole file. Raises OSError."""
        with self.open("rb", buffering=0) as file:
            return bytes(file.read())

    def read_text(self, encoding: str | None = None, errors: str | None = None) -> str:
        """The whole file as text. Raises OSError."""
        with self.open("r", encoding=encoding, errors=errors) as file:
            return str(file.read())

    def copy_to(self, target: Path) -> None:
        """Download the whole file, a part at a time. Raises OSError."""
        size = self.facts().size
        with target.open("wb") as sink:
            for start in range(0, size, _PART):
                sink.write(places_fs.fetch(self.url, start, min(start + _PART, size)))


_PART = 8 << 20


def _temporary(content: bytes) -> IO[bytes]:
    """A nameless file with this content."""
    file = TemporaryFile(prefix="cogest-")  # noqa: SIM115 - open as long as its path is
    file.write(content)
    return file


def _facts_of(url: str, entry: Mapping[str, Any]) -> FileFacts:
    size = entry.get("size")
    if size is None:
        raise OSError(errno.ENOTSUP, "the server does not say how large the file is")
    return FileFacts(url, int(size), places_fs.changed_ns_of(entry), places_fs.etag_of(entry))
