"""Names that JSON messages give to the elements of a list: [{"name": "fl", "speed": 12.1}, {"name": "fr", "speed": 12.3}, ...]."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence

_NAMES = ("name", "id", "label", "wheel", "corner", "position", "pos", "location", "place")
"""Keys under which an element's name stands, the plainest first."""


def may_name(keys: Collection[str]) -> bool:
    """Whether any of an element's keys is one under which its name stands, so that messages must be looked at for it."""
    return any(key.lower() in _NAMES for key in keys)


def element_names(elements: Sequence[Mapping[str, Collection[str]]]) -> list[str]:
    """The name of each element of a list, "" where messages state none, or change it, or give it to two.

    elements: of each its keys with texts and the different ones that messages have there.
    """
    names = [_name(texts) for texts in elements]
    count = Counter(names)
    return [name if count[name] == 1 else "" for name in names]


def _name(texts: Mapping[str, Collection[str]]) -> str:
    stated = {key.lower(): found for key, found in texts.items()}
    return next((text for key in _NAMES if len(stated.get(key, ())) == 1 for text in stated[key]), "")
