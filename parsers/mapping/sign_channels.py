"""Magnitudes whose sign is a channel of its own: "SteeringWheelAngle" beside "SteeringWheelAngle_Sign", "X" beside "X_VZ".

A profile or a mapping file says so outright; elsewhere the name does. Which way round the sign is meant is seen by the checks.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.signals import SIGNALS

_SIGN = frozenset(("sign", "vz", "vorzeichen", "signum", "sgn"))
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")


def _own_name(channel: ChannelInfo) -> str:
    """Without the message or topic that its group stands for."""
    return (
        channel.tags.get("signal") or channel.tags.get("field") or channel.tags.get("column") or channel.name
    )


def _without_sign(channel: ChannelInfo) -> tuple[str, ...] | None:
    """The words of the magnitude's name; None where the channel is no sign by its name."""
    words = _words(channel)
    left = tuple(word for word in words if word not in _SIGN)
    return left if left and len(left) == len(words) - 1 else None


def _words(channel: ChannelInfo) -> tuple[str, ...]:
    return tuple(word.casefold() for word in _WORDS.findall(_own_name(channel)))


def _has_sides(signal: str) -> bool:
    """Whether the signal goes as far below zero as above it (a brake pressure's offset may have it go there a little)."""
    return SIGNALS[signal].low <= -0.5 * SIGNALS[signal].high


def with_signs(
    proposals: Mapping[str, tuple[Binding, ...]], channels: Sequence[ChannelInfo]
) -> dict[str, tuple[Binding, ...]]:
    """The proposals, where a channel's name says that it is the sign of another of its group with that sign."""
    signs = {
        (channel.group, words): channel.name
        for channel in channels
        if channel.kind == "number" and (words := _without_sign(channel)) is not None
    }
    if not signs:
        return dict(proposals)
    known = {channel.name: channel for channel in channels}

    def signed(binding: Binding) -> Binding:
        main = known[binding.channels[0]]
        sign = signs.get((main.group, _words(main)))
        if sign is None or binding.sign_channel is not None or not _has_sides(binding.signal):
            return binding
        return replace(binding, sign_channel=sign, rule=f"{binding.rule}, sign by {sign!r}")

    return {
        name: tuple(signed(each) if each.kind == "scale" else each for each in bindings)
        for name, bindings in proposals.items()
    }
