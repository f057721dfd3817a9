"""Places as text: which are URLs, what of them may be shown, and what a store says of a file."""

from __future__ import annotations

import re
from dataclasses import dataclass

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]+://")


_IN_TEXT = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]+://[^\s'\"<>]+")


@dataclass(frozen=True)
class FileFacts:
    """A file as its store tells of it. place: text for `as_path`, with all that it takes to open it (see `masked`).

    size: bytes. changed_ns: since 1970, None where the store does not say. etag: the store's own mark of the content.
    """

    place: str
    size: int
    changed_ns: int | None = None
    etag: str | None = None


def is_url(text: str) -> bool:
    """Whether a place is a URL (`file://` too). One letter and a colon is a drive of Windows."""
    return _URL.match(text) is not None


def masked(place: str) -> str:
    """A place as it may be shown: without user, password and query, which may be a signature."""
    if not is_url(place):
        return place
    scheme, rest = place.split("://", 1)
    if scheme.lower() in ("http", "https"):
        rest, mark, _ = rest.partition("?")
        rest = rest.partition("#")[0] + ("?…" if mark else "")
    authority, slash, path = rest.partition("/")
    user, at, host = authority.rpartition("@")
    return f"{scheme}://{'…@' if at and user else ''}{host}{slash}{path}"


def masked_text(text: str) -> str:
    """A text (a message of a library, a command line) with every URL in it masked."""
    return _IN_TEXT.sub(lambda found: masked(found.group()), text)
