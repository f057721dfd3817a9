"""Lists of one number for each wheel that do not say which place is which wheel: said, with what a mapping file must say, never guessed."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from parsers.channels import ChannelInfo
from parsers.field_notes import MAX_LIST
from parsers.mapping.bindings import Binding
from parsers.mapping.elements import ELEMENT, of_corners, wheel_of
from parsers.mapping.names import name_bindings
from parsers.mapping.overlooked import MOST_NAMED, SAID
from parsers.mapping.profiles import may_be_named, tags_of
from parsers.ros.layout import LISTED_SEQUENCE
from parsers.signals import WHEELS

_PLACE = re.compile(r"(?P<head>[^\[\]]*)\[(?P<place>\d+)\](?P<rest>[^\[\]]*)")
_OPEN_LENGTHS = frozenset({MAX_LIST, LISTED_SEQUENCE})
"""So many channels a list has whose length the log's definitions leave open: it may be of the wheels where its name says so."""
_FIRST = WHEELS[0]


def say_wheel_lists(
    channels: Sequence[ChannelInfo], proposals: Mapping[str, tuple[Binding, ...]], known: Collection[str]
) -> tuple[tuple[str, ...], frozenset[str]]:
    """One sentence on the lists that by their names are of what the log lacks, and their channels; no sentence where there are none.

    known: signals that the user's mapping file speaks of.
    """
    bound = {name for found in proposals.values() for each in found for name in each.needed}
    have = {signal.rpartition("_")[0] for signal in (*proposals, *known) if signal[-2:] in WHEELS}
    parts: list[str] = []
    told: set[str] = set()
    first: tuple[str, str] | None = None
    for (head, rest), places in _lists(channels).items():
        if len(places) != len(WHEELS) and len(places) not in _OPEN_LENGTHS:
            continue
        quantity = _quantity(places[0], sure=len(places) == len(WHEELS))
        if quantity is None or quantity in have or bound & {each.name for each in places}:
            continue
        told |= {each.name for each in places}
        first = first or (quantity, places[0].name)
        if len(parts) < MOST_NAMED:
            unit = f" [{places[0].unit}]" if places[0].unit else ""
            parts.append(f"{quantity.replace('_', ' ')} ({head}[0-{len(WHEELS) - 1}]{rest}{unit})")
    if first is None:
        return (), frozenset()
    quantity, name = first
    sentence = (
        f"{SAID}: {'; '.join(parts)}, in lists that do not say which place is which wheel; a mapping file says it, "
        f'as [signals.{quantity}_{_FIRST}] with channel = "{name}" where that is the front left wheel\'s, and so on for the others'
    )
    return (sentence,), frozenset(told)


def wheel_of_a_list(channel: ChannelInfo) -> str | None:
    """Why an element is not mapped whose list is of something at each wheel; None where it is no such element."""
    found = _PLACE.fullmatch(channel.name)
    if found is None or wheel_of(channel) is not None:
        return None
    quantity = _quantity(channel, sure=False)
    if quantity is None:
        return None
    return f"{quantity.replace('_', ' ')} of one wheel: which, the log does not say"


def _lists(channels: Sequence[ChannelInfo]) -> dict[tuple[str, str], list[ChannelInfo]]:
    """Elements of lists that lack a name, by what stands before and behind their places, in their order."""
    lists: dict[tuple[str, str], list[ChannelInfo]] = {}
    for channel in channels:
        found = _PLACE.fullmatch(channel.name) if channel.kind == "number" else None
        if found is not None and wheel_of(channel) is None:
            lists.setdefault((found["head"], found["rest"]), []).append(channel)
    return {key: places for key, places in lists.items() if len(places) >= len(WHEELS)}


def _quantity(channel: ChannelInfo, *, sure: bool) -> str | None:
    """ "wheel_speed" of a list's element that would be a wheel's speed if the log named its wheel; None where its name says no such thing.

    sure: whether the list has as many elements as there are wheels; else its name must tell of wheels, too.
    """
    if not may_be_named(channel, tags_of(channel)) or not (sure or of_corners(channel)):
        return None
    named = replace(channel, tags=MappingProxyType({**channel.tags, ELEMENT: _FIRST}))
    found = (each.signal for each in name_bindings(named) if isinstance(each, Binding))
    return next(
        (signal.removesuffix(f"_{_FIRST}") for signal in found if signal.endswith(f"_{_FIRST}")), None
    )
