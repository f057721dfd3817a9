"""Elements of lists: `wheels[0].speed` is one wheel's and no vehicle's. Which wheel it is, the log says, or nobody."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cache

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.mapping.match import Refusal
from parsers.mapping.words import known_words, load_names, words_of
from parsers.signals import WHEELS

ELEMENT = "element"
"""The tag of what a log calls the element of a list that a channel belongs to."""

_OF_AN_OBJECT = re.compile(r"\[\d+\](?=[./])")
_AT_THE_END = re.compile(r"\[(\d+)\]$")
_BETWEEN = re.compile(r"[,;/|>\n]+|\band\b")
"""Between the names of a list: "front left, front right and ..."."""
_INDEX = re.compile(r"\[\d+\]")
_CORNERS = frozenset({"wheel", "tire", "tyre", "corner", "axle", "suspension", "damper", "spring"})
"""Of what there is one at each wheel or axle: a list of these is no list of the vehicle's own quantities."""
_BEHIND = 70
"""What is added to the rank of a list's element: more than a profile's and a name's differ by, so that a plain channel comes first."""


def wheel_of(channel: ChannelInfo) -> str | None:
    """The wheel that the log names as the one that a list's element belongs to; None where it names none.

    A comment that lists the wheels in their order ("travel, fl, fr, rl, rr [m]") names those of a list.
    """
    named = _wheel(channel.tags.get(ELEMENT, ""))
    place = _AT_THE_END.search(channel.name) if named is None and channel.comment else None
    if place is None:
        return named
    listed = wheels_in_order(channel.comment)
    return listed[int(place[1])] if int(place[1]) < len(listed) else None


@cache
def wheels_in_order(text: str) -> tuple[str, ...]:
    """The four wheels in the order in which a text lists them; none where it does not list all of them, once each."""
    table = load_names()
    pieces = [{*words_of(piece, table)} & {*WHEELS} for piece in _BETWEEN.split(text)]
    if any(len(piece) > 1 for piece in pieces):
        listed = [word for word in words_of(text, table) if word in WHEELS]
    else:
        listed = [wheel for piece in pieces for wheel in piece]
    return tuple(listed) if sorted(listed) == sorted(WHEELS) else ()


@cache
def _wheel(text: str) -> str | None:
    if not text:
        return None
    table = load_names()
    words = words_of(text, table)
    wheels = {*words} & {*WHEELS}
    return wheels.pop() if len(wheels) == 1 and not known_words(words, table.blocked) else None


def element_texts(channel: ChannelInfo, wheel: str, parts: list[str]) -> list[str]:
    """What to look up for an element of a known wheel: its name with the wheel's, and so with its topic's last parts.

    parts: of its path.
    """
    plain = [_INDEX.sub("", part) for part in parts]
    topic = [part for part in channel.tags.get("topic", "").split("/") if part]
    paths = [plain[-size:] for size in (3, 2) if len(plain) >= size]
    paths += [[*topic[-size:], *plain[-1:]] for size in (2, 1) if topic]
    paths += [plain[-1:], plain]
    return list(dict.fromkeys(" ".join([wheel, *path]) for path in paths if path))


def of_elements(channel: ChannelInfo, found: Iterable[Binding | Refusal]) -> Iterator[Binding | Refusal]:
    """What a channel could be, where it is a list's element: a wheel's is nothing of the vehicle's, any other comes behind plain channels."""
    wheel = wheel_of(channel)
    field = channel.tags.get("field", "")
    inside = _OF_AN_OBJECT.search(field)
    if wheel is None and inside is None:
        yield from found
        return
    corners = _corners(channel, field[: inside.start()] if inside else "")
    for each in found:
        if each.signal.rpartition("_")[2] in ((wheel,) if wheel else WHEELS):
            yield _named(each, channel) if wheel else each
        elif wheel:
            yield Refusal(
                channel_of(each),
                each.signal,
                f"of the wheel {_name_in(channel)!r}, and not the vehicle's",
            )
        elif corners:
            reason = f"of one {min(corners)} of a list, and not the vehicle's: which, the log does not say"
            yield Refusal(channel_of(each), each.signal, reason)
        else:
            yield replace(each, rank=each.rank + _BEHIND) if isinstance(each, Binding) else each


def only_a_place(channel: ChannelInfo) -> bool:
    """Whether a channel is one of a list of numbers that nobody names: the list's name does not tell what this one is (`speed[2]`)."""
    return _AT_THE_END.search(channel.tags.get("field", "")) is not None and wheel_of(channel) is None


def of_corners(channel: ChannelInfo) -> bool:
    """Whether a channel's path says that it is of what there is at each wheel."""
    return bool(known_words(words_of(channel.name, load_names()), _CORNERS))


def _corners(channel: ChannelInfo, path: str) -> frozenset[str]:
    topic = channel.tags.get("topic", "").rstrip("/").rpartition("/")[2]
    return known_words(words_of(f"{topic} {path}", load_names()), _CORNERS)


def channel_of(found: Binding | Refusal) -> str:
    """The channel that a finding is about."""
    return found.channels[0] if isinstance(found, Binding) else found.channel


def _named(found: Binding | Refusal, channel: ChannelInfo) -> Binding | Refusal:
    """What was found, with where the wheel's name is from."""
    if isinstance(found, Refusal):
        return found
    return replace(found, rule=f"{found.rule}, which the log calls {_name_in(channel)!r}")


def _name_in(channel: ChannelInfo) -> str:
    """How the log calls the wheel of an element."""
    return channel.tags.get(ELEMENT) or wheel_of(channel) or ""
