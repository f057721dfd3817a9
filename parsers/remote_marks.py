"""What stands for the bytes of a log behind a URL, of which only parts are read: the store's own mark, and the size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from parsers.places import as_path, remote
from parsers.places_text import FileFacts, masked

if TYPE_CHECKING:
    from parsers.places_path import RemotePath

_TOLD = 3
_READ_BYTES = 1 << 20


def content_mark(facts: FileFacts) -> str | None:
    """A remote file's content in words: its etag, else the time of its last change, and its size; None where neither is known.

    Equal marks mean equal bytes as far as the store can be trusted: S3 makes an etag of the bytes (in the parts in which
    they were sent), so that a copy in another bucket may have another etag, but other bytes never the same one.
    """
    scheme = facts.place.partition("://")[0].lower()
    if facts.etag:
        return f"{scheme} etag {facts.etag}, {facts.size} bytes"
    if facts.changed_ns:
        return f"{scheme} changed at {facts.changed_ns} ns, {facts.size} bytes"
    return None


def mark_instead(place: str) -> str | None:
    """What to hash instead of a file's bytes; None where these are to be read: of local and of small files. Raises OSError."""
    far = remote(as_path(place))
    if far is None or far.facts().size <= _READ_BYTES:
        return None
    return content_mark(far.facts())


@dataclass(frozen=True)
class RemoteMark:
    """A file of a remote log. name: below the log's folder, "" where the log is a file. mark: None = none is known."""

    name: str
    facts: FileFacts
    mark: str | None


def remote_marks(far: RemotePath, *, anew: bool = False) -> tuple[RemoteMark, ...]:
    """The marks of a log's files, by name. anew: as they are now, not as they were when first asked. Raises OSError."""
    if not far.is_dir():
        known = far.asked_anew() if anew else far.facts()
        return (RemoteMark("", known, content_mark(known)),)
    top = far.url.rstrip("/") + "/"
    return tuple(RemoteMark(e.place.removeprefix(top), e, content_mark(e)) for e in far.walk())


def mark_notes(marks: tuple[RemoteMark, ...]) -> list[str]:
    """What the import record says of it."""
    notes = [
        f"{masked(each.facts.place)} is known by {each.mark}, not by a hash of its bytes"
        for each in marks[:_TOLD]
        if each.mark
    ]
    if len(marks) > _TOLD:
        notes.append(f"and so are {len(marks) - _TOLD} more files of this log")
    return notes
