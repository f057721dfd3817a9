"""Names that a signal's name is known by and that mean something else in many logs: what must speak for the signal."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.contexts import path_of
from parsers.mapping.words import load_names, words_of
from parsers.signals import SIGNALS

_PLAIN = frozenset({"angle", "ang", "deg", "rad", "euler", "m", "mm", "pos", "position", "pose"})
_RATE = frozenset({"dot", "p", "rate", "s", "ps", "dps", "rads"})
_YAW = frozenset({"psi", "yaw", "heading"})
_ROLL = frozenset({"phi", "roll"})
_OWN_FRAME = frozenset({"body", "base", "forward"})


def attitudes(channels: Sequence[ChannelInfo]) -> frozenset[str]:
    """The channels called theta that are a pitch angle or its rate, by what stands beside them.

    Theta is the pitch angle beside psi, or beside phi where there is no x and y; beside x and y it is a heading.
    """
    if not any("theta" in channel.name.lower() for channel in channels):
        return frozenset()
    beside: dict[tuple[str, str], set[frozenset[str]]] = defaultdict(set)
    named: list[tuple[ChannelInfo, tuple[str, str], frozenset[str]]] = []
    for channel in channels:
        where, pieces = _place(channel)
        beside[where].add(pieces)
        if "theta" in pieces:
            named.append((channel, where, pieces))
    found = set()
    for channel, where, pieces in named:
        passing = _PLAIN | _RATE if pieces & _RATE else _PLAIN
        alone = {next(iter(rest)) for each in beside[where] if len(rest := each - passing) == 1}
        if alone & _YAW or (alone & _ROLL and not {"x", "y"} <= alone):
            found.add(channel.name)
    return frozenset(found)


def _place(channel: ChannelInfo) -> tuple[tuple[str, str], frozenset[str]]:
    """Where a channel stands (its message and the path before its name), and the pieces of its name in small letters."""
    name = re.sub(r"\s*[\[(].*$", "", path_of(channel))
    cut = max(name.rfind(mark) for mark in "./\\:") + 1
    pieces = re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1_\2", name[cut:]).lower())
    return (channel.tags.get("topic", ""), name[:cut]), frozenset(pieces)


def doubts(
    channel: ChannelInfo, signal: str, key: Collection[str], pitches: Collection[str]
) -> Iterator[str]:
    """Why a channel that is named like a signal may be none. key: the words it was known by; pitches: of `attitudes`."""
    _, pieces = _place(channel)
    words = set(words_of(path_of(channel), load_names()))
    if signal in ("pitch", "pitch_rate") and "theta" in pieces and channel.name not in pitches:
        yield "theta is a heading in many logs, and neither psi nor phi without x and y stands beside it"
    if signal in ("roll", "pitch") and words & {"road", "lane"}:
        yield f"the road's {signal}, not the body's"
    if set(key) in ({"velocity", "x"}, {"speed", "x"}) and not words & _OWN_FRAME:
        yield "along which x? map it where that is the vehicle's own axis and not the world's"
    if SIGNALS[signal].quantity == "speed" and re.search(r"(^|[./\\_ ])acc(?![a-z])", channel.name.lower()):
        yield "'acc' before a speed is cruise control: not a measurement"
