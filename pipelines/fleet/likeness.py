"""How much of two files of one size and one beginning is the same: all of it, most of it, or, behind a URL, what was looked at."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

from parsers.places import remote
from pipelines.fleet.logs import Log

_BLOCKS, _BLOCK = 32, 8192
_WHOLE_BLOCK = 1 << 20


class Likeness(Enum):
    """Its value says it of a file, before the other one's name."""

    SAME = "the same bytes as"
    ENDS = "the same size, beginning and end as"
    MOSTLY = "the same size as, and for the most part the same bytes as,"
    NONE = ""


def likeness(a: Log, b: Log) -> Likeness:
    """How alike two recordings are whose first bytes are the same.

    Places spread over them come first, then, where all of these are the same, every byte; of files behind a URL the last bytes alone,
    since each look costs a way there and back.
    """
    if a.size != b.size:
        return Likeness.NONE
    try:
        first, second = a.path, b.path
        far, other = remote(first), remote(second)
        if far is not None and other is not None:
            last = max(0, a.size - _BLOCK)
            same = far.fetch(last, a.size) == other.fetch(last, b.size)
            return Likeness.ENDS if same else Likeness.NONE
        alike, count = _places_alike(first, second, a.size)
        if alike == count and _all_alike(first, second):
            return Likeness.SAME
        return Likeness.MOSTLY if 2 * alike > count else Likeness.NONE
    except OSError:
        return Likeness.NONE


def _places_alike(first: Path, second: Path, size: int) -> tuple[int, int]:
    """At how many of some places spread over two files they hold the same, and how many places these are."""
    places = [*range(0, size, max(_BLOCK, size // _BLOCKS)), max(0, size - _BLOCK)]
    alike = 0
    with first.open("rb") as one, second.open("rb") as two:
        for at in places:
            one.seek(at)
            two.seek(at)
            alike += one.read(_BLOCK) == two.read(_BLOCK)
    return alike, len(places)


def _all_alike(first: Path, second: Path) -> bool:
    with first.open("rb") as one, second.open("rb") as two:
        while block := one.read(_WHOLE_BLOCK):
            if block != two.read(_WHOLE_BLOCK):
                return False
    return True
