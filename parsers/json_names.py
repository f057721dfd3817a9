"""Names that JSON messages give to the elements of a list: [{"name": "fl", "speed": 12.1}, ...], or {"names": ["fl", ...], "speeds": [12.1, ...]}."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence

_LISTS = ("names", "labels", "label", "order", "wheels", "corners", "positions", "ids")
"""Keys of a list of texts, or of one text with commas, that names the elements of the lists beside it."""
_NAMES = ("name", "id", "label", "wheel", "corner", "position", "pos", "location", "place")
"""Keys under which an element's name stands, the plainest first."""


def may_name(keys: Collection[str]) -> bool:
    """Whether any of an element's keys is one under which its name stands, so that messages must be looked at for it."""
    return any(key.lower() in _NAMES for key in keys)


def may_list_names(keys: Collection[str]) -> bool:
    """Whether any of an object's keys is one under which the names of its lists' elements may stand."""
    return any(key.lower() in _LISTS for key in keys)


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


def names_beside(texts: Mapping[str, Sequence[Collection[str]]]) -> list[str]:
    """The names that the elements of an object's lists of numbers have by a list of texts beside them; none where there is no such list.

    texts: of each key with texts, one or a list of them, the different ones that messages have at each place.
    """
    stated = {key.lower(): places for key, places in texts.items()}
    for key in _LISTS:
        places = stated.get(key, ())
        if not places or any(len(each) != 1 for each in places):
            continue
        names = [text for each in places for text in each]
        names = [part.strip() for part in names[0].split(",")] if len(names) == 1 else names
        if len(names) > 1 and len({*names}) == len(names):
            return names
    return []
