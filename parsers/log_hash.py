"""The SHA-256 of logs, worked out in the background while they are decoded."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import TracebackType

from parsers.errors import LogError

_BLOCK = 1 << 20


def _files(path: Path) -> Iterator[tuple[bytes, Path]]:
    """The files of a log in a fixed order, each with the name that goes into the hash; a single file's does not."""
    if not path.is_dir():
        yield b"", path
        return
    names = sorted(p.relative_to(path).as_posix() for p in path.rglob("*") if p.is_file())
    for name in names:
        yield name.encode("utf-8", "surrogateescape") + b"\0", path / name


def hash_logs(paths: Sequence[Path], stop: threading.Event | None = None) -> str:
    """SHA-256 over the logs' bytes, in the order given. A folder: the name and the bytes of each file, by name.

    A file's own name does not count, so that a renamed log keeps its hash; names inside a folder do. stop: set by
    another thread, it ends the work with what was read. Raises LogError where a file cannot be read.
    """
    digest = hashlib.sha256()
    for path in paths:
        try:
            for name, file in _files(path):
                digest.update(name)
                with file.open("rb") as stream:
                    while not (stop and stop.is_set()) and (block := stream.read(_BLOCK)):
                        digest.update(block)
        except OSError as error:
            raise LogError(f"cannot be read ({error.strerror or error})", path=path) from error
    return digest.hexdigest()


class BackgroundHash:
    """Hash logs beside other work: hashing releases the GIL. Leaving the block early stops it."""

    def __init__(self, paths: Sequence[Path]) -> None:
        """Start at once."""
        self._stop = threading.Event()
        self._pool = ThreadPoolExecutor(1)
        self._future = self._pool.submit(hash_logs, tuple(paths), self._stop)

    def result(self) -> str:
        """Wait for the hash. Raises LogError where a file could not be read."""
        return self._future.result()

    def __enter__(self) -> BackgroundHash:
        """Start."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """An error or Ctrl-C must not wait until a large log is hashed."""
        self._stop.set()
        self._pool.shutdown()
