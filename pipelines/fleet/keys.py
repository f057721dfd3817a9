"""The key of a drive's work: a hash over all that its results depend on. An equal key means equal results.

What counts: the content of the logs, of the vehicle file and the suspension map that it names, of the mapping file, the
settings and the CAN databases; estimators, seed, --no-fix; cogest's version and the store's format. What does not count:
where files lie, when they were touched, and in what form a report is wanted.
"""

from __future__ import annotations

import hashlib
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass

from parsers import places
from parsers.errors import LogError
from parsers.places_text import FileFacts, is_url, masked
from parsers.remote_marks import mark_instead
from parsers.small_text import read_small_text
from pipelines.fleet.plain import json_bytes
from pipelines.fleet.records import Choices, Facts, FoundDrive
from pipelines.fleet.store import FORMAT

_BLOCK = 1 << 20
RECENT_NS = 2_000_000_000
"""A file written so short a time ago may change again without its time of change showing it: its stamp is not believed."""


@dataclass(frozen=True)
class _Stat:
    """size: bytes of all files. stamp: "" where it tells nothing. files: (name that counts, place), in order."""

    size: int
    stamp: str
    files: tuple[tuple[str, str], ...]


def _stamp(found: FileFacts) -> str:
    """The file's stamp, "" where a change could go unnoticed."""
    if found.etag:
        return found.etag
    if found.changed_ns is None or time.time_ns() - found.changed_ns < RECENT_NS:
        return ""
    return str(found.changed_ns)


def _stat(place: str) -> _Stat:
    """What a file or folder is, without reading it. Raises OSError."""
    if not is_url(place) or place.lower().startswith("file://"):
        folder = places.as_path(place).is_dir()
    else:
        try:
            found = places.facts(place)
            return _Stat(found.size, _stamp(found), (("", place),))
        except IsADirectoryError:
            folder = True
    if not folder:
        found = places.facts(place)
        return _Stat(found.size, _stamp(found), (("", place),))
    files = sorted(places.walk(place), key=lambda facts: facts.place)
    start = len(place.rstrip("/"))
    stamps = [(file.place[start:], file.size, _stamp(file)) for file in files]
    known = all(stamp for _, _, stamp in stamps)
    return _Stat(
        sum(file.size for file in files),
        hashlib.sha256(json_bytes(stamps)).hexdigest() if known else "",
        tuple((file.place[start:], file.place) for file in files),
    )


def _hashed(stat: _Stat) -> str:
    """SHA-256 of the files' content, with the names of those in a folder. Raises OSError.

    For a large file behind a URL, which is never read whole, stands the store's mark of its content (an S3 etag).
    """
    digest = hashlib.sha256()
    for name, place in stat.files:
        if name:
            digest.update(name.encode("utf-8", "surrogateescape") + b"\0")
        mark = mark_instead(place)
        if mark is not None:
            digest.update(mark.encode() + b"\0")
            continue
        with places.as_path(place).open("rb") as stream:
            while block := stream.read(_BLOCK):
                digest.update(block)
    return digest.hexdigest()


def facts_of(place: str, seen: Facts | None = None) -> Facts:
    """What an input is now; its content is hashed only where it may have changed since `seen`. Raises LogError."""
    try:
        stat = _stat(place)
        if seen is not None and stat.stamp and (seen.size, seen.stamp) == (stat.size, stat.stamp):
            return seen
        # stat before reading: what is written meanwhile shows as a change the next time
        return Facts(stat.size, stat.stamp, _hashed(stat))
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror or error})", path=masked(place)) from error


class Keys:
    """Keys of many drives with the same choices: what drives share (a vehicle file) is looked at once."""

    def __init__(self, choices: Choices) -> None:
        """choices: of the batch."""
        self._choices = choices
        self._shared: dict[str, Facts] = {}
        self._maps: dict[str, str | None] = {}

    def _facts(self, place: str, seen: Mapping[str, Facts]) -> Facts:
        if place not in self._shared:
            self._shared[place] = facts_of(place, seen.get(masked(place)))
        return self._shared[place]

    def _suspension_map(self, vehicle: str) -> str | None:
        """The place of the suspension map that a vehicle file names; None where it names none that is there."""
        if vehicle not in self._maps:
            self._maps[vehicle] = _named_map(vehicle)
        return self._maps[vehicle]

    def key_of(self, drive: FoundDrive, seen: Mapping[str, Facts]) -> tuple[str, dict[str, Facts]]:
        """The drive's key, and what each of its inputs is now, by place. seen: the same, as stored with the drive.

        Raises LogError where an input cannot be read.
        """
        facts: dict[str, Facts] = {}

        def one(place: str | None) -> str | None:
            if place is None:
                return None
            facts[masked(place)] = found = self._facts(place, seen)
            return found.sha256

        for place in drive.logs:
            # logs are looked at anew each time: they are many, and no other drive has them
            facts[masked(place)] = facts_of(place, seen.get(masked(place)))
        suspension_map = None if drive.vehicle is None else self._suspension_map(drive.vehicle)
        content = {
            "store": FORMAT,
            "cogest": self._choices.version,
            "estimators": _names(self._choices.estimators),
            "seed": self._choices.seed,
            "fix": self._choices.fix,
            "logs": [facts[masked(place)].sha256 for place in drive.logs],
            "vehicle": one(drive.vehicle),
            "suspension_map": one(suspension_map),
            "map": one(drive.map),
            "settings": one(drive.settings),
            "dbc": [one(place) for place in drive.dbc],
        }
        return hashlib.sha256(json_bytes(content)).hexdigest(), facts


def key_of(drive: FoundDrive, choices: Choices, seen: Mapping[str, Facts]) -> tuple[str, dict[str, Facts]]:
    """The key of one drive: see `Keys.key_of`."""
    return Keys(choices).key_of(drive, seen)


def _names(estimators: str | None) -> list[str] | None:
    """The estimators asked for, whatever the spaces between them."""
    if estimators is None:
        return None
    return [name for part in estimators.split(",") if (name := part.strip())]


def _named_map(vehicle: str) -> str | None:
    """The suspension map that a vehicle file names, if it is there; reading the vehicle file says what is wrong with it.

    Its text is read as `read_vehicle` reads it: with a byte order mark, or any line ends.
    """
    try:
        raw = tomllib.loads(read_small_text(places.as_path(vehicle)))
    except (OSError, ValueError, RecursionError):
        return None
    table = raw.get("vehicle")
    name = table.get("suspension_map") if isinstance(table, dict) else None
    if not isinstance(name, str) or not name.strip() or "\0" in name:
        return None
    place = places.place_of(places.as_path(vehicle).parent / name)
    try:
        places.facts(place)
    except OSError:
        return None
    return place
