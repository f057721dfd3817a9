"""What stands around a channel's name: whether it is of this vehicle, and measured."""

from __future__ import annotations

import re

from parsers.channels import ChannelInfo
from parsers.mapping.words import NameTable, known_words, load_names, words_of

_CONTROL = re.compile(r"(car|vehicle|veh|ego)?_?controls?(_?state)?", re.IGNORECASE)
"""A part of a path that is a controller's: "carControl", "/vehicle/control". On a bus, "control" is a unit that measures."""

_OTHER_VEHICLE = re.compile(
    r"(?<![a-z])(front|rear|leading|following|other|adjacent|oncoming)[_ ]?(vehicle|veh|car)s?\d*[./\\\[]",
    re.IGNORECASE,
)
"""A part of a path that is another vehicle's: "front_vehicle.speed", "/otherCars[0].speed"."""

_ANY_TYPE = frozenset({"json", "object", "schema"})
"""What JSON calls any message at all says nothing of it."""

_DEVICE = re.compile(r"(?<=.)\\[^\\/:\[\]()]+:\d+(?=\s*([\[(]|$))")


def without_device(name: str) -> str:
    """A name without the device that INCA writes behind it: "YawRate" of "YawRate\\ETKC:1". Paths stay whole."""
    return _DEVICE.sub("", name)


def path_of(channel: ChannelInfo) -> str:
    """A channel's name without INCA's device."""
    return without_device(channel.name)


def blocking_words(channel: ChannelInfo, last: str) -> frozenset[str]:
    """The words that say that a channel is no measurement of this vehicle. last: the last part of its path."""
    table = load_names()
    words = words_of(path_of(channel), table)
    found = known_words(words, table.blocked) | known_words(words_of(last, table), table.blocked_fields)
    return found | _of_the_message(channel, table) | _followed(channel, last, table) | _others(channel)


def foreign_words(channel: ChannelInfo) -> frozenset[str]:
    """The words by which a message tells of something else than this vehicle now, whatever its type measures.

    They are of a command, a plan, a reference that is followed, or other road users. Empty for tables and buses, whose
    names a profile gives in full.
    """
    if channel.family not in ("ros", "json"):
        return frozenset()
    table = load_names()
    field = channel.tags.get("field", "")
    words = words_of(channel.name, table)
    found = known_words(words, table.contexts) | _of_the_message(channel, table)
    return found | _followed(channel, re.split(r"[./]+", field)[-1], table) | _others(channel)


def _others(channel: ChannelInfo) -> frozenset[str]:
    found = _OTHER_VEHICLE.search(channel.name)
    return frozenset() if found is None else frozenset({found[0].strip("./\\[")})


def _of_the_message(channel: ChannelInfo, table: NameTable) -> frozenset[str]:
    """What a message's type says: "planner" of "plan_msgs/PlannerState"."""
    words = words_of(channel.tags.get("type", ""), table)
    return known_words(words, table.contexts) if set(words) - _ANY_TYPE else frozenset()


def _followed(channel: ChannelInfo, last: str, table: NameTable) -> frozenset[str]:
    """What says that a value is followed, in the parts of a path but the last, unless an instrument is named."""
    name = path_of(channel)
    before = name.removesuffix(last)
    words = words_of(before, table)
    found = known_words(words, table.references)
    if found and known_words([*words, *words_of(channel.tags.get("type", ""), table)], table.measured):
        found = frozenset()
    if channel.family in ("table", "ros", "json"):
        found |= {part for part in re.split(r"[./\\:]+", before) if _CONTROL.fullmatch(part)}
    return found
