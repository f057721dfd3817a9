"""Velocities along the compass side by side ("Velocity N", "Velocity E"; "vel_n", "vel_e"): their length in the plane is the speed over ground.

One of them alone is none: it follows the heading, and a vehicle that drives to the east would stand.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.mapping.contexts import blocking_words, path_of
from parsers.mapping.match import Judged, Refusal, choose_unit
from parsers.mapping.name_units import without_suffix
from parsers.mapping.words import NameTable, load_names, words_of
from parsers.table_names import split_unit

_SIGNAL = "gps_speed_2d"
_RANK = 75
"""Behind any channel that is called a speed over ground."""

_TOWARDS = {
    "n": "north", "north": "north", "nord": "north", "norte": "north", "vn": "north",
    "e": "east", "east": "east", "ost": "east", "este": "east", "est": "east", "ve": "east",
    "d": "down", "down": "down", "vd": "down", "u": "down", "up": "down", "vu": "down",
}  # fmt: skip
_GLUED = frozenset({"vn", "ve", "vd", "vu"})
_VELOCITIES = frozenset(
    {("velocity",), ("speed",), ("v",), ("gps", "velocity"), ("gps", "speed"), ("gps", "v")}
)
_MAY_BE = re.compile(r"v|speed|spd|geschw", re.IGNORECASE)
_ALONE = "a velocity along the compass, which is no speed of the vehicle"


def compass(channels: Sequence[ChannelInfo]) -> Judged:
    """The velocities to the north and to the east of one table or message; a pair is the speed over ground."""
    beside: dict[tuple[str, str], dict[str, tuple[ChannelInfo, str | None]]] = defaultdict(dict)
    table = load_names()
    for channel in channels:
        named = _direction(channel, table) if _MAY_BE.search(channel.name) else None
        if named is not None:
            place, towards, suffix = named
            beside[(channel.group, place)].setdefault(towards, (channel, suffix))
    found: list[Binding | Refusal] = []
    names: set[str] = set()
    for velocities in beside.values():
        if "north" in velocities and "east" in velocities:
            found += _judged(velocities)
            names |= {channel.name for channel, _ in velocities.values()}
    return Judged(tuple(found), frozenset(names))


def _direction(channel: ChannelInfo, table: NameTable) -> tuple[str, str, str | None] | None:
    """Of a velocity along the compass: where it stands (the path and words beside the direction), its direction, and the unit at its end."""
    plain, bracket = split_unit(path_of(channel))
    path = plain.strip()
    cut = max(path.rfind(mark) for mark in "./\\:") + 1
    for text, suffix in without_suffix(path[cut:]):
        words = [word for word in words_of(text, table) if word not in table.noise]
        towards = [word for word in words if word in _TOWARDS]
        rest = tuple(
            sorted("v" if word in _GLUED else word for word in words if word not in towards or word in _GLUED)
        )
        if len(towards) == 1 and rest in _VELOCITIES:
            return f"{path[:cut]} {' '.join(rest)}", _TOWARDS[towards[0]], suffix or bracket
    return None


def _judged(velocities: Mapping[str, tuple[ChannelInfo, str | None]]) -> Iterator[Binding | Refusal]:
    """What is made of a pair: its length, where both share a unit of speed."""
    pair = [velocities[towards] for towards in ("north", "east")]
    (north, _), (east, _) = pair
    for channel, _ in velocities.values():
        yield Refusal(channel.name, "speed", _ALONE)
    if any(blocking_words(channel, channel.name) for channel, _ in pair):
        return
    units = [choose_unit(channel, _SIGNAL, suffix, "name") for channel, suffix in pair]
    one, other = units
    if isinstance(one, str) or isinstance(other, str) or one[0].scale != other[0].scale:
        return
    if one[1] == "assumed SI" and ("down" not in velocities or north.family == "can"):
        # three of them are a receiver's; a pair without a unit may be anything
        return
    rule = f"column names {north.name!r} and {east.name!r}, the vector's length"
    yield Binding(_SIGNAL, (north.name, east.name), *one, rule, rank=_RANK, kind="length")
