"""Places of files: paths of this machine and URLs that fsspec opens ("s3://bucket/drive.mcap"), in one way for both.

A place is text. `as_path` makes of it what importers read: a `pathlib.Path`, or for a URL a `RemotePath`, which reads like
one but is fetched in ranges. Failures are OSError with a reason in words in `strerror`, whatever the store raises.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, cast
from urllib.parse import urlsplit

from parsers.places_text import FileFacts, is_url

if TYPE_CHECKING:
    from parsers.places_path import RemotePath


def as_path(place: str | Path) -> Path:
    """A place as importers want it. A `file://` URL is a local path. What is a path already stays as it is."""
    if not isinstance(place, str) or not is_url(place):
        return Path(place) if isinstance(place, str) else place
    if place.lower().startswith("file://"):
        from urllib.request import url2pathname

        return Path(url2pathname(urlsplit(place).path))
    from parsers.places_path import RemotePath

    # reads as a Path does, but is none: what writes or asks the disk must fail, not look for a folder "s3:"
    return cast("Path", RemotePath(place))


def remote(path: Path) -> RemotePath | None:
    """The path as a remote one, None for a local path."""
    if isinstance(path, Path):
        return None
    from parsers.places_path import RemotePath

    return path if isinstance(path, RemotePath) else None


def place_of(path: Path) -> str:
    """The place of a path: text that `as_path` makes the same path of, secrets included. To be shown: str(path)."""
    far = remote(path)
    return str(path) if far is None else far.url


def join(folder: str, *names: str) -> str:
    """The place of a file below a folder; names with "/" between their parts."""
    if not is_url(folder):
        return str(Path(folder, *names))
    return "/".join((folder.rstrip("/"), *(name.strip("/") for name in names)))


def parent(place: str) -> str | None:
    """The folder of a place; None at the top (a bucket, a host, the root of a disk)."""
    path = as_path(place)
    above = path.parent
    return None if above == path else place_of(above)


def facts(place: str) -> FileFacts:
    """What is known of a file without reading it. Raises OSError (FileNotFoundError, IsADirectoryError …)."""
    far = remote(as_path(place))
    if far is not None:
        return far.facts()
    found = os.stat(as_path(place))
    return FileFacts(place, found.st_size, found.st_mtime_ns)


def walk(place: str) -> Iterator[FileFacts]:
    """All files below a folder (or the file itself), by place; one listing for thousands. Raises OSError."""
    path = as_path(place)
    far = remote(path)
    if far is not None:
        yield from far.walk()
        return
    if not path.is_dir():
        yield facts(str(path))
        return
    for folder, below, names in os.walk(path, onerror=_raise):
        below.sort()
        for name in sorted(names):
            file = Path(folder, name)
            if file.is_file():
                yield facts(str(file))


def _raise(error: OSError) -> None:
    raise error


def read_bytes(place: str, limit: int | None = None) -> bytes:
    """The file's bytes, or its first `limit`. Raises OSError."""
    with as_path(place).open("rb") as file:
        return file.read() if limit is None else file.read(limit)
