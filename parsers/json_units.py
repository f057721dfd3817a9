"""Units that JSON messages state themselves, as texts beside the numbers: {"value": 79.2, "unit": "km/h"}, {"speed": 79.2, "speed_unit": "km/h"}."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from parsers.unit_words import is_unit

_SAYS = ("unit", "units", "uom")
_NUMBERS = frozenset({"value", "values", "val", "v", "data", "x", "y", "z", "min", "max", "mean"})
MOST_TEXTS = 2
"""Different texts of a place that are kept: two are as good as many, since no unit changes."""


def units_beside(texts: Mapping[str, Collection[str]], numbers: Collection[str]) -> dict[str, str]:
    """Key of a number -> its unit. texts: key -> the different texts that messages have there, of one object; numbers: its keys with numbers.

    A `unit` is that of what is called a value, or of the object's only number.
    """
    found: dict[str, str] = {}
    for key, stated in texts.items():
        (unit,) = stated if len(stated) == 1 else ("",)
        if not is_unit(unit):
            continue
        whole, _, last = key.lower().rpartition("_")
        if key.lower() in _SAYS:
            named = [each for each in numbers if each.lower() in _NUMBERS]
            found |= dict.fromkeys(named or (numbers if len(numbers) == 1 else ()), unit)
        elif last in _SAYS:
            found |= dict.fromkeys((each for each in numbers if each.lower() == whole), unit)
    return found


def says_units(keys: Collection[str]) -> bool:
    """Whether any of an object's keys is one under which a unit stands, so that messages must be looked at for it."""
    return any(key.lower().rpartition("_")[2] in _SAYS for key in keys)
