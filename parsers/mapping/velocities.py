"""The letters u and v side by side: a body's velocities ahead and to the side, as textbooks of vehicle dynamics and of flight call them.

A `v` alone is a speed. Beside `u` it is not: taken for one, a vehicle that drives would hardly move.
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
from parsers.mapping.words import load_names
from parsers.table_names import split_unit
from parsers.unit_words import says_unit
from parsers.units import find_unit

_AHEAD, _ACROSS = "u", "v"
_RATES = ("p", "q", "r")
_MAY_BE = re.compile(r"(?<![A-Za-z])[Uu](?![A-Za-z])")
_RANK = 75
"""Behind any channel that is called a speed: u and v are a wind's, too."""
_SURE = "u and v are the velocities ahead and to the side: the latter is no speed of the vehicle"
_OPEN = "beside u it may be the velocity to the side, and u the one ahead: a mapping file says which of them is the speed"


def velocities(channels: Sequence[ChannelInfo]) -> Judged:
    """The columns u and v of one table or message: u is the speed where angular rates p, q, r (or r with its unit) stand beside them, and v never is.

    Where only one of them has a unit of speed they are no pair (u is a voltage or what a controller puts out).
    """
    if not any(_MAY_BE.search(channel.name) for channel in channels):
        return Judged((), frozenset())
    found: list[Binding | Refusal] = []
    names: set[str] = set()
    for beside in _letters(channels).values():
        for ahead, across in ((_AHEAD, _ACROSS), (_AHEAD.upper(), _ACROSS.upper())):
            if ahead in beside and across in beside and _pair(beside[ahead], beside[across]):
                found += _judged(beside[ahead], beside[across], sure=_turns(beside))
                names |= {beside[ahead].name, beside[across].name}
    return Judged(tuple(found), frozenset(names))


def _letters(channels: Sequence[ChannelInfo]) -> Mapping[tuple[str, str], dict[str, ChannelInfo]]:
    """Where a channel stands (its group and the path before its name) -> its letter -> the channel."""
    table = load_names()
    passing = table.noise | table.worse
    beside: dict[tuple[str, str], dict[str, ChannelInfo]] = defaultdict(dict)
    for channel in channels:
        path = split_unit(path_of(channel))[0].strip()
        cut = max(path.rfind(mark) for mark in "./\\:") + 1
        for text, _ in without_suffix(path[cut:]):
            pieces = [piece for piece in text.replace("_", " ").split() if piece.lower() not in passing]
            if len(pieces) == 1 and len(pieces[0]) == 1:
                beside[(channel.group, path[:cut])].setdefault(pieces[0], channel)
                break
    return beside


def _pair(ahead: ChannelInfo, across: ChannelInfo) -> bool:
    """Whether both have units of speed, or neither says any."""
    speeds = [find_unit(each.unit, "speed") is not None for each in (ahead, across)]
    return all(speeds) or not (says_unit(ahead.unit) or says_unit(across.unit))


def _turns(beside: Mapping[str, ChannelInfo]) -> bool:
    """Whether a body's angular rates stand beside them, in the same letters: all three, or r with a unit of its own."""
    lower = {letter.lower(): channel for letter, channel in beside.items()}
    if all(letter in lower for letter in _RATES):
        return all(
            find_unit(lower[letter].unit, "angular_rate") or not says_unit(lower[letter].unit)
            for letter in _RATES
        )
    return "r" in lower and find_unit(lower["r"].unit, "angular_rate") is not None


def _judged(ahead: ChannelInfo, across: ChannelInfo, *, sure: bool) -> Iterator[Binding | Refusal]:
    """What is made of a pair. sure: whether it is a body's."""
    if not sure:
        yield Refusal(across.name, "speed", _OPEN, told=True)
        yield Refusal(ahead.name, "speed", "beside v it may be the velocity ahead: a mapping file says so")
        return
    yield Refusal(across.name, "speed", _SURE)
    chosen = choose_unit(ahead, "speed", None, "")
    if not isinstance(chosen, str) and not blocking_words(ahead, ahead.name):
        rule = f"column name {ahead.name!r} beside {across.name!r} and angular rates"
        yield Binding("speed", (ahead.name,), *chosen, rule, rank=_RANK)
