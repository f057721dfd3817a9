"""The SHA-256 of logs, worked out in the background while they are decoded.

Of a log behind a URL only parts are read: there the store's mark of the content (an S3 etag) stands for the bytes.
"""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from parsers.errors import LogError
from parsers.places import as_path, remote

if TYPE_CHECKING:
    from parsers.remote_marks import RemoteMark

_BLOCK = 1 << 20


def _files(path: Path) -> Iterator[tuple[bytes, Path | None]]:
    """The files of a log in a fixed order, each with what goes into the hash before its bytes; None = nothing follows.

    A folder's files: their names. A single file's name does not count.
    """
    far = remote(path)
    if far is not None:
        from parsers.remote_marks import remote_marks

        for each in remote_marks(far):
            head = f"{each.name}\0{each.mark or ''}\0".encode()
            yield head, None if each.mark else as_path(each.facts.place)
        return
    if not path.is_dir():
        yield b"", path
        return
    names = sorted(p.relative_to(path).as_posix() for p in path.rglob("*") if p.is_file())
    for name in names:
        yield name.encode("utf-8", "surrogateescape") + b"\0", path / name


def hash_logs(paths: Sequence[Path], stop: threading.Event | None = None) -> str:
    """SHA-256 over the logs' bytes, in the order given. A folder: the name and the bytes of each file, by name.

    A file's own name does not count, so that a renamed log keeps its hash; names inside a folder do. For the bytes behind
    a URL stands their `parsers.remote_marks.content_mark`. stop: set by another thread, it ends the work with what was
    read. Raises LogError where a file cannot be read.
    """
    digest = hashlib.sha256()
    for path in paths:
        try:
            for head, file in _files(path):
                digest.update(head)
                if file is None:
                    continue
                with file.open("rb") as stream:
                    while not (stop and stop.is_set()) and (block := stream.read(_BLOCK)):
                        digest.update(block)
        except OSError as error:
            raise LogError(f"cannot be read ({error.strerror or error})", path=path) from error
    return digest.hexdigest()


def _marks(path: Path, *, anew: bool) -> tuple[RemoteMark, ...]:
    """The marks of a remote log's files; none of a local one's. Raises LogError."""
    far = remote(path)
    if far is None:
        return ()
    from parsers.remote_marks import remote_marks

    try:
        return remote_marks(far, anew=anew)
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror or error})", path=path) from error


class BackgroundHash:
    """Hash logs beside other work: hashing releases the GIL. Leaving the block early stops it."""

    def __init__(self, paths: Sequence[Path]) -> None:
        """Start at once. Raises LogError where a store does not tell of a remote log."""
        self._stop = threading.Event()
        self._paths = tuple(paths)
        self._begun = [_marks(path, anew=False) for path in self._paths]
        self._pool = ThreadPoolExecutor(1)
        self._future = self._pool.submit(hash_logs, self._paths, self._stop)

    def result(self) -> str:
        """Wait for the hash. Raises LogError where a file could not be read, or a remote one is not what it was at first."""
        found = self._future.result()
        for path, begun in zip(self._paths, self._begun, strict=True):
            # ranges may be of two files that had the same name one after the other
            if begun and _marks(path, anew=True) != begun:
                raise LogError("was changed in its store while it was read", path=path, hint="try again")
        return found

    def notes(self) -> list[str]:
        """What the import record should say of how the logs are known."""
        if not any(self._begun):
            return []
        from parsers.remote_marks import mark_notes

        notes = [note for begun in self._begun for note in mark_notes(begun)]
        for path in self._paths:
            if (far := remote(path)) is not None and far.was_downloaded:
                notes.append(
                    f"{path} was downloaded whole to a temporary file: its server does not send parts of files"
                )
        return notes

    def __enter__(self) -> BackgroundHash:
        """Start."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """An error or Ctrl-C must not wait until a large log is hashed."""
        self._stop.set()
        self._pool.shutdown()
        for path in self._paths:
            if (far := remote(path)) is not None:
                far.forget()
